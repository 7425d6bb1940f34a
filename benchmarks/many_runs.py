"""How reading a campaign and adding a run grow with its runs: python -m benchmarks.many_runs [N …]

Runs of 256 rows and eight channels of noise; processor seconds.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from wheelhop.campaign import read_campaign
from wheelhop.campaign.write import NewRun, add_run, new_campaign
from wheelhop.logger.recording import Channel, Recording

ROWS, RATE_HZ = 256, 100.0
POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
TRACK: dict[str, str | float] = {"kind": "washboard", "amplitude_mm": 15, "pitch_mm": 400}


def main() -> None:
    """Print a line for every number of runs."""
    for count in [int(word) for word in sys.argv[1:]] or [100, 400, 1600]:
        with tempfile.TemporaryDirectory() as folder:
            measure(Path(folder) / "campaign", count)


def measure(folder: Path, count: int) -> None:
    """Fill a campaign, read it, add a run more."""
    rng = np.random.default_rng(0)
    new_campaign(folder, "many runs", recording(rng), {})
    first = add_run(folder, recording(rng), run(0))
    toml = folder / "campaign.toml"
    head, entry = toml.read_text().split("[[run]]")
    entries = [entry.replace("run-0", f"run-{i}") for i in range(count)]
    toml.write_text("[[run]]".join([head, *(each.rstrip() + "\n\n" for each in entries)]))
    lines = first.read_text().splitlines(keepends=True)
    for i in range(1, count):  # every one another drive: its rows in another order
        times, rows = zip(*(line.split(",", 1) for line in lines[1:]), strict=True)
        text = [f"{t},{rows[k]}" for t, k in zip(times, rng.permutation(len(rows)), strict=True)]
        first.with_name(f"run-{i}.csv").write_text(lines[0] + "".join(text))
    begin = time.process_time()
    assert len(read_campaign(folder).runs) == count
    middle = time.process_time()
    add_run(folder, recording(rng), run(count))
    end = time.process_time()
    print(
        f"{count:6d} runs: read in {middle - begin:6.2f} s, {1e3 * (middle - begin) / count:.2f} ms"
        f" a run; one more added in {end - middle:.2f} s",
        flush=True,
    )


def recording(rng: np.random.Generator) -> Recording:
    """Noise."""
    values = rng.normal(0.0, 3.0, (ROWS, len(POINTS)))
    return Recording(values, RATE_HZ, tuple(Channel(p, "m/s²") for p in POINTS), averaging_s=0.01)


def run(i: int) -> NewRun:
    """A run to be fitted."""
    return NewRun(id=f"run-{i}", role="fit", speed_kmph=7.5, track=TRACK)


if __name__ == "__main__":
    main()
