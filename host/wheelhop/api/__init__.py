"""What a guest calls from Python, and the commands call too: read, compare, diagnose, add,
plan, plot, simulate, tune,
export."""

from wheelhop.api.exporting import export
from wheelhop.api.planning import plan
from wheelhop.api.plot import plot
from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.api.simulating import simulate
from wheelhop.api.tuning import tune
from wheelhop.api.verbs import (
    add,
    compare,
    diagnose,
    read,
    read_log,
    read_recording,
    read_vehicle,
)
from wheelhop.predict.known_car import MODEL_FILE

__all__ = [
    "MODEL_FILE",
    "ComparisonResult",
    "DiagnosisResult",
    "add",
    "compare",
    "diagnose",
    "export",
    "plan",
    "plot",
    "read",
    "read_log",
    "read_recording",
    "read_vehicle",
    "simulate",
    "tune",
]
