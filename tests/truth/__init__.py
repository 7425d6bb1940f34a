"""Measured campaigns whose truth is known: an independent simulator for tests and benchmarks.

Built on MuJoCo; shares no code with the package it tests.
"""

from .campaign import Truth, forget_tracks, in_band, make_campaign, read_truth, write_campaign
from .effects import known_ids, make_effect, make_effects
from .model import CHANNELS, Motion, Run, integrate, simulate_run
from .presets import PRESETS, Preset
from .sensors import SENSORS, Sensor, sense
from .tracks import Track

__all__ = [
    "CHANNELS",
    "PRESETS",
    "SENSORS",
    "Motion",
    "Preset",
    "Run",
    "Sensor",
    "Track",
    "Truth",
    "forget_tracks",
    "in_band",
    "integrate",
    "known_ids",
    "make_campaign",
    "make_effect",
    "make_effects",
    "read_truth",
    "sense",
    "simulate_run",
    "write_campaign",
]
