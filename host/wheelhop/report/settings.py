"""The page and the figures of a comparison of settings."""

from __future__ import annotations

from html import escape
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from wheelhop.compare.settings import SettingsComparison
from wheelhop.compare.settings_words import sentences
from wheelhop.files.words import significant, squared
from wheelhop.report.figures import AFTER, BEFORE, FLOOR, INK, WIDTH
from wheelhop.report.page import bullets, figure, paragraph, section, table, title, write_page
from wheelhop.report.svg import STYLE, Drawing, inline, literal

PENS: tuple[dict[str, Any], ...] = tuple(
    {"color": colour, "linestyle": dash}
    for dash in ("-", (0, (4, 2)), (0, (1, 1.5)))
    for colour in (AFTER, BEFORE, FLOOR)
)
"""Of the settings beside the reference, which is in ink; as many as can be told apart."""


def write_settings_report(path: Path, found: SettingsComparison) -> None:
    """Write it as one self-contained HTML page, or as PDF; raises InputError."""
    body = [
        paragraph(f"wheelhop settings · {found.title}", "kicker"),
        title(settings_headline(found)),
        *settings_sections(found),
    ]
    write_page(path, f"{found.title}: settings", body)


def settings_headline(found: SettingsComparison) -> str:
    """Which settings differ."""
    differing = dict.fromkeys(d.setting for d in found.differences if d.differs)
    head = f"{', '.join(differing)} differ{'s' if len(differing) == 1 else ''}"
    return f"{head} from {found.reference}" if differing else "No difference is shown"


def settings_sections(found: SettingsComparison) -> list[str]:
    """What differs, at every channel, and the numbers of every setting."""
    drawings = [
        figure(
            inline(settings_figure(found, channel), f"settings{i}", f"settings at {channel}"),
            f"{channel}. Left: power density, shaded its 95 % interval by the segments of the"
            f" record. Right: power over that of {found.reference} by band; bars hold for all bands"
            " together in 95 %, filled where they leave 0.",
        )
        for i, channel in enumerate(dict.fromkeys(s.channel for s in found.spectra))
    ]
    return [
        section("What differs", bullets(sentences(found)), *drawings),
        section("By setting", _table(found)),
    ]


def settings_figure(found: SettingsComparison, channel: str) -> Drawing:
    """One channel: the power density of every setting, and its power over the reference's."""
    others = [name for name in found.settings if name != found.reference]
    pens = {found.reference: {"color": INK, "linestyle": "-"}}
    pens |= {name: PENS[i % len(PENS)] for i, name in enumerate(others)}
    with mpl.rc_context(STYLE):
        drawing = Drawing(figsize=(WIDTH, 3.3), layout="constrained")
        left, right = drawing.subplots(1, 2)
        for spectrum in (s for s in found.spectra if s.channel == channel):
            pen = pens[spectrum.setting]
            left.plot(
                spectrum.frequency_hz, spectrum.density, label=literal(spectrum.setting), **pen
            )
            left.fill_between(
                spectrum.frequency_hz, spectrum.low, spectrum.high, color=pen["color"], alpha=0.12,
                linewidth=0,
            )  # fmt: skip
            left.set_ylabel(f"power density, {squared(spectrum.unit)}/Hz")
        left.set_yscale("log")
        for i, name in enumerate(others):
            _draw_differences(right, found, (name, channel), pens[name], i - (len(others) - 1) / 2)
        right.axhline(0.0, color=INK, linewidth=0.8)
        right.set_ylabel(literal(f"power over {found.reference}, dB"))
        for axes in (left, right):
            axes.set_xscale("log")
            axes.xaxis.set_major_locator(LogLocator(base=10, subs=(1, 2, 5)))
            axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axes.xaxis.set_minor_formatter(NullFormatter())
            axes.set_xlabel("frequency, Hz")
        handles, labels = left.get_legend_handles_labels()
        drawing.legend(handles, labels, loc="outside upper left", ncols=5)
    return drawing


def _draw_differences(
    axes: Axes, found: SettingsComparison, of: tuple[str, str], pen: dict[str, Any], beside: float
) -> None:
    """Bars of one setting, shifted a little to the side of those of the others."""
    own = [d for d in found.differences if (d.setting, d.channel) == of]
    for d in own:
        x = (d.from_hz * d.to_hz) ** 0.5 * 1.02 ** (beside * 2)
        axes.plot([x, x], [d.low_db, d.high_db], linewidth=1.0, **pen)
        face = pen["color"] if d.differs else "none"
        axes.plot(x, d.power_db, "o", ms=4, color=pen["color"], markerfacecolor=face)


def _table(found: SettingsComparison) -> str:
    decays = {(d.setting, d.channel): d for d in found.decays}
    rows = []
    for s in found.spectra:
        decay = decays[s.setting, s.channel]
        rows.append(
            (
                escape(s.setting),
                escape(s.channel),
                escape(", ".join(s.runs)),
                f"{s.seconds:.0f}",
                f"{significant(s.rms)} {s.unit}",
                str(decay.count),
                f"{decay.frequency_hz:.2g}" if decay.count else "",
                f"{decay.damping:.2f}" if decay.count else "",
            )
        )
    headings = ("setting", "channel", "runs", "seconds", "rms in band", "free parts", "Hz", "ζ")
    return table(headings, rows, "lllrrrrr")
