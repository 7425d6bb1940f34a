"""How much memory and time does a large recording take to read, beside other libraries?

    python -m benchmarks.import_size [--csv-mb 300] [--tdms-mb 64]

The same samples, ten channels at 1 kHz, as CSV, TDMS and MDF; each is read by a process of its own,
which prints the seconds it took, those that the processor computed for it (on a machine that others
use, too, they tell more), and the most memory it ever had, libraries included. pandas does
for CSV what it does by itself, asammdf reads MDF and nptdms TDMS, each into a table of float64;
wheelhop understands the file, finds its time, converts to SI and lays it on its grid.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

CHANNELS = 10
RATE_HZ = 1000
MB = 1e6
CHUNK = 50_000  # rows
NUMBER_BYTES = 8

WHEELHOP = """
from wheelhop.formats import is_foreign, read, understand
mapping = understand(path).mapping() if is_foreign(path) else None
table = read(path, mapping).values
"""
READERS = {
    ".csv": {
        "wheelhop": WHEELHOP,
        "pandas": "import pandas; table = pandas.read_csv(path).to_numpy()",
    },
    ".tdms": {
        "wheelhop": WHEELHOP,
        "nptdms": "import nptdms; table = nptdms.TdmsFile.read(path).as_dataframe().to_numpy()",
    },
    ".mf4": {
        "wheelhop": WHEELHOP,
        "asammdf": "import asammdf; table = asammdf.MDF(path).to_dataframe().to_numpy()",
    },
}
CHILD = """
import resource, sys, time
from pathlib import Path
path, since = Path(sys.argv[1]), time.perf_counter()
{reader}
seconds, used = time.perf_counter() - since, resource.getrusage(resource.RUSAGE_SELF)
print(seconds, used.ru_utime + used.ru_stime, used.ru_maxrss * 1024, len(table))
"""


def samples(rows: int) -> np.ndarray:
    """(rows, c) accelerations, g."""
    return np.random.default_rng(1).normal(0.0, 0.5, (rows, CHANNELS))


def write_csv(path: Path, size: float) -> None:
    """A CSV of about so many bytes: time and six characters a number."""
    block = samples(CHUNK)
    with path.open("w") as file:
        file.write(",".join(["Time [s]", *(f"a{k} [g]" for k in range(CHANNELS))]) + "\n")
        row = 0
        while file.tell() < size:
            stamps = np.arange(row, row + CHUNK) / RATE_HZ
            table = np.column_stack([stamps, block])
            np.savetxt(file, table, fmt=["%.3f"] + ["%.3f"] * CHANNELS, delimiter=",")
            row += CHUNK


def write_tdms(path: Path, size: float) -> None:
    """A TDMS of so many bytes, float64, as DAQmx logs it."""
    from nptdms import ChannelObject, TdmsWriter

    values = samples(int(size / NUMBER_BYTES / CHANNELS))
    about = {"wf_increment": 1 / RATE_HZ, "wf_start_offset": 0.0, "unit_string": "g"}
    with TdmsWriter(path) as writer:
        writer.write_segment(
            [ChannelObject("log", f"a{k}", column, about) for k, column in enumerate(values.T)]
        )


def write_mdf(path: Path, size: float) -> None:
    """The same as MDF 4.10."""
    import asammdf

    values = samples(int(size / NUMBER_BYTES / (CHANNELS + 1)))
    time_s = np.arange(len(values)) / RATE_HZ
    with asammdf.MDF(version="4.10") as mdf:
        signals = [
            asammdf.Signal(np.ascontiguousarray(column), time_s, unit="g", name=f"a{k}")
            for k, column in enumerate(values.T)
        ]
        mdf.append(signals, common_timebase=True)
        mdf.save(path, overwrite=True)


def measured(path: Path, reader: str) -> list[float]:
    """Seconds, those of the processor, the most memory in bytes, and rows, of a process that reads
    the file."""
    code = CHILD.format(reader=reader)
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True
    )
    return [float(word) for word in done.stdout.split()]


def main() -> None:
    """Write the files, read each in turn, and print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--csv-mb", type=float, default=300.0)
    parser.add_argument("--tdms-mb", type=float, default=64.0)
    arguments = parser.parse_args()
    print(f"{'file':14}{'reader':12}{'s':>8}{'CPU s':>8}{'MB per CPU s':>14}{'most MB':>9}")
    with tempfile.TemporaryDirectory() as folder:
        for suffix, write, size in (
            (".csv", write_csv, arguments.csv_mb),
            (".tdms", write_tdms, arguments.tdms_mb),
            (".mf4", write_mdf, arguments.tdms_mb),
        ):
            path = Path(folder) / f"run{suffix}"
            write(path, size * MB)
            held = path.stat().st_size
            for name, reader in READERS[suffix].items():
                seconds, busy, memory, _ = measured(path, reader)
                file, speed = f"{held / MB:.0f} MB {suffix}", held / MB / busy
                print(
                    f"{file:14}{name:12}{seconds:8.1f}{busy:8.1f}{speed:14.0f}{memory / MB:9.0f}",
                    flush=True,
                )
            path.unlink()


if __name__ == "__main__":
    main()
