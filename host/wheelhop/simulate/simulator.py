"""What simulates a run: a vehicle on its track or on measured axles, or a component on a rig."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, ComponentCampaign, RigRun, Run
from wheelhop.effects import Effect, RunSetting
from wheelhop.simulate.measured import driven_by
from wheelhop.simulate.model import Model
from wheelhop.simulate.rig import RigSimulator
from wheelhop.simulate.run import Response, RunSimulator
from wheelhop.simulate.unevenness import HeightSeries
from wheelhop.vehicle import Drive, System


class Simulator(Protocol):
    """Everything about one run that does not change from simulation to simulation."""

    @property
    def campaign(self) -> Campaign:
        """The campaign the run belongs to."""

    @property
    def steps(self) -> int:
        """How many steps it has integrated so far, of all models."""

    @property
    def drive(self) -> Drive:
        """What moves the model."""

    @property
    def setting(self) -> RunSetting:
        """What effects may know of the run."""

    @property
    def period_m(self) -> float | None:
        """Length after which the run's track repeats; None if it does not, or is not known."""

    @property
    def series(self) -> HeightSeries | None:
        """The heights that may lie on top of the run's track; None where no wheel rolls."""

    def acts(self, effect: Effect) -> bool:
        """Whether the effect can act in this run."""

    def way(self, model: Model) -> NDArray[np.float64]:
        """Distance (n, 4), m, each wheel has come along the track at the run's samples."""

    def simulate(self, model: Model, system: System) -> Response:
        """Response of `model`, whose equations of motion for this run's drive are `system`."""

    def record(self, model: Model, system: System) -> NDArray[np.float64]:
        """What the instrument should have recorded (n, n_channels), in the channels' units."""

    def records(self, trials: Sequence[tuple[Model, System]]) -> list[NDArray[np.float64]]:
        """`record` for several models, each with its equations of motion."""

    def changes(
        self, base: tuple[Model, System], trials: Sequence[tuple[Model, System]]
    ) -> list[NDArray[np.float64]]:
        """By how much the records of several models differ from that of `base`, at less cost."""


def drive_of(campaign: Campaign, run: Run) -> Drive:
    """What moves the model in a run: on ground that is not known measured axles, or, where they are
    not measured, travel."""
    if isinstance(run, RigRun):
        return "rig"
    return driven_by(campaign, run)


def make_simulator(campaign: Campaign, run: Run, run_up_s: float) -> Simulator:
    """The simulator of a run; a vehicle drives for `run_up_s` before the first sample, so that its
    start is forgotten."""
    if isinstance(campaign, ComponentCampaign) and isinstance(run, RigRun):
        return RigSimulator(campaign, run)
    return RunSimulator(campaign, run, run_up_s)
