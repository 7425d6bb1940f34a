"""Tuning: which settings of a known car are best on the roads it drives, and how sure that is."""

from wheelhop.tune.objectives import OBJECTIVES, Objective
from wheelhop.tune.tuning import Cost, Gain, Setting, Tuning, tune_car
from wheelhop.tune.variables import Freedom, Variable, read_freedom

__all__ = [
    "OBJECTIVES",
    "Cost",
    "Freedom",
    "Gain",
    "Objective",
    "Setting",
    "Tuning",
    "Variable",
    "read_freedom",
    "tune_car",
]
