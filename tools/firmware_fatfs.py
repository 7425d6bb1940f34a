"""Fetch FatFs's sources from PyPI into build/firmware/lib/fatfs, pinned by firmware/fatfs.txt.

Runs by itself, and before every build as an extra script of platformio.ini.
"""

import subprocess
import sys
import tarfile
from pathlib import Path

FILES = ("ff.c", "ff.h", "diskio.h")  # ffconf.h is ours: firmware/include


def fetch(root: Path) -> None:
    """Download, check and unpack what is not there yet."""
    folder = root / "build/firmware/lib/fatfs"
    if all((folder / name).exists() for name in FILES):
        return
    cache = root / "build/firmware/download"
    pip = [sys.executable, "-m", "pip", "download", "--quiet", "--disable-pip-version-check"]
    options = ["--no-deps", "--no-binary", "fatfs-ng", "--require-hashes", "--dest", str(cache)]
    subprocess.run([*pip, *options, "-r", str(root / "firmware/fatfs.txt")], check=True)
    folder.mkdir(parents=True, exist_ok=True)
    (archive,) = cache.glob("fatfs_ng-*.tar.gz")
    with tarfile.open(archive) as tar:
        for member in tar:
            path = Path(member.name)
            if path.name in FILES and path.parent.name == "source":
                source = tar.extractfile(member)
                assert source is not None
                (folder / path.name).write_bytes(source.read())


if "Import" in globals():  # PlatformIO runs this
    Import("env")  # type: ignore[name-defined]  # noqa: F821
    fetch(Path(env["PROJECT_DIR"]))  # type: ignore[name-defined]  # noqa: F821
elif __name__ == "__main__":
    fetch(Path(__file__).resolve().parents[1])
