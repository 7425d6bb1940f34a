"""The sample of a vehicle.toml, and the marks of numbers that nobody has measured."""

from __future__ import annotations

import re
from pathlib import Path

from wheelhop.campaign.types import CampaignError
from wheelhop.files import read_text

VEHICLE = """\
format = 1
name = {title}
# Numbers marked "sample" are those of a student-built ATV: put in yours and delete the mark.
relative_uncertainty = 0.30    # one standard deviation; KEY_uncertainty beside a KEY overrides it

[geometry]
wheelbase_m = 1.42             # sample
track_width_m = 1.18           # sample: between the left and right contact points
cg_to_front_axle_m = 0.80      # sample
cg_height_m = 0.52             # sample

[body]                         # sprung: driver, engine and battery included
mass_kg = 228.0                # sample
pitch_inertia_kg_m2 = 62.0     # sample
roll_inertia_kg_m2 = 25.0      # sample

[suspension.front]             # per wheel, acting vertically at the wheel
stiffness_N_m = 10500.0        # sample
damping_N_s_m = 630.0          # sample
[suspension.rear]
stiffness_N_m = 6500.0         # sample
damping_N_s_m = 590.0          # sample

[wheel.front]
unsprung_mass_kg = 15.0        # sample
tyre_stiffness_N_m = 40000.0   # sample
tyre_damping_N_s_m = 200.0     # sample
radius_m = 0.279               # sample
[wheel.rear]
unsprung_mass_kg = 12.5        # sample
tyre_stiffness_N_m = 40000.0   # sample
tyre_damping_N_s_m = 200.0     # sample
radius_m = 0.279               # sample

[driver]
mass_kg = 70.0                 # sample
x_m = -0.10                    # sample: ahead of the body's centre of mass
y_m = 0.0                      # sample
[engine]
mass_kg = 40.0                 # sample
x_m = -0.45                    # sample
y_m = 0.0                      # sample
"""


SAMPLE = "sample"
MARKED = re.compile(r"(?P<key>\w+)\s*=.*#\s*(?P<mark>\w+)")
TABLE = re.compile(r"\[(?P<name>[\w.]+)\]")


def marked_numbers(vehicle: Path, mark: str) -> list[str]:
    """The numbers of a vehicle.toml, by their dotted names, whose comment begins with this word:
    "sample" for those of our sample, "estimated" for guesses.

    Raises CampaignError for a file that cannot be read.
    """
    table, found = "", []
    for line in read_text(vehicle, CampaignError).splitlines():
        if heading := TABLE.match(line.strip()):
            table = f"{heading['name']}."
        elif (number := MARKED.match(line.strip())) and number["mark"] == mark:
            found.append(table + number["key"])
    return found
