"""A campaign without a vehicle: what sensors would record, and what a fit makes of it."""

from pathlib import Path

import wheelhop as wh

vehicle = Path(__file__).parents[1] / "clean/vehicle.toml"
campaign = wh.simulate(
    vehicle,
    ["iso8608:unevenness_m3=4e-6:waviness=2:seed=1", "washboard/low"],
    [10.0, 15.0],
    "dry-friction:front_N=60",
    seed=3,
)
print(campaign.to_dataframe().to_string())
print(campaign.recording("iso8608-15kmph").to_dataframe().head(3).to_string())

# The model without friction leaves more than noise; with it, noise alone.
found = wh.compare(campaign, "dry-friction")
print(found)
print(found.ladder().to_string())
