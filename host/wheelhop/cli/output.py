"""Where the commands print, and what they leave for programs."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.console import Console

from wheelhop.files import write_text

PLAIN_WIDTH = 120


def open_console() -> Console:
    """A console on stdout; into a pipe or file it writes no colours and does not fold tables."""
    return Console(highlight=False, width=None if sys.stdout.isatty() else PLAIN_WIDTH)


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write a result for programs to read."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")
