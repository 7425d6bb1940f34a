"""What users call from Python, and the commands call too: read, compare, diagnose, add, predict,
plan, plot, simulate, load."""

from wheelhop.api.planning import plan
from wheelhop.api.plot import plot
from wheelhop.api.predicting import predict
from wheelhop.api.reading import read, read_log, read_model, read_recording, read_vehicle
from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.api.saving import load
from wheelhop.api.simulating import simulate
from wheelhop.api.verbs import MODEL_FILE, add, compare, diagnose

__all__ = [
    "MODEL_FILE",
    "ComparisonResult",
    "DiagnosisResult",
    "add",
    "compare",
    "diagnose",
    "load",
    "plan",
    "plot",
    "predict",
    "read",
    "read_log",
    "read_model",
    "read_recording",
    "read_vehicle",
    "simulate",
]
