"""Which runs would tell most of a vehicle, before anyone has driven."""

from pathlib import Path

import wheelhop as wh

vehicle = Path(__file__).parents[1] / "clean/vehicle.toml"
advised = wh.plan(
    vehicle,
    ["washboard/low", "herringbone/high", "one-sided-washboard/low"],
    [5.0, 12.0],
    runs=3,
    only=["dry-friction", "digressive-damper", "anti-roll-bar"],
)
print(advised.to_dataframe().head(3).to_string())

# From what strength on, as a share of what is clearly visible, these runs would show each effect
# and tell it from its nearest rival; and what they would leave of each number's uncertainty.
for told in advised.told:
    print(f"{told.effect}: shown from {told.shown_from:.3f}, told from {told.rival}")
    print(f"    from {told.told_from:.3f}; what the two do lies {told.angle_deg:.0f} degrees apart")
before, after = advised.uncertainty["wheel.front.radius_m"]
print(f"front wheel's radius: ±{1e3 * before:.1f} mm believed, ±{1e3 * after:.1f} mm afterwards")
