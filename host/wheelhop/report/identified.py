"""The page of an identified transfer matrix: its modes, its magnitudes, and what it predicts of the
body in every run (thesis figures 1.9 and 5.5 to 5.22)."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from wheelhop.campaign import Campaign
from wheelhop.files.words import percent, significant
from wheelhop.identify import Candidate, Predicted
from wheelhop.report.axle_to_body import matrix_figure
from wheelhop.report.figures import AFTER, BEFORE, MEASURED, WIDTH, log_axis
from wheelhop.report.page import bullets, figure, paragraph, section, table, title, write_page
from wheelhop.report.stretch import worst_stretch
from wheelhop.report.svg import STYLE, Drawing, inline
from wheelhop.simulate import Model

Array = NDArray[np.float64]

DECADES = 6
"""Less than so many powers of ten below the highest density is not shown."""


def write_identified_report(
    path: Path,
    campaign: Campaign,
    chosen: Candidate,
    nominal: Model,
    predicted: Sequence[Predicted],
    said: Sequence[str],
) -> None:
    """Write it as one self-contained HTML page, or as PDF. `said` are sentences on the matrix;
    raises InputError."""
    matrix = matrix_figure(chosen.model, campaign, [("vehicle.toml", BEFORE, nominal)])
    caption = (
        "Motion of each body point per motion of each axle; the band is twice the standard error."
    )
    body = [
        paragraph(f"wheelhop identify · {campaign.title}", "kicker"),
        title("What the axles do to the body"),
        section("The matrix", bullets(said), _modes(chosen)),
        section("From each axle to each point", figure(inline(matrix, "h", "|H|"), caption)),
        *predictions(campaign, predicted),
    ]
    write_page(path, f"{campaign.title}: axles to body", body)


def predictions(
    campaign: Campaign, predicted: Sequence[Predicted], *, folded: bool = False
) -> list[str]:
    """Sections: the errors of all runs, and track by track the runs' figures, each `folded` under
    its line or not."""
    by_track: dict[str, list[Predicted]] = {}
    kinds = {run.id: run.track.kind for run in campaign.runs}
    for one in predicted:
        by_track.setdefault(kinds[one.run], []).append(one)
    return [
        section("Predicted and measured", paragraph(WORDS), _errors(predicted)),
        *(
            section(kind, *(_run(one, f"run-{kind}-{i}", folded) for i, one in enumerate(runs)))
            for kind, runs in by_track.items()
        ),
    ]


def _run(one: Predicted, name: str, folded: bool) -> str:
    said = f"{one.run}, {_role(one)}: error {percent(_overall(one), 2)}."
    drawing = inline(run_figure(one), name, f"{one.run}, predicted")
    if folded:
        return f"<details><summary>{escape(said)}</summary>{figure(drawing, '')}</details>"
    return figure(drawing, said)


WORDS = (
    "The error at each point is what is left over what was measured; in brackets, what the sensors’"
    " noise and the doubt about H leave. Predicted is each run’s motion of the axles through H, and"
    " how the run began rings down: no track, no speed and no tyre is in it. Measured and predicted"
    " differ by no more than the bands in 95 % of all lines, if what lies between axle and body is"
    " linear."
)
"""What the page says of its predictions."""


def run_figure(run: Predicted) -> Drawing:
    """A run's outputs, measured and predicted: spectra above, below the 2.5 s with most left."""
    with mpl.rc_context(STYLE):
        drawing = Drawing(figsize=(WIDTH, 3.6), layout="constrained")
        panels = drawing.subplots(2, len(run.points), sharey="row", squeeze=False)
        draw_spectra(panels[0], run)
        draw_times(panels[1], run)
        handles, labels = panels[0, 0].get_legend_handles_labels()
        drawing.legend(handles, labels, loc="outside upper left", ncols=3)
    return drawing


def draw_spectra(panels: Sequence[Axes], run: Predicted) -> None:
    """Power density of each output into axes that are there."""
    frequency, measured = run.frequency_hz, run.density(run.measured)
    modelled, size = run.density(run.predicted), np.abs(run.predicted)
    # |x|² of a complex number whose parts are normal: within 2.45 deviations in 95 %.
    away = np.sqrt(-2.0 * np.log(0.05)) * run.doubt
    high = run.density((size + away).astype(complex))
    low = run.density(np.maximum(size - away, 0.0).astype(complex))
    top = 3 * float(max(measured.max(), modelled.max()))
    for i, axes in enumerate(panels):
        least = top / 10**DECADES
        axes.fill_between(
            frequency, np.maximum(low[:, i], least), np.maximum(high[:, i], least), lw=0, **BAND
        )
        axes.plot(frequency, measured[:, i], color=MEASURED, linewidth=2.2, label="measured")
        axes.plot(frequency, modelled[:, i], color=AFTER, linewidth=0.9, label="predicted")
        axes.set_title(run.points[i])
        log_axis(axes, least, top)
        log_axis(axes, float(frequency[0]), float(frequency[-1]), "x")
        axes.set_xlabel("frequency, Hz")
    panels[0].set_ylabel("(m/s²)²/Hz")


BAND: dict[str, Any] = {"color": AFTER, "alpha": 0.18, "label": "95 % of noise and doubt"}


def draw_times(panels: Sequence[Axes], run: Predicted) -> None:
    """Each output against time, in the stretch with the largest residual."""
    measured, modelled = run.signal(run.measured), run.signal(run.predicted)
    time_s = run.time_s
    left = measured - modelled
    loudest = measured[:, np.argmax(np.sum(measured**2, axis=0))]
    part = worst_stretch(loudest, np.linalg.norm(left, axis=1), run.rate_hz)
    for i, axes in enumerate(panels):
        axes.plot(time_s[part], measured[part, i], color=MEASURED, linewidth=2.2)
        axes.plot(time_s[part], modelled[part, i], color=AFTER, linewidth=0.9)
        axes.set_xlim(time_s[part][0], time_s[part][-1])
        axes.set_xlabel("time, s")
    panels[0].set_ylabel("m/s²")


def _role(run: Predicted) -> str:
    return "held out" if run.held_out else "fitted"


def _overall(run: Predicted) -> float:
    power = np.sum(np.abs(run.measured) ** 2, axis=0)
    return float(np.sqrt((run.error**2 * power).sum() / power.sum()))


def _errors(predicted: Sequence[Predicted]) -> str:
    points = predicted[0].points
    rows = [
        (
            escape(one.run),
            _role(one),
            *(
                f"{percent(float(error), 2)} ({percent(float(floor), 2)})"
                for error, floor in zip(one.error, one.expected, strict=True)
            ),
        )
        for one in predicted
    ]
    return table(("run", "", *points), rows, "ll" + "r" * len(points))


def _modes(chosen: Candidate) -> str:
    rows = [
        (
            f"{significant(f, 4)} ± {significant(df, 1)}",
            f"{significant(z, 3)} ± {significant(dz, 1)}",
        )
        for f, df, z, dz in sorted(chosen.model.poles_table())
    ]
    return table(("frequency, Hz", "damping ratio"), rows, "rr")
