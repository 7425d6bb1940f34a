"""From a result to a file of JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wheelhop.files import write_text


def write_json(path: Path, data: Mapping[str, Any]) -> None:
    """Write a result for programs to read."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")
