"""From strut, damper and linkage on the rig to the numbers of vehicle.toml."""

from pathlib import Path

import wheelhop as wh

rig = Path(__file__).parents[1] / "rig"
for end in ("front", "rear"):
    found = wh.wheel_rates(
        rig / f"{end}-strut.csv", rig / f"{end}-damper.csv", rig / f"{end}-linkage.csv"
    )
    print(
        f"{end}: wheel rate {found.stiffness_N_m:.0f} ± {found.stiffness_uncertainty_N_m:.0f} N/m,"
        f" damping {found.damping_N_s_m:.0f} ± {found.damping_uncertainty_N_s_m:.0f} N s/m"
    )
