"""What a comparison says if other numbers of the vehicle are believed before the fit."""

from pathlib import Path

import wheelhop as wh

campaign = wh.read(Path(__file__).parents[1] / "clean").select(
    "washboard-low-slow", "washboard-high-fast", "herringbone-low-fast"
)
vehicle = wh.read_vehicle(campaign)
print(vehicle.to_dataframe().head())

softer = {
    f"suspension.{end}.stiffness_N_m": 0.7 * vehicle[f"suspension.{end}.stiffness_N_m"]
    for end in ("front", "rear")
}
stated = wh.compare(campaign)
believed_softer = wh.compare(campaign, vehicle=vehicle.with_values(softer))

# The recordings decide where they can; where they cannot, the belief stays.
numbers = stated.parameters().rename(columns={"value": "as_stated"})
numbers["believed_softer"] = believed_softer.parameters()["value"]
shown = numbers.filter(like="suspension", axis=0)[["as_stated", "believed_softer", "unit"]]
print(shown.round(1).to_string())
print(stated, believed_softer, sep="\n")
