"""What can be changed in a campaign's folder once it is written."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Rng = np.random.Generator
Table = tuple[list[str], Array]
"""Names of the columns, time first, and their rows."""


def edit(file: Path, change: Callable[[str], str]) -> None:
    """Rewrite a file's text."""
    file.write_text(change(file.read_text()))


def records(folder: Path, change: Callable[[list[str], Array], Table]) -> None:
    """Change every recording: the names of its columns and its rows (n, 1 + c), time first."""
    for file in sorted((folder / "runs").glob("*.csv")):
        names = file.read_text().split("\n", 1)[0].split(",")
        names, rows = change(names, np.loadtxt(file, delimiter=",", skiprows=1))
        np.savetxt(file, rows, "%.9g", ",", header=",".join(names), comments="")


def list_channels(folder: Path, places: Mapping[str, str]) -> None:
    """Say in campaign.toml which channels there are, and where."""
    lines = ["", "[channels]", *(f"{name} = {place}" for name, place in places.items()), ""]
    edit(
        folder / "campaign.toml",
        lambda text: text.replace("\n[[run]]", "\n".join(lines) + "\n[[run]]", 1),
    )


def scale_tracks(folder: Path, key: str, factor: Callable[[str], float]) -> None:
    """Multiply a number of every track by the factor of its kind."""

    def one(block: str) -> str:
        kind = re.search(r'track\.kind = "(\S+)"', block)
        times = 1.0 if kind is None else factor(kind[1])
        if times == 1.0:
            return block
        return re.sub(
            rf"(?m)^(track\.{key} = )(\S+)$",
            lambda found: f"{found[1]}{float(found[2]) * times:.8g}",
            block,
        )

    edit(
        folder / "campaign.toml",
        lambda text: "\n[[run]]".join(one(block) for block in text.split("\n[[run]]")),
    )
