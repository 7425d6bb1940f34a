"""Effects: the physics and the measurement faults a baseline model leaves out."""

from wheelhop.effects.base import (
    Effect,
    OwnValues,
    Parameter,
    Place,
    Probe,
    RunSetting,
    law,
)
from wheelhop.effects.library import load_effects

__all__ = [
    "Effect",
    "OwnValues",
    "Parameter",
    "Place",
    "Probe",
    "RunSetting",
    "law",
    "load_effects",
]
