"""What a guest calls from Python, and the commands call too: read, compare, diagnose, add,
detectable, plan, plot, simulate."""

from wheelhop.api.planning import detectable, plan
from wheelhop.api.plot import plot
from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.api.simulating import simulate
from wheelhop.api.verbs import (
    MODEL_FILE,
    add,
    compare,
    diagnose,
    read,
    read_log,
    read_recording,
    read_vehicle,
)

__all__ = [
    "MODEL_FILE",
    "ComparisonResult",
    "DiagnosisResult",
    "add",
    "compare",
    "detectable",
    "diagnose",
    "plan",
    "plot",
    "read",
    "read_log",
    "read_recording",
    "read_vehicle",
    "simulate",
]
