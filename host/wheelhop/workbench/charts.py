"""Charts that pan and zoom: options for ECharts, which comes with the page's framework."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Options = dict[str, Any]
Window = tuple[float, float]
"""From where to where along x something is looked at."""
WHOLE: Window = (-inf, inf)

MEASURED, BEFORE, AFTER, FLOOR = "#8d95a0", "#c8540a", "#0b66a8", "#6f7782"
"""As in the report: told apart by every kind of colour vision. Readable on white and on black."""
INK = "#7a828c"
MORE = ("#7a4fb5", "#2e7d4f", "#b0357f")
"""Of the models between the first and the last one; they are dashed, too."""
DECADES = 7  # at most of a logarithmic axis: what lies lower matters to nobody
DASHES = "path://M0 0h8v3h-8zM11 0h8v3h-8z"
LABEL = "value => value >= 1e-3 && value < 1e4 ? String(value) : value.toExponential(0)"
DIGITS = 5  # significant ones that a point on a screen can show
MOST = 1200
"""So many points of a curve are drawn where it is looked at, two a pixel on a wide screen."""
COARSE = 100  # on either side, to be seen in passing


@dataclass(frozen=True, eq=False)
class Line:
    """One curve of a chart: x and y (n,), `width` in pixels; `path`: x goes to and fro.

    Without a graphics card a pen wider than one pixel takes a browser three times as long: it is
    for one curve among others, and only where no more samples are looked at than are drawn.
    """

    name: str
    x: ArrayLike
    y: ArrayLike
    colour: str
    width: float = 1.0
    dashed: bool = False
    path: bool = False

    def drawn(self, window: Window) -> Options:
        """Points and pen, if this is looked at."""
        x, y = np.asarray(self.x), np.asarray(self.y)
        first, last = (0, len(x)) if self.path else map(int, np.searchsorted(x, window))
        kept = np.arange(len(x)) if self.path else thinned(y, first, last)
        pen: Options = {"color": self.colour}
        pen["width"] = self.width if self.path or last - first <= MOST else 1.0
        pen["type"] = "dashed" if self.dashed else "solid"
        return {"data": points(x[kept], y[kept]), "lineStyle": pen}


@dataclass(frozen=True, eq=False)
class Panel:
    """One set of axes with what stands on them; a logarithmic one if it says so. `units` are those
    of x and y, said with every value that is pointed at."""

    x_name: str
    y_name: str
    lines: Sequence[Line]
    log: bool = False
    band: float = 0.0  #: half the height of a grey band about zero
    marks: Sequence[float] = ()  #: places along x with a line
    title: str = ""
    caption: str = ""  #: above it
    units: tuple[str, str] = ("", "")
    ends: Window | None = None  #: of the x axis, where they are not those of the lines
    y_ends: Window | None = None


def chart(
    panels: Sequence[Panel],
    heights: Sequence[float],
    zoom: Sequence[int],
    window: Window | None = None,
    gap: float = 9.0,
) -> Options:
    """Panels below each other, `heights` and the `gap` below each in per cent; those in `zoom` pan
    and zoom together, and show the `window`: without one, what they showed before."""
    total, head = sum(heights), min(6.0, gap)
    room = 100.0 - head - gap * len(panels)
    lines = {line.name: line for panel in panels for line in panel.lines}
    names = [{"name": n, "icon": DASHES if lines[n].dashed else "rect"} for n in lines]
    units = [[panel.title, *panel.units] for panel in panels]
    options: Options = {
        "animation": False,
        "textStyle": {"color": INK},
        "legend": {
            **{"top": 0, "left": 60, "itemWidth": 18, "itemHeight": 3, "type": "scroll"},
            **{"textStyle": {"color": INK}, "data": names, "show": len(names) > 1},
        },
        "tooltip": {
            **{"trigger": "axis", "axisPointer": {"type": "line"}, "confine": True},
            ":formatter": f"values => wheelhop.tooltip(values, {json.dumps(units)})",
        },
        "axisPointer": {"link": [{"xAxisIndex": list(zoom)}]},
        "title": [],
        "grid": [],
        "xAxis": [],
        "yAxis": [],
        "series": [],
        "dataZoom": [
            {
                **{"type": "inside", "xAxisIndex": list(zoom), "filterMode": "filter"},
                **({} if window is None else zoomed(window)),
            },
        ],
        "aria": {"enabled": True},
    }
    top = head + 1.0
    for i, (panel, height) in enumerate(zip(panels, heights, strict=True)):
        share = room * height / total
        options["grid"].append(
            {"top": f"{top:.1f}%", "height": f"{share:.1f}%", "left": 64, "right": 16}
        )
        caption = {"text": panel.caption, "left": 60, "top": f"{top - gap / 2:.1f}%"}
        options["title"].append({**caption, "textStyle": {"color": INK, "fontSize": 12}})
        top += share + gap
        _add_axes(options, panel, i)
        series = [_series(line, i, window or WHOLE) for line in panel.lines]
        if series:
            series[-1] |= marks(panel)
        options["series"] += series
    return options


def zoomed(window: Window) -> Options:
    """A window as a zoom: by its ends, or all there is."""
    if not all(map(isfinite, window)):
        return {"start": 0, "end": 100}
    return {"startValue": window[0], "endValue": window[1]}


def marks(panel: Panel) -> Options:
    """What lies behind the curves; an empty list, too, takes away what was there before."""
    band = [[{"yAxis": -panel.band}, {"yAxis": panel.band}]] if panel.band > 0 else []
    return {
        "markArea": {
            **{"silent": True, "itemStyle": {"color": INK, "opacity": 0.18}, "data": band},
        },
        "markLine": {
            **{"silent": True, "symbol": "none", "label": {"show": False}},
            "lineStyle": {"color": INK, "type": "solid", "width": 1.5},
            "data": [{"xAxis": float(x)} for x in panel.marks],
        },
    }


def _add_axes(options: Options, panel: Panel, index: int) -> None:
    kind = "log" if panel.log else "value"
    soft = {"lineStyle": {"color": INK}}
    grid = {"lineStyle": {"color": INK, "opacity": 0.18}}
    labels: Options = {"hideOverlap": True, "color": INK}
    x = np.concatenate([np.zeros(0), *(np.asarray(line.x, float) for line in panel.lines)])
    own = (x.min(), x.max()) if len(x) else (0.0, 1.0)
    ends = [float(f"{end:.{DIGITS}g}") for end in panel.ends or own]
    if panel.log:
        labels[":formatter"] = LABEL
    else:  # a record ends anywhere, and its end is no number to read
        labels |= {"showMinLabel": float(ends[0]).is_integer(), "showMaxLabel": False}
    options["xAxis"].append(
        {
            "gridIndex": index,
            "type": kind,
            "name": panel.x_name,
            "nameLocation": "middle",
            "nameGap": 22,
            "axisLabel": labels,
            "axisLine": soft,
            "min": ends[0],  # not of the points drawn: of a long curve these are not all
            "max": ends[1],
            "splitLine": grid,
        }
    )
    options["yAxis"].append(
        {
            "gridIndex": index,
            "type": kind,
            "name": panel.y_name,
            "nameLocation": "middle",
            "nameGap": 46,
            "axisLine": soft,
            "axisLabel": {":formatter": LABEL, "color": INK} if panel.log else {"color": INK},
            "scale": True,
            "splitLine": grid,
            "splitNumber": 10 if panel.log else 4,
            **(_decades(panel) if panel.log else {}),
            **(dict(zip(("min", "max"), panel.y_ends, strict=True)) if panel.y_ends else {}),
        }
    )


def _decades(panel: Panel) -> Options:
    """The ends of a logarithmic axis: powers of ten."""
    values = np.concatenate([np.zeros(0), *(np.asarray(line.y, float) for line in panel.lines)])
    values = values[np.isfinite(values) & (values > 0)]
    if not len(values):
        return {}
    top = np.ceil(np.log10(values.max()))
    bottom = max(np.floor(np.log10(values.min())), top - DECADES)
    return {"min": 10.0**bottom, "max": 10.0 ** max(top, bottom + 1)}


def _series(line: Line, index: int, window: Window) -> Options:
    return {
        "name": line.name,
        "type": "line",
        "xAxisIndex": index,
        "yAxisIndex": index,
        "symbol": "none",
        "itemStyle": {"color": line.colour},
        **line.drawn(window),
    }


def points(x: ArrayLike, y: ArrayLike) -> list[list[float | None]]:
    """Pairs for a chart, with as many digits as a screen shows; a gap where y is not finite."""
    return [
        [float(f"{a:.{DIGITS}g}"), float(f"{b:.{DIGITS}g}") if np.isfinite(b) else None]
        for a, b in zip(np.asarray(x), np.asarray(y), strict=True)
    ]


def thinned(y: ArrayLike, first: int, last: int) -> NDArray[np.intp]:
    """Which points of a curve to draw, if those from `first` to before `last` are looked at: the
    least and the largest of every few samples, so that no peak is lost."""
    y = np.asarray(y, np.float64)
    margin = (last - first) // 2
    first, last = max(0, first - margin), min(len(y), last + margin)
    parts = ((0, first, COARSE), (first, last, MOST), (last, len(y), COARSE))
    return np.concatenate([_extremes(y, a, b, most) for a, b, most in parts])


def _extremes(y: Array, first: int, last: int, most: int) -> NDArray[np.intp]:
    step = -(-2 * (last - first) // most)
    if step <= 2:
        return np.arange(first, last)
    count = (last - first) // step
    blocks = y[first : first + count * step].reshape(count, step)
    begin = first + step * np.arange(count)
    ends = np.sort([begin + blocks.argmin(axis=1), begin + blocks.argmax(axis=1)], axis=0)
    return np.concatenate([ends.T.ravel(), np.arange(first + count * step, last)])
