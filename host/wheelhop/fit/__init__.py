"""Fit: the vehicle's numbers, and what every run leaves free, from the records."""

from wheelhop.fit.belief import BROAD
from wheelhop.fit.bench import Bench, Trial, Watch, Workshop
from wheelhop.fit.density import Explained, Noise, Spectrum, explained, find_density
from wheelhop.fit.derivatives import Move, moves
from wheelhop.fit.fit import CONVERGED_QUICK, fit, follow, foreseen, linearised, update
from wheelhop.fit.height_response import Ground
from wheelhop.fit.heights import Heights
from wheelhop.fit.parameters import (
    Free,
    effect_parameters,
    effect_run_parameters,
    initial_model,
    of_forces,
    run_parameters,
    vehicle_parameters,
)
from wheelhop.fit.placement import find_start, seek_again
from wheelhop.fit.probe import FitProbe
from wheelhop.fit.result import Fit, RunFit
from wheelhop.fit.rig_start import begin_component
from wheelhop.fit.spread import louder
from wheelhop.fit.work import OutOfBudget, Work

__all__ = [
    "BROAD",
    "CONVERGED_QUICK",
    "Bench",
    "Explained",
    "Fit",
    "FitProbe",
    "Free",
    "Ground",
    "Heights",
    "Move",
    "Noise",
    "OutOfBudget",
    "RunFit",
    "Spectrum",
    "Trial",
    "Watch",
    "Work",
    "Workshop",
    "begin_component",
    "effect_parameters",
    "effect_run_parameters",
    "explained",
    "find_density",
    "find_start",
    "fit",
    "follow",
    "foreseen",
    "initial_model",
    "linearised",
    "louder",
    "moves",
    "of_forces",
    "run_parameters",
    "seek_again",
    "update",
    "vehicle_parameters",
]
