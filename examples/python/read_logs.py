"""Read a log of the logger, a damaged one too: what is in it, what is missing, and its samples.

    python examples/python/read_logs.py [LOG.HOP]

Without a log, the logger's double in Python records one, and a byte of it is changed.
"""

import sys
from pathlib import Path
from tempfile import mkdtemp

import wheelhop as wh


def record(folder: Path) -> Path:
    """Let the double record sines of 2, 3, … 9 Hz for five seconds, and fetch its log."""
    from wheelhop.hil_sim.signals import sines
    from wheelhop.hil_sim.stand_in import stand_in
    from wheelhop.logger.download import Downloader
    from wheelhop.logger.link import connect

    (folder / "card").mkdir()
    with stand_in(sines(range(2, 10)), folder / "card") as logger:
        downloader = Downloader(connect(logger.url))
        try:
            name = downloader.link.start()
            logger.wait(5.0)
            downloader.link.stop()
            return downloader.download(name, downloader.link.files()[name], folder).path
        finally:
            downloader.close()


def damage(file: Path) -> None:
    """Change one byte in the middle, as a worn card may."""
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 0xFF
    file.write_bytes(data)


if len(sys.argv) > 1:
    file = Path(sys.argv[1])
else:
    file = record(Path(mkdtemp()))
    damage(file)

log = wh.read_log(file)
print(f"{log.due} scans were due, {log.written} are there")
for gap in log.gaps:
    print(f"missing: {gap.scans} scans from number {gap.first} on")

# Codes of the converter here; with constants, or nominal ones, m/s².
codes = log.recording()
print(codes)
recording = wh.read_recording(file, nominal=True)
print(recording.to_dataframe().describe().round(1).to_string())
print(*recording.history, sep="\n")
