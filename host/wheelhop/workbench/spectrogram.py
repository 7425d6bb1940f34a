"""Spectrograms: how the power of a record is shared out over time and frequency, as a chart."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.workbench.charts import INK, Options
from wheelhop.workbench.curves import Row

Array = NDArray[np.float64]

WAVES = 4
"""A piece holds so many waves of the frequency that is a tenth of the band's top: short enough to
show a bump, long enough to tell frequencies an octave apart at the bottom of what moves wheels."""
OVERLAP = 4  # pieces begin a fourth of their length apart
MOST = 160
"""So many pieces are drawn, however long the record is; between them none is."""
RANGE_DB = 50.0
"""What is weaker than the strongest by more is white."""
COLOURS = ("rgba(11,102,168,0)", "rgba(11,102,168,0.6)", "#0b66a8", "#7a4fb5", "#c8540a", "#f28e4b")


def power_over_time(
    signal: Array, rate_hz: float, band_hz: tuple[float, float]
) -> tuple[Array, Array, Array]:
    """Middles of the pieces (t,), s, frequencies in band (f,), Hz, and power densities (t, f),
    unit²/Hz, by a Hann window."""
    length = int(min(max(16, WAVES * 10 * rate_hz / band_hz[1]), len(signal)))
    step = max(1, length // OVERLAP, (len(signal) - length) // MOST)
    starts = np.arange(0, len(signal) - length + 1, step)
    window = np.hanning(length)
    pieces = np.array([signal[i : i + length] for i in starts]) * window
    scale = rate_hz * float((window**2).sum()) / 2
    frequency = np.fft.rfftfreq(length, 1 / rate_hz).astype(np.float64)
    inside = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    power = np.abs(np.fft.rfft(pieces)) ** 2 / scale
    middle = np.asarray((starts + length / 2) / rate_hz, np.float64)
    return middle, frequency[inside], np.asarray(power[:, inside], np.float64)


def spectrogram(
    rows: Sequence[Row], band_hz: tuple[float, float], heights: Sequence[float], gap: float
) -> Options:
    """A panel for what was measured in every row, power density in decibels below the strongest
    of all; `heights` and the `gap` below each in per cent."""
    options: Options = {
        "animation": False,
        "textStyle": {"color": INK},
        "tooltip": {"confine": True},
        "visualMap": {
            **{"min": -RANGE_DB, "max": 0, "calculable": False, "orient": "horizontal"},
            **{"top": 0, "left": "center", "itemHeight": 160, "itemWidth": 12},
            **{"text": ["0 dB", f"−{RANGE_DB:.0f} dB"], "textStyle": {"color": INK}},
            "inRange": {"color": list(COLOURS)},
        },
        "title": [],
        "grid": [],
        "xAxis": [],
        "yAxis": [],
        "series": [],
    }
    found = [power_over_time(row.curves[0].signal, row.rate_hz, band_hz) for row in rows]
    strongest = max((float(power.max()) for *_, power in found if power.size), default=1.0) or 1.0
    top = gap
    for i, (row, (time, frequency, power), height) in enumerate(
        zip(rows, found, heights, strict=True)
    ):
        options["grid"].append(
            {"top": f"{top:.1f}%", "height": f"{height:.1f}%", "left": 64, "right": 16}
        )
        name = f"{row.channel}, {row.run}"
        options["title"].append(
            {"text": name, "left": 60, "top": f"{top - gap / 2:.1f}%", "textStyle": _TITLE}
        )
        options["xAxis"].append(_axis(time, i, "time, s"))
        options["yAxis"].append(_axis(frequency, i, "frequency, Hz"))
        level = 10 * np.log10(np.maximum(power / strongest, 1e-12))
        cells = [
            [a, b, round(float(level[a, b]), 1)]
            for a in range(len(time))
            for b in range(len(frequency))
            if level[a, b] > -RANGE_DB
        ]
        options["series"].append(
            {"type": "heatmap", "name": name, "xAxisIndex": i, "yAxisIndex": i, "data": cells}
        )
        top += height + gap
    axes = [[x["data"], y["data"]] for x, y in zip(options["xAxis"], options["yAxis"], strict=True)]
    options["tooltip"][":formatter"] = f"one => wheelhop.cell(one, {json.dumps(axes)})"
    return options


_TITLE = {"color": INK, "fontSize": 12}


def _axis(values: Array, index: int, name: str) -> dict[str, Any]:
    return {
        "gridIndex": index,
        "type": "category",
        "data": [f"{value:.3g}" for value in values],
        "name": name,
        "nameLocation": "middle",
        "nameGap": 40 if name.startswith("f") else 22,
        "axisLabel": {"color": INK, "hideOverlap": True},
        "axisTick": {"show": False},
    }
