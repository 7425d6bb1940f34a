"""How diagnosing many campaigns grows with their number: python -m benchmarks.fleet [N …]

Every campaign is a short one, a part of an example, with sensor noise of its own; the last model is
the first effect accepted. Seconds by the clock, and the largest memory of the parent and of a
worker.
"""

import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.report.small import write_small_campaign
from wheelhop.api.fleet import diagnose_fleet
from wheelhop.report.fleet import write_fleet_report

EXAMPLES = ("open-dry-friction", "open-driver-seat", "clean")
NOISE_M_S2 = 0.02


def main() -> None:
    """Print a line for every number of campaigns; leave the last overview in fleet.html."""
    for count in [int(word) for word in sys.argv[1:]] or [1, 4, 20]:
        with tempfile.TemporaryDirectory() as place:
            folders = [make(Path(place) / f"campaign-{i}", i) for i in range(count)]
            begin_s = time.monotonic()
            rows = diagnose_fleet(folders, Path(place) / "fleet.parquet", max_effects=1)
            seconds = time.monotonic() - begin_s
            write_fleet_report(Path("fleet.html"), rows)
            again_s = time.monotonic()
            diagnose_fleet(folders, Path(place) / "fleet.parquet", max_effects=1)
            again_s = time.monotonic() - again_s
        parent, worker = (
            resource.getrusage(who).ru_maxrss / 1024
            for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
        )
        print(
            f"{count:4d} campaigns: {seconds:6.0f} s, {seconds / count:5.1f} s each; parent"
            f" {parent:.0f} MB, largest worker {worker:.0f} MB; read again in {again_s:.2f} s;"
            f" {sum(bool(row['problem']) for row in rows)} without a verdict",
            flush=True,
        )


def make(folder: Path, number: int) -> Path:
    """A short campaign with noise of its own."""
    write_small_campaign(folder, EXAMPLES[number % len(EXAMPLES)])
    rng = np.random.default_rng(number)
    for file in (folder / "runs").glob("*.csv"):
        head, *lines = file.read_text().splitlines()
        table = np.array([line.split(",") for line in lines], float)
        table[:, 1:] += rng.normal(0.0, NOISE_M_S2, table[:, 1:].shape)
        np.savetxt(file, table, fmt="%.6f", delimiter=",", header=head, comments="")
    return folder


if __name__ == "__main__":
    main()
