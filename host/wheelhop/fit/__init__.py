"""Fit: the vehicle's numbers, and what every run leaves free, from the records."""

from wheelhop.fit.fit import Fit, RunFit, fit
from wheelhop.fit.parameters import (
    Free,
    effect_parameters,
    initial_model,
    run_parameters,
    vehicle_parameters,
)
from wheelhop.fit.start import find_start, seek_again
from wheelhop.fit.workshop import Bench, Workshop

__all__ = [
    "Bench",
    "Fit",
    "Free",
    "RunFit",
    "Workshop",
    "effect_parameters",
    "find_start",
    "fit",
    "initial_model",
    "run_parameters",
    "seek_again",
    "vehicle_parameters",
]
