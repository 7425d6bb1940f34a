"""Effects: the physics and the measurement faults a baseline model leaves out."""

from wheelhop.effects.base import (
    Effect,
    OwnValues,
    Place,
    Probe,
    RunSetting,
    form_of,
    law,
)
from wheelhop.effects.beliefs import TrackSurvey, beliefs
from wheelhop.effects.library import Given, More, load_effects, pick
from wheelhop.effects.parameters import Amplitude, Parameter, Shape, Switch
from wheelhop.effects.special import Misstatement, RandomHeights, Ringing, TiedRuns, WheelShape

__all__ = [
    "Amplitude",
    "Effect",
    "Given",
    "Misstatement",
    "More",
    "OwnValues",
    "Parameter",
    "Place",
    "Probe",
    "RandomHeights",
    "Ringing",
    "RunSetting",
    "Shape",
    "Switch",
    "TiedRuns",
    "TrackSurvey",
    "WheelShape",
    "beliefs",
    "form_of",
    "law",
    "load_effects",
    "pick",
]
