"""matplotlib figures as inline SVG that takes its colours and its font from the page."""

from __future__ import annotations

import hashlib
import re
from html import escape
from io import BytesIO, StringIO
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.mathtext import math_to_image

COLOURS = {
    "paper": "#ffffff",
    "ink": "#1b1f24",
    "soft": "#5b6470",
    "rule": "#dfe3e8",
    "measured": "#aab2bc",
    "before": "#c8540a",
    "after": "#0b66a8",
    "floor": "#6f7782",
    "share-neither": "#8d95a0",
    "share-noise": "#d5dae0",
}
"""What figures are drawn in; on the page each becomes the style sheet's variable of that name.
Orange against blue, and black: told apart by every kind of colour vision, and in grey."""

STYLE: dict[Any, Any] = {
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titleweight": "bold",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.edgecolor": COLOURS["soft"],
    "axes.labelcolor": COLOURS["soft"],
    "axes.titlecolor": COLOURS["ink"],
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": COLOURS["rule"],
    "grid.linewidth": 0.6,
    "xtick.color": COLOURS["soft"],
    "ytick.color": COLOURS["soft"],
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.minor.size": 0.0,
    "ytick.minor.size": 0.0,
    "text.color": COLOURS["ink"],
    "lines.linewidth": 1.1,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.fonttype": "none",
}


class Drawing(Figure):
    """A figure that a notebook shows without further ado."""

    def _repr_png_(self) -> bytes:
        file = BytesIO()
        self.savefig(file, format="png", dpi=110)
        return file.getvalue()


def literal(name: str) -> str:
    """A user's name for matplotlib, which takes what stands between two $ for a formula."""
    return name.replace("$", r"\$")


def inline(figure: Figure, name: str, description: str) -> str:
    """The figure as an <svg> element; `name` keeps its ids apart from those of other figures."""
    file = StringIO()
    with mpl.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(file, format="svg", transparent=True, metadata={"Date": None})
    return _embedded(file.getvalue(), name, description, keep_size=False)


def equation(latex: str) -> str:
    """A formula as <svg> elements, its parts between quads each by itself, so that a long one finds
    line ends; the source text of what matplotlib does not know."""
    return " ".join(_formula(part) for part in re.split(r"\s*\\quad\s*", latex))


def _formula(latex: str) -> str:
    file = StringIO()
    options: dict[Any, Any] = {
        "svg.fonttype": "path",
        "svg.hashsalt": latex,
        "mathtext.fontset": "stix",
    }
    try:
        with mpl.rc_context(options):
            math_to_image(
                f"${latex}$",
                file,
                prop=FontProperties(size=13),
                format="svg",
                color=COLOURS["ink"],
            )
    except ValueError:
        return f"<code>{escape(latex)}</code>"
    name = f"eq{hashlib.sha256(latex.encode()).hexdigest()[:12]}"
    on_any_paper = file.getvalue().replace(COLOURS["paper"], "none")
    return _embedded(on_any_paper, name, latex, keep_size=True)


def _embedded(svg: str, name: str, description: str, *, keep_size: bool) -> str:
    svg = svg[svg.index("<svg") :].strip()
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<!--.*?-->", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", svg)
    svg = svg.replace("xlink:href", "href")
    if not keep_size:
        svg = re.sub(r'(<svg\b[^>]*?)\s+width="[^"]*"', r"\1", svg, count=1)
        svg = re.sub(r'(<svg\b[^>]*?)\s+height="[^"]*"', r"\1", svg, count=1)
    svg = _own_ids(svg, name)
    for key, colour in COLOURS.items():
        svg = svg.replace(colour, f"var(--{key})")
    return svg.replace("<svg", f'<svg role="img" aria-label="{escape(description)}"', 1)


def _own_ids(svg: str, name: str) -> str:
    """Ids that something refers to get the figure's name in front, the others go."""
    used = set(re.findall(r'(?:url\(#|href="#)([^)"]+)', svg))

    def renamed(match: re.Match[str]) -> str:
        return f' id="{name}-{match[1]}"' if match[1] in used else ""

    svg = re.sub(r'\s+id="([^"]+)"', renamed, svg)
    return re.sub(r'(url\(#|href="#)([^)"]+)', rf"\g<1>{name}-\2", svg)
