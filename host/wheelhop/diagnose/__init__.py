"""Diagnosis: which physics a model is missing."""

from wheelhop.diagnose.baseline import Baseline, axle_driven, comparison_of, fit_baseline
from wheelhop.diagnose.diagnosis import Diagnosis, Limit, Ranked, Step, to_json
from wheelhop.diagnose.next_run import NextRun
from wheelhop.diagnose.score import Rung
from wheelhop.diagnose.search.ladder import climb, diagnose
from wheelhop.diagnose.verdict.ranking import caveats
from wheelhop.files import Progress

__all__ = [
    "Baseline",
    "Diagnosis",
    "Limit",
    "NextRun",
    "Progress",
    "Ranked",
    "Rung",
    "Step",
    "axle_driven",
    "caveats",
    "climb",
    "comparison_of",
    "diagnose",
    "fit_baseline",
    "to_json",
]
