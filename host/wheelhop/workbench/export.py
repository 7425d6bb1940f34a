"""A fitted model's figures and tables as files."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wheelhop.api import ComparisonResult, plot
from wheelhop.api.plot import Kind
from wheelhop.campaign import CampaignError, ComponentCampaign
from wheelhop.files import make_folder, replacing, require, write_text
from wheelhop.files.words import ending_of
from wheelhop.formats.registry import write
from wheelhop.logger.recording import Channel, Recording

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
    for name, table in _tables(result).items():
        write_text(folder / f"{name}.csv", table.to_csv(), CampaignError)
    write_signals(folder / "signals.parquet", result)


def write_workbook(path: Path, result: ComparisonResult) -> None:
    """The same tables as sheets of one XLSX file. Text of a stranger that a spreadsheet would take
    for a formula stays text."""
    from pandas import ExcelWriter

    require("openpyxl", path.name, "test", CampaignError)
    with replacing(path, CampaignError) as draft, ExcelWriter(draft, engine="openpyxl") as writer:
        for name, table in _tables(result).items():
            table.to_excel(writer, sheet_name=name)
        for sheet in writer.book.worksheets:
            for cell in (cell for row in sheet.iter_rows() for cell in row):
                if cell.data_type == "f":
                    cell.data_type = "s"


def write_signals(path: Path, result: ComparisonResult) -> None:
    """Signals of all runs, measured and modelled in band, as Parquet."""
    with replacing(path, CampaignError) as draft:
        _signals(result).to_parquet(draft, index=False)


def write_mdf(folder: Path, result: ComparisonResult) -> None:
    """The same as ASAM MDF 4, a file for each run."""
    make_folder(folder)
    for i, record in enumerate(result.comparison.records, start=1):
        columns, channels = [], []
        for kind, coefficients in (("measured", record.measured), ("model", record.model)):
            signals = record.signal(coefficients)
            for k, name in enumerate(result.comparison.channels):
                if record.predicted[k]:
                    columns.append(signals[:, k])
                    channels.append(Channel(f"{name} {kind}", result.comparison.units[k]))
        name = re.sub(r"[^A-Za-z0-9._-]+", "_", record.run.id)[:60]
        recording = Recording(np.column_stack(columns), record.band.rate_hz, tuple(channels))
        write(recording, folder / f"{i:03d}-{name}.mf4")


def _tables(result: ComparisonResult) -> dict[str, DataFrame]:
    return {
        "ladder": result.ladder(),
        "parameters": result.parameters(),
        "residuals-by-band": result.residuals("band"),
        "residuals-by-run": result.residuals("run"),
        "agreement": result.agreement(),
    }


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
