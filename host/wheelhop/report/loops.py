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
from wheelhop.report.stretch import farthest, seconds_of
from wheelhop.report.svg import STYLE, Drawing
from wheelhop.vehicle import Motion

Array = NDArray[np.float64]

ROWS = 3
"""Runs shown: that of the largest travel, the fastest one, and the smallest travel."""

PART = 1.0 / 20.0
"""Of a wave, over which a speed is taken: that of a sine comes out 0.4 % small, and steps of the
displacement and its noise are averaged."""

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
            x, v, force = (each[part] for each in draw[0][0])
            row[0].set(xlim=_around(1e3 * x), ylim=_around(force))
            row[1].set_xlim(*_around(v))
            row[0].set_title(run.id, loc="left")
            row[0].set_ylabel("force, N")
            row[0].yaxis.set_major_locator(MaxNLocator(5))
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=3)
        panels[-1, 0].set_xlabel("displacement, mm")
        panels[-1, 1].set_xlabel("velocity, m/s")
    return figure


def _around(values: Array) -> tuple[float, float]:
    """Limits that hold what was measured, and a quarter more of what models do either way."""
    low, high = float(values.min()), float(values.max())
    return 1.25 * low - 0.25 * high, 1.25 * high - 0.25 * low


def loop_of(
    campaign: ComponentCampaign, run: RigRun, record: Record, answer: Array, mass_kg: float
) -> tuple[Array, Array, Array]:
    """Displacement, velocity and force (T,). Where a force is imposed up to the end of the band,
    and the force without the inertia of a mass: what remains is the component's law."""
    band = record.band
    shown = band.from_coefficients(answer[:, 0]) - band.from_coefficients(record.measured[:, 0])
    if campaign.drive == "displacement":
        x = Motion(campaign, run).at(run.time_s)[0]
        return x, speed_of(x, campaign.sample_rate_hz), np.asarray(run.force + shown)
    top_hz = band.frequency_hz[-1]
    x, v, a = _moved(run.displacement + shown, campaign.sample_rate_hz, top_hz)
    force = _moved(run.force, campaign.sample_rate_hz, top_hz)[0]
    return x, v, np.asarray(force - mass_kg * a)


def speed_of(x: Array, rate_hz: float) -> Array:
    """Speed (n,), m/s, by differences over a part of a wave."""
    half = max(round(0.5 * seconds_of(x, rate_hz, PART) * rate_hz), 1)
    half = min(half, (len(x) - 1) // 2)
    speed = np.empty_like(x)
    speed[half:-half] = (x[2 * half :] - x[: -2 * half]) * rate_hz / (2 * half)
    speed[:half], speed[-half:] = speed[half], speed[-half - 1]
    return speed


def _moved(x: Array, rate_hz: float, top_hz: float) -> tuple[Array, Array, Array]:
    """A signal (n,) up to a frequency and its two derivatives (FINER n,), with points between its
    samples. A cubic takes what jumps, in value or slope, where the record would begin anew; what
    still does rings less if frequencies fade out (C. Lanczos, Applied Analysis, 1956, IV.6)."""
    n, speed = len(x), speed_of(x, rate_hz)
    seconds, time_s = n / rate_hz, np.arange(n) / rate_hz
    rises, turns = x[-1] - x[0], speed[-1] - speed[0]
    rest = np.array([[seconds**2, seconds**3], [2.0 * seconds, 3.0 * seconds**2]])
    bend = np.linalg.solve(rest, [rises - speed[0] * seconds, turns])
    cubic = np.polynomial.Polynomial([x[0], speed[0], *bend])
    lines = np.fft.rfft(x - cubic(time_s))
    omega = 2 * np.pi * np.fft.rfftfreq(n, 1.0 / rate_hz)
    lines *= 0.5 + 0.5 * np.cos(np.minimum(0.5 * omega / top_hz, np.pi))
    finer = np.arange(FINER * n) / (FINER * rate_hz)
    found = (
        FINER * np.fft.irfft(lines * (1j * omega) ** k, FINER * n) + cubic.deriv(k)(finer)
        for k in range(3)
    )
    x, v, a = (np.asarray(each) for each in found)
    return x, v, a
