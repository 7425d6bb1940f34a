"""What results depend on beside what was asked: which wheelhop computes, and from which files."""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from importlib.metadata import entry_points, version
from pathlib import Path

from wheelhop.effects.library import ENTRY_POINT

TEXTS = (".py", ".toml")
"""What a wheelhop computes with: its modules, and the tables beside them."""


@cache
def identity() -> str:
    """The wheelhop of this process: its version, and a digest of its text and of the packages that
    bring effects, such as "0.1.0 (5f0c9d1e2a7b)".

    It is found out once, so that of a process that has been running for long it is what it began
    with.
    """
    texts: dict[str, Path] = {}
    for portion in map(Path, sys.modules["wheelhop"].__path__):
        for file in portion.rglob("*"):
            if file.suffix in TEXTS and file.name != "truth.toml":  # no installation has those
                texts.setdefault(file.relative_to(portion).as_posix(), file)
    found = hashlib.sha256()
    for name in sorted(texts):
        text = texts[name].read_bytes().replace(b"\r\n", b"\n")
        found.update(f"{name} {len(text)}\n".encode() + text)
    for point in sorted(entry_points(group=ENTRY_POINT)):
        found.update(f"{point.value} {point.dist.version if point.dist else ''}\n".encode())
    return f"{version('wheelhop')} ({found.hexdigest()[:12]})"
