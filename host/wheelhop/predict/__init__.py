"""Prediction: what a vehicle would do and show on tracks nobody has driven yet."""

from wheelhop.predict.case import Case
from wheelhop.predict.drives import Chosen, Drive, read_drives, read_effects, read_speeds
from wheelhop.predict.make import Instrument, make_campaign, make_recording

__all__ = [
    "Case",
    "Chosen",
    "Drive",
    "Instrument",
    "make_campaign",
    "make_recording",
    "read_drives",
    "read_effects",
    "read_speeds",
]
