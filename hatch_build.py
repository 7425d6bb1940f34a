"""What the packages take along beside the sources: the logger's firmware, as a release carries it.

`tools/firmware_release.sh` makes `build/release`; without it the packages hold no firmware.
"""

import hashlib
import re
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

RELEASE = "build/release"
SUMS = "SHA256SUMS"
VERSION = re.compile(r'FIRMWARE_VERSION "(.+)"')


class FirmwareHook(BuildHookInterface[Any]):
    """Put both .hex files into wheel and sdist; each must have its sum and the sources' version."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Raises ValueError for a file that is not what it should be."""
        folder = Path(self.root) / RELEASE
        if version == "editable" or not (folder / SUMS).exists():
            return
        place = "wheelhop/logger/firmware" if self.target_name == "wheel" else RELEASE
        header = Path(self.root) / "firmware/include/version.h"
        found = VERSION.search(header.read_text(encoding="utf-8"))
        assert found is not None
        files = [folder / SUMS]
        for line in (folder / SUMS).read_text(encoding="ascii").splitlines():
            total, name = line.split()
            files.append(folder / name)
            if hashlib.sha256(files[-1].read_bytes()).hexdigest() != total:
                raise ValueError(f"{files[-1]}: not the file of {SUMS}: tools/firmware_release.sh")
            if f"firmware={found[1]}\0".encode() not in program(files[-1]):
                raise ValueError(f"{files[-1]}: not version {found[1]}: tools/firmware_release.sh")
        build_data["force_include"].update({str(file): f"{place}/{file.name}" for file in files})


def program(file: Path) -> bytes:
    """The bytes in the data records of a file of Intel HEX."""
    records = [bytes.fromhex(line[1:]) for line in file.read_text(encoding="ascii").splitlines()]
    return b"".join(record[4:-1] for record in records if record[3] == 0)
