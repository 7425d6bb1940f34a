"""What lies between axle and body: whether it is linear, and what was identified of it beside the
physical model."""

from __future__ import annotations

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS, Campaign
from wheelhop.diagnose import Step
from wheelhop.files.words import listed, percent
from wheelhop.identify import Linearity, TransferMatrix
from wheelhop.identify.physical import physical_matrix
from wheelhop.identify.structure import input_name
from wheelhop.report import tables
from wheelhop.report.figures import AFTER, BEFORE, INK, MEASURED, WIDTH
from wheelhop.report.page import figure, paragraph, section
from wheelhop.report.svg import STYLE, Drawing, inline
from wheelhop.simulate import Model

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

LINES = 240
TICKS = (0.5, 1, 2, 5, 10, 20, 50)
LEAST = 0.003
"""Of |H|: less is of no account beside the noise."""


def axle_to_body(found: Linearity | None, campaign: Campaign, steps: Sequence[Step]) -> str:
    """The section; empty where it was not asked."""
    if found is None:
        return ""
    parts = [paragraph(found.sentence)]
    if found.model is not None:
        drawing = matrix_figure(found.model, campaign, linear_models(steps))
        words = "identified and modelled transfer functions from axles to body"
        parts.append(figure(inline(drawing, "axles", words), _caption(steps)))
    if found.levels:
        shares = listed([percent(float(share), 4) for share in found.coherence])
        said = f"Of the power at B1, B2, B3 and B4 in held-out runs it explains {shares}."
        alike = "What is linear errs alike at every level, noise apart."
        parts += [paragraph(f"{said} {alike}"), tables.level_table(found.levels)]
    return section("Linear between axle and body?", *parts)


def matrix_figure(
    model: TransferMatrix, campaign: Campaign, models: Sequence[tuple[str, str, Model]]
) -> Drawing:
    """Magnitude from each axle to each body point: as identified, and of physical models, each with
    its name and its colour."""
    low, high = campaign.band_hz
    frequency = np.geomspace(low, high, LINES)
    s = 2j * np.pi * frequency
    identified, doubt = np.abs(model(s)), 2 * model.standard_error(s)
    physical = [
        (name, colour, np.abs(physical_matrix(campaign.channels, one, model, frequency)))
        for name, colour, one in models
    ]
    top = 1.6 * max(float(np.nanmax(h)) for h in (identified, *(h for _, _, h in physical)))
    with mpl.rc_context(STYLE):
        drawing = Drawing(figsize=(WIDTH, 6.6), layout="constrained")
        panels = drawing.subplots(*identified.shape[1:], sharex=True, sharey=True, squeeze=False)
        for (i, j), axes in np.ndenumerate(panels):
            h, error = identified[:, i, j], doubt[:, i, j]
            axes.fill_between(
                frequency, np.maximum(h - error, LEAST), h + error, color=MEASURED, alpha=0.4, lw=0
            )
            axes.plot(frequency, h, color=INK, linewidth=2.2, label="identified")
            for name, colour, values in physical:
                axes.plot(frequency, values[:, i, j], color=colour, linewidth=1.2, label=name)
            axes.set_title(f"{input_name(model.inputs[j])} → {BODY_POINTS[model.outputs[i]]}")
            _scale(axes, frequency, top)
            if i == len(panels) - 1:
                axes.set_xlabel("frequency, Hz")
            if j == 0:
                axes.set_ylabel("|H|")
        handles = panels[0, 0].get_legend_handles_labels()
        drawing.legend(*handles, loc="outside upper left", ncols=3)
    return drawing


def _scale(axes: Axes, frequency: Array, top: float) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(frequency[0], frequency[-1])
    axes.set_ylim(LEAST, top)
    ticks = [f for f in TICKS if frequency[0] <= f <= frequency[-1]]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()


def linear_models(steps: Sequence[Step]) -> list[tuple[str, str, Model]]:
    """The baseline, and the last model if it has more and all of that is linear; each with its name
    and its colour."""
    out = [("baseline, fitted", BEFORE, steps[0].rung.model)]
    if len(steps) > 1 and not _bent(steps[-1]):
        out.append((f"with {' + '.join(steps[-1].added)}", AFTER, steps[-1].rung.model))
    return out


def _bent(step: Step) -> bool:
    """Whether the model has force laws, which no transfer function holds."""
    return bool(len(step.rung.model.system((), "axles").port))


def _caption(steps: Sequence[Step]) -> str:
    words = (
        "Motion of each body point per motion of each axle. The band about the identified one is"
        " twice its standard error; where it is not seen it is narrower than the line."
    )
    if len(steps) > 1 and _bent(steps[-1]):
        added = " + ".join(steps[-1].added)
        words += f" With {added} the model is not linear and has no transfer function to show."
    return words
