"""From recordings in DataFrames to a campaign on disk, and to its first comparison.

Two files of an example stand for what another instrument has recorded, in g.
"""

from pathlib import Path
from tempfile import mkdtemp

import pandas as pd

import wheelhop as wh

STANDARD_GRAVITY = 9.80665  # m/s²
source = Path(__file__).parents[1] / "clean" / "runs"
folder = Path(mkdtemp()) / "my-campaign"


def recorded(run: str) -> pd.DataFrame:
    """A table with `time_s` and a column per sensor, in g."""
    table = pd.read_csv(source / f"{run}.csv").set_index("time_s")
    return (table / STANDARD_GRAVITY).add_suffix("_g")


# This instrument's samples are means over 6.6 ms.
slow = wh.Recording.from_dataframe(recorded("washboard-low-slow"), averaging_s=6.6e-3)
fast = wh.Recording.from_dataframe(recorded("washboard-low-fast"), averaging_s=6.6e-3)
print(slow)

# campaign.toml, and a vehicle.toml with numbers to replace by those of your vehicle.
wh.new_campaign(folder, "Two drives over one washboard", slow, places={})
track = {"kind": "washboard", "amplitude_mm": 15, "pitch_mm": 400}
wh.add_run(folder, slow, wh.NewRun("slow", role="fit", speed_kmph=7.5, track=track))
wh.add_run(folder, fast, wh.NewRun("fast", role="validate", speed_kmph=9.5, track=track))

campaign = wh.read(folder)
print(campaign.to_dataframe())
print(wh.compare(campaign).ladder())
