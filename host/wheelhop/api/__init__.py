"""What users call from Python, and the commands call too: read, compare, diagnose, add, predict,
detectable, plan, plot, simulate, tune, export, load."""

from wheelhop.api.exporting import export
from wheelhop.api.planning import detectable, plan
from wheelhop.api.plot import plot
from wheelhop.api.predicting import predict
from wheelhop.api.reading import read, read_log, read_model, read_recording, read_vehicle
from wheelhop.api.results import ComparisonResult, DiagnosisResult
from wheelhop.api.saving import load
from wheelhop.api.simulating import simulate
from wheelhop.api.tuning import tune
from wheelhop.api.verbs import add, compare, diagnose
from wheelhop.predict.known_car import MODEL_FILE

__all__ = [
    "MODEL_FILE",
    "ComparisonResult",
    "DiagnosisResult",
    "add",
    "compare",
    "detectable",
    "diagnose",
    "export",
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
    "tune",
]
