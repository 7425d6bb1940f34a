"""The stretches of a recording, drawn over its level; their ends can be dragged."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from wheelhop.logger.recording import Recording
from wheelhop.workbench.draft import Piece

LEVEL_S = 0.25
TICKS = 8


def stretches_html(recording: Recording, pieces: Sequence[tuple[int, Piece]]) -> str:
    """The rms of all channels in steps of `LEVEL_S`, the numbered pieces as bands over it, and a
    bar below for the steady part of each."""
    time_s = recording.time_s
    first, last = float(time_s[0]), float(time_s[-1])
    bands = "".join(_band(number, piece, first, last) for number, piece in pieces)
    bars = "".join(
        f'<span class="steady" style="{_across(piece.steady, first, last)}"></span>'
        for _, piece in pieces
        if piece.steady
    )
    line, largest = _level(recording)
    unit = escape(recording.channels[0].unit)
    return (
        f'<p class="soft">rms of all channels against time, up to {largest:.3g} {unit}</p>'
        f'<div class="stretches" data-from="{first:.3f}" data-to="{last:.3f}">'
        f'<svg viewBox="0 0 1000 100" preserveAspectRatio="none" aria-hidden="true">'
        f'<polyline points="{line}"/></svg>{bars}{bands}</div>'
        f'<div class="ticks">{_ticks(first, last)}</div>'
    )


def _level(recording: Recording) -> tuple[str, float]:
    step = max(round(LEVEL_S * recording.rate_hz), 1)
    count = len(recording.values) // step
    blocks = recording.values[: count * step].reshape(count, step, -1)
    level = np.nan_to_num(np.sqrt(blocks.var(axis=1).mean(axis=1)))
    largest = float(level.max()) if count else 0.0
    x = (np.arange(count) + 0.5) / max(count, 1) * 1000
    y = 98 - 92 * level / (largest or 1.0)
    return " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True)), largest


def _band(number: int, piece: Piece, first: float, last: float) -> str:
    edges = "".join(
        f'<span class="edge {edge}" data-edge="{edge}" role="slider" tabindex="0"'
        f' aria-label="{words} of {escape(piece.id)}, s" aria-valuemin="{first:.2f}"'
        f' aria-valuemax="{last:.2f}" aria-valuenow="{value:.2f}"></span>'
        for edge, words, value in (("from", "begin", piece.from_s), ("to", "end", piece.to_s))
    )
    out = "" if piece.taken else " out"
    place = _across((piece.from_s, piece.to_s), first, last)
    return (
        f'<div class="band{out}" data-piece="{number}" data-from="{piece.from_s:.3f}"'
        f' data-to="{piece.to_s:.3f}" style="{place}">{edges}'
        f"<span>{number + 1}</span></div>"
    )


def _across(ends: Sequence[float], first: float, last: float) -> str:
    left, right = (100 * (end - first) / (last - first) for end in ends)
    return f"left:{left:.3f}%;width:{right - left:.3f}%"


def _ticks(first: float, last: float) -> str:
    step = (last - first) / TICKS or 1.0
    power = 10.0 ** np.floor(np.log10(step))
    step = next(power * k for k in (1, 2, 5, 10) if power * k >= step * 0.999)
    marks = np.arange(np.ceil(first / step) * step, last, step)
    return "".join(
        f'<span style="left:{100 * (mark - first) / (last - first):.2f}%">{mark:g} s</span>'
        for mark in marks
    )
