"""A comparison of settings in sentences, as JSON and as a table."""

from __future__ import annotations

from dataclasses import asdict
from itertools import groupby
from math import isfinite
from typing import TYPE_CHECKING, Any

from wheelhop.compare.decays import FreeDecays
from wheelhop.compare.settings import HELD, BandDifference, SettingsComparison

if TYPE_CHECKING:
    from pandas import DataFrame

NO_DIAGNOSIS = (
    "This compares settings over one course. It is no diagnosis: it says what a change did to the"
    " motion where the sensors sit, not which physics a model is missing."
)


def sentences(found: SettingsComparison) -> tuple[str, ...]:
    """What differs, each setting and channel by itself; the damping of free parts; what the drives
    leave open."""
    said = []
    several = len({d.channel for d in found.differences}) > 1
    for (setting, channel), own in groupby(found.differences, key=lambda d: (d.setting, d.channel)):
        at = f" at {channel}" if several else ""
        parts = [_part(list(bands)) for differs, bands in groupby(own, key=_sign) if differs]
        what = "; ".join(parts) or "no difference shown"
        said.append(f"{setting} against {found.reference}{at}: {what}.")
    return (*said, *_damping(found, several), *_open(found))


def _sign(difference: BandDifference) -> int:
    """1 more power, −1 less, 0 nothing shown."""
    if not difference.differs:
        return 0
    return 1 if difference.power_db > 0 else -1


def _part(bands: list[BandDifference]) -> str:
    """Bands side by side that differ the same way."""
    strongest = max(bands, key=lambda d: abs(d.power_db))
    size = abs(strongest.power_db)
    factor = 10 ** (size / 20)
    way = "more" if strongest.power_db > 0 else "less"
    up_to = "up to " if len(bands) > 1 else ""
    between = f"from {bands[0].from_hz:.2g} to {bands[-1].to_hz:.2g} Hz"
    times = factor if way == "more" else 1 / factor
    return f"{up_to}{size:.1f}\u00a0dB {way} {between} (amplitude\u00a0×\u00a0{times:.2f})"


def _damping(found: SettingsComparison, several: bool) -> list[str]:
    shown = [decay for decay in found.decays if decay.count]
    if not shown:
        return [
            "No free part: nowhere does the body swing out by itself. For its damping drive over a"
            " single bump and let the car roll on, several times."
        ]
    return [_decay_words(decay, several) for decay in shown]


def _decay_words(decay: FreeDecays, several: bool) -> str:
    at = f" at {decay.channel}" if several else ""
    parts = "1 free part" if decay.count == 1 else f"{decay.count} free parts"
    interval = f" ({decay.low:.2f} … {decay.high:.2f})" if isfinite(decay.low) else ""
    return (
        f"{decay.setting}{at}: {parts}, {decay.frequency_hz:.2g} Hz, damping ratio"
        f" {decay.damping:.2f}{interval}."
    )


def _open(found: SettingsComparison) -> list[str]:
    """What these drives cannot tell."""
    said = []
    once = [s.setting for s in found.spectra if len(s.runs) == 1]
    if once:
        said.append(
            f"Driven once: {', '.join(dict.fromkeys(once))}. How much a repeated drive differs is"
            f" assumed from a speed held to {100 * HELD:g} %; drive each setting twice or more."
        )
    if found.speed_apart > HELD:
        said.append(
            f"The settings were driven at speeds {100 * found.speed_apart:.0f} % apart: only what"
            " that does not explain is said to differ."
        )
    return [*said, NO_DIAGNOSIS]


def to_json(found: SettingsComparison) -> dict[str, Any]:
    """Plain dictionaries and lists, format 1; what is not known is None."""
    spectra = [
        {key: value.tolist() if hasattr(value, "tolist") else value for key, value in part.items()}
        for part in map(vars, found.spectra)
    ]
    return {
        "format": 1,
        "title": found.title,
        "reference": found.reference,
        "settings": list(found.settings),
        "sentences": list(sentences(found)),
        "differences": [asdict(d) | {"differs": d.differs} for d in found.differences],
        "spectra": spectra,
        "free_decays": [
            {key: None if value != value else value for key, value in asdict(decay).items()}
            for decay in found.decays
        ],
        "speed_apart": found.speed_apart,
    }


def to_frame(found: SettingsComparison) -> DataFrame:
    """A row for every setting, channel and band: power over that of the reference in dB, its
    interval, and whether it differs."""
    import pandas

    rows = [asdict(d) | {"differs": d.differs} for d in found.differences]
    return pandas.DataFrame(rows).set_index(["setting", "channel", "from_hz"])
