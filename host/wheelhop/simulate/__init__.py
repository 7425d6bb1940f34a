"""Simulation: what a model says a run should have measured."""

from wheelhop.simulate.frequency import frequency_response, linear_response
from wheelhop.simulate.model import Model
from wheelhop.simulate.run import Response, RunSimulator

__all__ = ["Model", "Response", "RunSimulator", "frequency_response", "linear_response"]
