"""A part of the example campaigns: recorded from a simulator that shares no code with the model,
and short enough to be diagnosed in a test."""

import re
from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"
ROWS = {  # the runs that judge stay as long as they are: each second of them has a say
    "washboard-low-slow": 300,
    "washboard-high-fast": 300,
    "herringbone-low-fast": 300,
    "washboard-low-fast": 1024,
    "washboard-high-slow": 1024,
}


def write_small_campaign(folder: Path, example: str = "open-dry-friction") -> Path:
    """Three runs of three seconds and two of ten of an example, in `folder`, which is returned."""
    source = EXAMPLES / example
    (folder / "runs").mkdir(parents=True)
    head, *runs = (source / "campaign.toml").read_text().split("[[run]]\n")
    kept = [run for run in runs if re.search(r'id = "(.*)"', run)[1] in ROWS]
    (folder / "campaign.toml").write_text("[[run]]\n".join([head, *kept]))
    (folder / "vehicle.toml").write_text((source / "vehicle.toml").read_text())
    for name, rows in ROWS.items():
        lines = (source / f"runs/{name}.csv").read_text().splitlines()
        (folder / f"runs/{name}.csv").write_text("\n".join(lines[: rows + 1]) + "\n")
    return folder
