"""The work folder: campaigns as the program sees them, their truth apart, and what it said."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


def default_work() -> Path:
    """Outside the repository: in the user's cache."""
    cache = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(cache) / "wheelhop-blind"


@dataclass(frozen=True)
class Work:
    """`folder`/campaigns/NAME, truth/NAME.toml and .json, results/LABEL/NAME.json."""

    folder: Path
    short: bool
    label: str = "latest"

    @property
    def _base(self) -> Path:
        return self.folder / ("short" if self.short else "full")

    def campaign(self, name: str) -> Path:
        """The folder the program sees; it holds no truth."""
        return self._base / "campaigns" / name

    def truth_toml(self, name: str) -> Path:
        """What the simulator hid."""
        return self._base / "truth" / f"{name}.toml"

    def truth_json(self, name: str) -> Path:
        """How it was made: strength reached, amounts, or why it could not be made."""
        return self._base / "truth" / f"{name}.json"

    def diagnosis(self, name: str) -> Path:
        """What the program wrote."""
        return self._base / "results" / self.label / f"{name}.json"

    def timing(self, name: str) -> Path:
        """How the program ended and how long it took; written last."""
        return self._base / "results" / self.label / f"{name}.run.json"

    def answered(self, name: str, campaign: str) -> bool:
        """Whether the program was asked after the campaign was last made."""
        made, ended = self.truth_json(campaign), self.timing(name)
        return made.is_file() and ended.is_file() and _time(ended) > _time(made)

    def table(self) -> Path:
        """Where table.json, table.txt, answers.csv and confusion.png go."""
        return self._base / "results" / self.label


def _time(file: Path) -> float:
    return file.stat().st_mtime


def write_json(file: Path, content: dict[str, Any]) -> None:
    """All or nothing: an interrupted run leaves no half a file."""
    _put(file, lambda part: part.write_text(json.dumps(content, indent=1) + "\n"))


def read_json(file: Path) -> dict[str, Any] | None:
    """None if there is no such file."""
    return json.loads(file.read_text()) if file.is_file() else None


def _put(file: Path, write: Callable[[Path], object]) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    part = file.with_name(file.name + ".part")
    write(part)
    part.replace(file)
