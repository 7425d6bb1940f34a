"""Effects: the physics and the measurement faults a baseline model leaves out."""

from wheelhop.effects.base import (
    Effect,
    OwnValues,
    Parameter,
    Place,
    Probe,
    RunSetting,
    form_of,
    law,
)
from wheelhop.effects.beliefs import beliefs
from wheelhop.effects.library import Given, More, load_effects, pick

__all__ = [
    "Effect",
    "Given",
    "More",
    "OwnValues",
    "Parameter",
    "Place",
    "Probe",
    "RunSetting",
    "beliefs",
    "form_of",
    "law",
    "load_effects",
    "pick",
]
