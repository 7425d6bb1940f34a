"""The double's card: a folder of log files."""

import re
from pathlib import Path

import numpy as np

from wheelhop.logger.block import (
    BLOCK_BYTES,
    FIELDS,
    HEADER,
    MAGICS,
    SUMMARY,
    crc,
    pack_block,
    pack_text,
)

LOG_NAME = re.compile(r"HOP\d{5}\.HOP", re.IGNORECASE)
LARGEST_NUMBER = 0xFFFF


class Card:
    """Log files in a folder, and the one that is open."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        folder.mkdir(parents=True, exist_ok=True)

    def files(self) -> dict[str, int]:
        """Names and sizes in bytes of the log files."""
        paths = sorted(path for path in self.folder.iterdir() if LOG_NAME.fullmatch(path.name))
        return {path.name: path.stat().st_size for path in paths}

    def find(self, name: str) -> Path | None:
        """The file of a name, capitals or not."""
        names = {file.upper(): file for file in self.files()}
        found = names.get(name.upper())
        return self.folder / found if found else None

    def next_number(self, last: int) -> int:
        """The first session number after `last` that no file has."""
        taken = set(self.files())
        number = last
        while True:
            number = number % LARGEST_NUMBER + 1
            if log_name(number) not in taken:
                return number

    def append(self, number: int, block: bytes) -> None:
        """Write a block at the end of a session's file."""
        with (self.folder / log_name(number)).open("ab") as file:
            file.write(block)

    def recover(self, number: int, reset: str) -> None:
        """Close the file of a session that was not closed (SPEC.md, "A session …")."""
        path = self.folder / log_name(number)
        data = path.read_bytes() if path.exists() else b""
        good = _good_blocks(data, number)
        if not good or good[-1][1] == SUMMARY[0]:
            return
        sequence, _, due, lost, late = good[-1]
        text = {"end": "recovered", "due": due, "written": due - lost, "lost": lost}
        summary = pack_block(
            SUMMARY,
            int(np.frombuffer(data, FIELDS, 1)["session"][0]),
            sequence + 1,
            first_scan=due,
            lost=lost,
            late=late,
            payload=pack_text({**text, "late": late, "reset": reset}),
            magic=data[:4],
        )
        path.write_bytes(data[: (sequence + 1) * BLOCK_BYTES] + summary)


def log_name(number: int) -> str:
    """The name of a session's file."""
    return f"HOP{number:05d}.HOP"


def _good_blocks(data: bytes, number: int) -> list[tuple[int, int, int, int, int]]:
    """Sequence, kind, scans due, lost and late of each good block; none without a header."""
    blocks = np.frombuffer(data, FIELDS, len(data) // BLOCK_BYTES)
    if not len(blocks) or blocks["kind"][0] != HEADER[0] or blocks["session"][0] >> 16 != number:
        return []
    good = []
    for k, block in enumerate(blocks):
        whole = data[k * BLOCK_BYTES : (k + 1) * BLOCK_BYTES]
        same = block["session"] == blocks["session"][0] and block["sequence"] == k
        if same and whole.startswith(MAGICS) and crc(whole[:-2]) == block["crc"]:
            due = int(block["first_scan"]) + int(block["count"])
            good.append((k, int(block["kind"]), due, int(block["lost"]), int(block["late"])))
    return good
