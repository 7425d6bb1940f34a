"""A text as it was read once, for whoever has to work on the very text that somebody has seen."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

from wheelhop.files.error import InputError
from wheelhop.files.keys import read_text


@dataclass(frozen=True)
class Source:
    """The text of a file, which goes with the work instead of the path: what becomes of the file
    later, or what lies under its path on another computer, changes nothing."""

    path: Path
    text: str

    @staticmethod
    def read(path: Path, kind: type[InputError] = InputError) -> Source:
        """The file as it is now; raises as `read_text`. The path is made absolute."""
        return Source(path.absolute(), read_text(path, kind))

    @property
    def digest(self) -> str:
        """SHA-256 of the text in UTF-8, hexadecimal."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    def __str__(self) -> str:
        return str(self.path)
