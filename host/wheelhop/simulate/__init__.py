"""Simulation: what a model says a run should have measured."""

from wheelhop.simulate.folding import folded_power, sample_of
from wheelhop.simulate.frequency import frequency_response
from wheelhop.simulate.model import Model
from wheelhop.simulate.prescribed import climbing
from wheelhop.simulate.rig import RigSimulator
from wheelhop.simulate.run import Response, RunSimulator
from wheelhop.simulate.simulator import Simulator, drive_of, make_simulator
from wheelhop.simulate.unevenness import HeightSeries, slowness

__all__ = [
    "HeightSeries",
    "Model",
    "Response",
    "RigSimulator",
    "RunSimulator",
    "Simulator",
    "climbing",
    "drive_of",
    "folded_power",
    "frequency_response",
    "make_simulator",
    "sample_of",
    "slowness",
]
