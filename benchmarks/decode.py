"""How fast a log is decoded, against doing nothing with its bytes but a check sum.

    python -m benchmarks.decode [MEGABYTES]

The log is made of random scans in the memory's file system or the temporary folder, and read once
before, so that the disk is not what is measured. Times are the processor's, of one core, best of
three: where other work shares the machine, the clock would measure that.
"""

import binascii
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from wheelhop.logger import read_log
from wheelhop.logger.block import BLOCK_BYTES, CRC_AT, pack_block, pack_scans, pack_text

SESSION = 0x0001_BEEF
CHANNELS = "B1 B2 B3 B4 A1 A2 A3 A4"
PIECE = 1 << 20


def write_log(file: Path, megabytes: float) -> None:
    """Write a healthy session of about that size."""
    payloads = [
        pack_scans(np.random.default_rng(seed).integers(0, 8185, (37, 8))) for seed in range(64)
    ]
    header = {"rate_hz": 100, "conversions": 8, "channels": CHANNELS}
    with file.open("wb") as out:
        out.write(pack_block(b"H", SESSION, 0, payload=pack_text(header)))
        for k in range(1, int(megabytes * 1e6 / BLOCK_BYTES)):
            payload = payloads[k % len(payloads)]
            first = 37 * (k - 1)
            out.write(pack_block(b"D", SESSION, k, first_scan=first, count=37, payload=payload))


def check_sums_alone(file: Path) -> None:
    """The CRC of each block in C, one call for each."""
    with file.open("rb") as source:
        while data := source.read(PIECE):
            view = memoryview(data)
            for begin in range(0, len(data), BLOCK_BYTES):
                binascii.crc_hqx(view[begin : begin + CRC_AT], 0)


def read_alone(file: Path) -> None:
    """The bytes, as `cat` reads them."""
    with file.open("rb") as source:
        while source.read(PIECE):
            pass


def check_alone(file: Path) -> None:
    """All that is known of the blocks, without their scans."""
    read_log(file)


def decode_in_pieces(file: Path) -> None:
    """Every sum, in bounded memory."""
    for _ in read_log(file).scans():
        pass


def decode_at_once(file: Path) -> None:
    """The whole recording as floating-point codes."""
    read_log(file).recording()


def seconds(work: Callable[[Path], None], file: Path) -> float:
    """Processor time, best of three."""
    times = []
    for _ in range(3):
        begin = time.process_time()
        work(file)
        times.append(time.process_time() - begin)
    return min(times)


def main() -> None:
    """Print a row for each kind of work."""
    megabytes = float(sys.argv[1]) if len(sys.argv) > 1 else 100.0
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "HOP00001.HOP"
        write_log(file, megabytes)
        size = file.stat().st_size / 1e6
        peer = seconds(check_sums_alone, file)
        print(f"{size:.0f} MB, {size * 1e6 / BLOCK_BYTES:.0f} blocks")
        print(f"{'work':<34}{'MB/s':>8}{'time / peer':>14}")
        for name, work in [
            ("read", read_alone),
            ("binascii's CRC of each block (peer)", check_sums_alone),
            ("read_log: check all", check_alone),
            ("read_log and scans: all sums", decode_in_pieces),
            ("read_log and recording: codes", decode_at_once),
        ]:
            spent = seconds(work, file)
            print(f"{name:<34}{size / spent:8.0f}{spent / peer:14.2f}")


if __name__ == "__main__":
    main()
