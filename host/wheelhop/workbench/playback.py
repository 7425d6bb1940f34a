"""A run played back: the vehicle from the side drives over its track, measured and modelled."""

from __future__ import annotations

import json
from math import isfinite
from typing import Any

import numpy as np
from nicegui import ui
from numpy.typing import NDArray

from wheelhop.campaign import Run
from wheelhop.track import make_track
from wheelhop.workbench.shown import Rung, Samples, Shape, Signals
from wheelhop.workbench.view import html

SIDES = {"left": ("1", "3"), "right": ("2", "4")}
"""The points of either side, front and rear."""
BODY_RADII = 2.0  # of a wheel: so high stands the body where it is drawn at rest
SHOWN_M = 0.3  # of the drawing's height, for the largest motion
EXAGGERATIONS = (1, 2, 5, 10, 20, 50)
END_S = 1.0
STEP_M = 0.01
DIGITS, PLACE_DIGITS = 4, 6

PARTS = """\
<div class="playback"><canvas data-part="canvas" role="img"
aria-label="the vehicle over its track, measured and modelled"></canvas>
<div class="bench-controls playback-controls">
<button class="primary" data-part="toggle">Play</button>
<input type="range" min="0" step="0.01" value="0" data-part="time" aria-label="time, s">
<span data-part="clock"></span>
<label>pace <select data-part="pace"><option value="1">as it was</option>
<option value="0.5">half</option><option value="0.2" selected>a fifth</option>
<option value="0.05">a twentieth</option></select></label></div></div>
"""


class Playback:
    """The drawing and its controls; everything moves in the browser."""

    def __init__(self) -> None:
        with ui.element("section").classes("playback-section") as self.section:
            self._words = ui.label().classes("soft")
            self._parts = html(PARTS)

    def show(self, run: Run, rung: Rung | None, side: str) -> None:
        """Have a run ready to be played, as a rung models it."""
        scene = None if rung is None else scene_of(run, rung, side)
        self._parts.set_visibility(scene is not None)
        if scene is None:
            self._words.set_text("Nothing to play back: it takes one run, its model and its place.")
            return
        times = scene["exaggeration"]
        size = "to scale" if times == 1 else f"drawn {times} times as large as they were"
        self._words.set_text(f"Seen from the {side}; ground and motion in band, heights {size}.")
        root = f"getHtmlElement({self._parts.id}).querySelector('.playback')"
        self._parts.client.run_javascript(
            f"requestAnimationFrame(() => wheelhop.playback({root}, {json.dumps(scene)}))"
        )


def scene_of(run: Run, rung: Rung, side: str) -> dict[str, Any] | None:
    """Everything to draw, for the browser; None where the run has no place on a track or no point
    of this side is modelled."""
    signals = rung.signals.get(run.id)
    if rung.shape is None or signals is None:
        return None
    kept = slice(*_kept(len(signals.measured), signals.rate_hz))
    measured = _heights(signals, signals.measured_m[kept], rung, side)
    modelled = _heights(signals, signals.modelled_m[kept], rung, side)
    if not any(part for end in measured.values() for part in end.values()):
        return None
    time_s = np.arange(len(signals.measured)) / signals.rate_hz
    where = signals.position_m
    position = (time_s * run.speed_m_s if where is None else where)[kept]
    shape = rung.shape
    first, ground = _ground(run, position, shape, side)
    heights = [y for view in (measured, modelled) for end in view.values() for y in end.values()]
    return {
        "rate_hz": signals.rate_hz,
        "start_s": kept.start / signals.rate_hz,
        "position_m": _short(position, PLACE_DIGITS),
        "ground_from_m": first,
        "ground_step_m": STEP_M,
        "ground_m": _short(ground),
        "wheelbase_m": shape.wheelbase_m,
        "radius_m": shape.radius_m,
        "body_m": BODY_RADII * shape.radius_m,
        "exaggeration": _exaggeration([*heights, list(ground)]),
        "views": [
            {"name": "measured", "colour": "ink", **measured},
            {"name": _name(rung), "colour": "after", **modelled, "behind": measured},
        ],
    }


def _kept(count: int, rate_hz: float) -> tuple[int, int]:
    """The samples that are played: not the ends, where what is in band is that of both."""
    margin = round(min(END_S * rate_hz, count / 8))
    return margin, count - margin


def _heights(
    signals: Signals, heights: Samples, rung: Rung, side: str
) -> dict[str, dict[str, list[float]]]:
    """Heights, m, of axle and body, front and rear, as far as the model predicts them."""
    found: dict[str, dict[str, list[float]]] = {"axle": {}, "body": {}}
    for end, number in zip(("front", "rear"), SIDES[side], strict=True):
        for part, letter in (("axle", "A"), ("body", "B")):
            point = f"{letter}{number}"
            column = next((k for k, p in enumerate(rung.points) if p == point), None)
            if column is not None and signals.measured[:, column].any():
                found[part][end] = _short(heights[:, column])
    return found


def _ground(
    run: Run, position_m: NDArray[Any], shape: Shape, side: str
) -> tuple[float, NDArray[Any]]:
    """Where the ground drawn begins, m, and its heights, m, in steps of STEP_M."""
    margin = shape.wheelbase_m + 2.0
    first, last = float(position_m.min()) - 2 * margin, float(position_m.max()) + margin
    if run.track.kind == "unknown" or not (isfinite(first) and isfinite(last)):
        return first, np.zeros(0)
    x = np.arange(first, last, STEP_M)
    across = shape.track_width_m / 2 * (1 if side == "left" else -1)
    return first, make_track(run.track).elevation(x, across)


def _exaggeration(heights: list[list[float]]) -> int:
    """The largest that leaves the motion within SHOWN_M."""
    largest = max((float(np.abs(y).max()) for y in heights if len(y)), default=0.0)
    fitting = [e for e in EXAGGERATIONS if e * largest <= SHOWN_M]
    return fitting[-1] if fitting else 1


def _name(rung: Rung) -> str:
    return f"modelled, with {' + '.join(rung.added)}" if rung.added else "modelled, baseline"


def _short(values: NDArray[Any], digits: int = DIGITS) -> list[float]:
    """With as many digits as a screen shows."""
    return [float(f"{x:.{digits}g}") for x in values.tolist()]
