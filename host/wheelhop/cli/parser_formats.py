"""What `wheelhop convert` and `wheelhop import` take."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def add_formats(commands: Any) -> None:
    """Add the commands; makes them without loading any other package."""
    convert = commands.add_parser("convert", help="write a recording in another format")
    convert.add_argument("source", metavar="FILE", type=Path, help="the recording")
    convert.add_argument(
        "target", metavar="NEW", type=Path, help="what to write: .csv, .parquet, .mf4, .uff"
    )
    convert.add_argument("--force", action="store_true", help="replace a file that exists")
    command = commands.add_parser("import", help="read recordings of other recorders, into SI")
    command.add_argument("files", metavar="FILE", nargs="+", type=Path)
    command.add_argument(
        "--map", metavar="MAP.toml", type=Path, help="what the columns are (default: as understood)"
    )
    command.add_argument(
        "--out", metavar="FOLDER", type=Path, default=Path(), help="where to write (default .)"
    )
    command.add_argument("--to", choices=(".csv", ".parquet", ".mf4", ".uff"), default=".csv")
    command.add_argument(
        "--draft", action="store_true", help="print a mapping made from the file's look"
    )
    command.add_argument(
        "--answer",
        metavar="KEY=VALUE",
        action="append",
        default=[],
        help="what a file does not say: rate_hz=500, time_unit=ms, decimal=,",
    )
    command.add_argument(
        "--yes", action="store_true", help="for scripts: ask nothing, refuse what must be guessed"
    )
    command.add_argument("--force", action="store_true", help="replace files that exist")
