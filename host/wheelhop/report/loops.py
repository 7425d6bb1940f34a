"""A rig's loops: force over displacement and over velocity, measured and modelled."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from wheelhop.campaign import ComponentCampaign, RigRun
from wheelhop.compare import Record
from wheelhop.diagnose import Step
from wheelhop.report.cases import records_of
from wheelhop.report.figures import AFTER, BEFORE, MEASURED, WIDTH
from wheelhop.report.stretch import farthest
from wheelhop.report.svg import STYLE, Drawing
from wheelhop.vehicle import Motion

Array = NDArray[np.float64]

ROWS = 3
"""Runs shown: that of the largest travel, the fastest one, and the smallest travel."""

FINER = 4
"""Under a force as many points for every sample: a resonance has few samples in a wave."""


def shown_runs(campaign: ComponentCampaign) -> list[RigRun]:
    """Runs whose loops differ most, each once, the largest travel first."""
    runs = [run for run in campaign.runs if isinstance(run, RigRun)]

    def travel(run: RigRun) -> float:
        return float(np.ptp(run.displacement))

    def speed(run: RigRun) -> float:
        return float(np.abs(np.diff(run.displacement)).max())

    chosen = [max(runs, key=travel), max(runs, key=speed), min(runs, key=travel)]
    return list(dict.fromkeys(chosen))[:ROWS]


def loops_figure(campaign: ComponentCampaign, steps: Sequence[Step]) -> Drawing:
    """A row for each run shown: force over displacement, force over velocity."""
    runs = shown_runs(campaign)
    models = [(steps[0], BEFORE, "baseline")]
    models += [(steps[-1], AFTER, "last model")] if len(steps) > 1 else []
    with mpl.rc_context(STYLE):
        figure = Drawing(figsize=(WIDTH, 2.5 * len(runs) + 0.4), layout="constrained")
        panels = figure.subplots(len(runs), 2, sharey="row", squeeze=False)
        for row, run in zip(panels, runs, strict=True):
            measured = records_of(steps[-1].rung)[run.id]
            mass = steps[-1].rung.model.values["component.mass_kg"]
            draw = [
                (loop_of(campaign, run, measured, measured.measured, mass), MEASURED, "measured")
            ]
            for step, colour, name in models:
                record, own = records_of(step.rung)[run.id], step.rung.model.values
                loop = loop_of(campaign, run, record, record.model, own["component.mass_kg"])
                draw.append((loop, colour, name))
            finer = FINER if campaign.drive == "force" else 1
            part = farthest(draw[0][0][0], finer * campaign.sample_rate_hz)
            for (x, v, force), colour, name in draw:
                width = 2.4 if colour == MEASURED else 1.1
                for panel, along in zip(row, (1e3 * x, v), strict=True):
                    panel.plot(along[part], force[part], color=colour, linewidth=width, label=name)
            row[0].set_title(run.id, loc="left")
            row[0].set_ylabel("force, N")
            row[0].yaxis.set_major_locator(MaxNLocator(5))
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=3)
        panels[-1, 0].set_xlabel("displacement, mm")
        panels[-1, 1].set_xlabel("velocity, m/s")
    return figure


def loop_of(
    campaign: ComponentCampaign, run: RigRun, record: Record, answer: Array, mass_kg: float
) -> tuple[Array, Array, Array]:
    """Displacement, velocity and force (T,). Where a force is imposed all in band, and the force
    without the inertia of a mass: what remains is the component's law."""
    band = record.band
    if campaign.drive == "displacement":
        x, v, _ = Motion(campaign, run).at(run.time_s)
        beside = run.force - band.from_coefficients(record.measured[:, 0])
        return x, v, np.asarray(beside + band.from_coefficients(answer[:, 0]))
    omega = 2 * np.pi * np.fft.rfftfreq(band.n, 1.0 / band.rate_hz)
    moved = np.fft.rfft(band.from_coefficients(answer[:, 0]))
    x, v, a = (_finer(moved * (1j * omega) ** k, band.n) for k in range(3))
    force = _finer(np.fft.rfft(band.signal(run.force[:, None])[:, 0]), band.n)
    return x, v, np.asarray(force - mass_kg * a)


def _finer(spectrum: NDArray[np.complex128], n: int) -> Array:
    """The signal (FINER n,) of a spectrum, with points between its samples."""
    return np.asarray(FINER * np.fft.irfft(spectrum, FINER * n))
