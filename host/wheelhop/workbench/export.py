"""A fitted model's figures and tables as files."""

from __future__ import annotations

import io
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wheelhop.api import ComparisonResult, plot
from wheelhop.api.plot import Kind
from wheelhop.campaign import CampaignError, ComponentCampaign
from wheelhop.files import make_folder, replacing, write_text
from wheelhop.files.words import ending_of

if TYPE_CHECKING:
    from pandas import DataFrame

KINDS: tuple[Kind, ...] = ("ladder", "where", "worst", "typical", "histograms", "loops")
NOT_OF_A_RIG: Kind = "histograms"
FORMATS = ("svg", "png")
DPI = 200


def write_figures(folder: Path, result: ComparisonResult) -> None:
    """Every figure that a result can be looked at with, as SVG and PNG."""
    make_folder(folder)
    on_rig = isinstance(result.campaign, ComponentCampaign)
    for kind in KINDS:
        if on_rig and kind == NOT_OF_A_RIG:
            continue
        figure = plot(result, kind)
        for form in FORMATS:
            drawn = io.BytesIO()
            figure.savefig(drawn, format=form, dpi=DPI)
            with replacing(folder / f"{kind}.{form}", CampaignError) as draft:
                draft.write_bytes(drawn.getvalue())


def write_tables(folder: Path, result: ComparisonResult) -> None:
    """A result's tables as CSV, and the signals of all runs, measured and modelled in band, as
    Parquet; units stand in the columns' names."""
    make_folder(folder)
    tables = {
        "ladder": result.ladder(),
        "parameters": result.parameters(),
        "residuals-by-band": result.residuals("band"),
        "residuals-by-run": result.residuals("run"),
        "agreement": result.agreement(),
    }
    for name, table in tables.items():
        write_text(folder / f"{name}.csv", table.to_csv(), CampaignError)
    with replacing(folder / "signals.parquet", CampaignError) as draft:
        _signals(result).to_parquet(draft, index=False)


def _signals(result: ComparisonResult) -> DataFrame:
    """Measured and modelled signals in band, a row for each sample of each run."""
    from pandas import DataFrame, concat

    endings = [ending_of(unit) for unit in result.comparison.units]
    parts = []
    for record in result.comparison.records:
        columns = {"run": [record.run.id] * record.band.n, "time_s": record.run.time_s}
        for kind, coefficients in (("measured", record.measured), ("model", record.model)):
            signals = record.signal(coefficients)
            signals[:, ~record.predicted] = np.nan
            labels = zip(result.comparison.channels, endings, strict=True)
            names = [f"{name}_{kind}{ending}" for name, ending in labels]
            columns |= dict(zip(names, signals.T, strict=True))
        parts.append(DataFrame(columns))
    return concat(parts)
