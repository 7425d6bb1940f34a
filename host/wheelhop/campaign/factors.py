"""[factors] of campaign.toml: what columns of the recordings are multiplied by when they are read,
-1 for a sensor that was upside down, 9.80665 for one in g; the recordings stay as they are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.types import CampaignError
from wheelhop.files import Table, did_you_mean


def read_factors(top: Table) -> dict[str, float]:
    """The factor of every column that has one, by its name.

    Raises CampaignError for a factor of 0, and for one of time_s.
    """
    table = top.table_if_any("factors")
    found = {name: table.number(name) for name in table.values}
    for name, factor in found.items():
        if factor == 0.0 or name == "time_s":
            raise table.error(
                f"{name} = {factor:g}: a factor turns or scales what a sensor shows: give -1 for"
                " one that is upside down, 9.80665 for one in g"
            )
    return found


def scaled(
    file: Path, names: Sequence[str], values: NDArray[np.float64], factors: Mapping[str, float]
) -> NDArray[np.float64]:
    """The columns of a recording times their factors.

    Raises CampaignError for a factor of a column that is not there.
    """
    if not factors:
        return values
    for name in factors:
        if name not in names:
            raise CampaignError(
                f"{file}: column {name}, which has a factor under [factors] in campaign.toml, is"
                f" missing{did_you_mean(name, names)}"
            )
    return np.asarray(values * [factors.get(name, 1.0) for name in names])
