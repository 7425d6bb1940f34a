"""Files that show every key of every file people write: what schemas are traced from."""

from __future__ import annotations

import tomllib

from wheelhop.campaign.tracks import KINDS
from wheelhop.files import to_toml
from wheelhop.vehicle.layout import FULL_CAR, MODELS
from wheelhop.vehicle.vehicle import NEEDS

HEAD = """format = 1
kind = "vehicle"
title = "all keys"
vehicle = "vehicle.toml"
sample_rate_hz = 100.0
band_hz = [0.5, 30.0]
averaging_ms = 10.0
"""
CHANNELS = """noise_rms_m_s2 = 0.1
noise_rms_m = 0.0002
noise_rms_rad_s = 0.004
noise_rms_N = 8.0
FILTER
[channels]
B1 = "B1"
dash = [0.35, 0.0]
imu = "body"
pot = { quantity = "travel", corner = 1, per_wheel = 0.65, noise_rms_m = 0.0002 }
gyro = { quantity = "rate", axis = "pitch", noise_rms_rad_s = 0.004, scale_uncertainty = 0.02 }
rod = { quantity = "force", corner = 1, per_wheel = 1.4, noise_rms_N = 8.0 }
hub = { quantity = "acceleration", position = "A3", noise_rms_m_s2 = 0.1 }
gps = { quantity = "speed" }
ax = { quantity = "acceleration", axis = "x", position = [0.1, 0.0] }
seat = { quantity = "acceleration", on = "driver" }
rpm = { quantity = "speed", of = "engine" }
[factors]
B1 = -1.0
"""
FILTERS = (
    'filter = { kind = "bessel", order = 4, corner_hz = 40.0, zero_phase = true, delay_ms = 1.0 }',
    'filter = { kind = "fir", taps = [0.5, 0.5], rate_hz = 200.0 }',
)
VALUES = {
    **{"amplitude_mm": "15.0", "pitch_mm": "400.0", "side": '"left"', "file": '"file.csv"'},
    **{"seed": "1", "unevenness_m3": "4e-6", "waviness": "2.0", "angle_deg": "20.0"},
}
"""Of a track's keys; of the others 500."""
COURSE = """speed_along = [[0, 5.0], [20, 12.0]]
start_m = -5.0
start_m_uncertainty = 0.5
setting = "soft"
"""


def campaigns() -> list[str]:
    """Campaigns of a vehicle, a run on every kind of track, and of a component."""
    runs = []
    for kind, keys in KINDS.items():
        stated = {key: VALUES.get(key, "500.0") for key in keys}
        track = "".join(f"track.{key} = {value}\n" for key, value in stated.items())
        run = f'[[run]]\nid = "{kind}"\nfile = "runs/{kind}.csv"\nrole = "fit"\nspeed_kmph = 9.0\n'
        runs.append(f'{run}track.kind = "{kind}"\n{track}')
    vehicle = [HEAD + CHANNELS.replace("FILTER", each) + "\n".join(runs) for each in FILTERS]
    return [*vehicle, HEAD + runs[0] + COURSE, HEAD.replace("averaging_ms = 10.0\n", "") + runs[0]]


def components() -> list[str]:
    """Campaigns of a component, under an imposed displacement and force."""
    part = """[component]
mass_kg = MASS
mass_kg_uncertainty = 0.1
stiffness_N_m = 20000.0
stiffness_N_m_uncertainty = 100.0
damping_N_s_m = 900.0
damping_N_s_m_uncertainty = 90.0
relative_uncertainty = 0.2
mount = "specimen.toml"

[factors]
force_N = -1.0

[[run]]
id = "sine"
file = "runs/flat.csv"
role = "fit"
"""
    head = HEAD.replace("vehicle.toml", "x").replace('vehicle = "x"\n', "")
    head = head.replace('"vehicle"', '"component"').replace("averaging_ms = 10.0\n", "")
    return [
        head + f'drive = "displacement"\nnoise_rms_N = 2.0\n\n{part.replace("MASS", "0.0")}',
        head + f'drive = "displacement"\n\n{part.replace("MASS", chr(34) + "massless" + chr(34))}',
        head
        + 'drive = "force"\nnoise_rms_m = 1e-5\n\n'
        + part.replace("MASS", "2.0").replace("relative_uncertainty = 0.2", OTHER),
        head + 'drive = "force"\n\n' + WORDS + part[part.index("\n[[run]]") :],
    ]


OTHER = "relative_uncertainty = 0.3"
WORDS = """[component]
mass_kg = "unknown"
stiffness_N_m = "unknown"
damping_N_s_m = "none"
preload = "unknown"
relative_uncertainty = 0.2
"""
PLACED = "mass_kg = 20.0\nx_m = 0.1\ny_m = 0.0\n"
MOUNTED = f"{PLACED}stiffness_N_m = 30000.0\ndamping_N_s_m = 300.0\n"
VEHICLE = f"""format = 1
name = "all keys"
model = "full-car"
relative_uncertainty = 0.1
mount = "specimen.toml"

[frame]
file = "frame.toml"
modes = 2
damping_ratio = 0.02

[measured]
total_mass_kg = 291.0
total_mass_kg_uncertainty = 2.0
front_axle_kg = 130.0
rear_axle_kg = 161.0
front_ride_hz = 1.5
rear_ride_hz = 1.6

[geometry]
wheelbase_m = 1.42
track_width_m = 1.18
cg_to_front_axle_m = 0.75
cg_height_m = 0.5

[body]
mass_kg = 251.0
pitch_inertia_kg_m2 = 60.0
roll_inertia_kg_m2 = 40.0

[suspension.front]
stiffness_N_m = 12000.0
damping_N_s_m = 900.0

[suspension.rear]
stiffness_N_m = 14000.0
damping_N_s_m = 900.0

[wheel.front]
unsprung_mass_kg = 15.0
tyre_stiffness_N_m = 50000.0
tyre_damping_N_s_m = 100.0
radius_m = 0.28
width_m = 0.2

[wheel.rear]
unsprung_mass_kg = 15.0
tyre_stiffness_N_m = 50000.0
tyre_damping_N_s_m = 100.0
radius_m = 0.28

[driver]
{MOUNTED}
[engine]
{PLACED}
[battery]
{MOUNTED}
[payload]
{MOUNTED}"""


def vehicles() -> list[str]:
    """A vehicle of every model, with all the numbers that it has."""
    found = [VEHICLE, VEHICLE.replace('model = "full-car"\n', "")]
    for model, motions in MODELS.items():
        about = tomllib.loads(VEHICLE) | {"model": model}
        del about["measured"]
        if model != FULL_CAR:
            del about["frame"]
        lacking = set(NEEDS) - set(motions)
        gone = [key for motion in lacking for key in NEEDS[motion]]
        for key in [*gone, *(["geometry"] if lacking == set(NEEDS) else [])]:
            group, _, last = key.rpartition(".")
            (about[group] if group else about).pop(last, None)
        found.append(to_toml(about))
    return found


CALIBRATION = """format = 1
id = "bench"
device = 7

[[sensor]]
channel = "B1"
serial = "0123"
gain_m_s2_per_code = 0.3
gain_m_s2_per_code_expanded = 0.001
offset_code = 512.0
offset_code_expanded = 1.0
corner_hz = 50.0
corner_hz_expanded = 2.0
delay_s = 0.001
delay_s_expanded = 0.0001
date = 2026-05-31
valid_until = 2027-05-31
method = "flip"
reference = "gravity"
certificate = "none"
temperature_C = 21.0
supply_V = 5.0

[[sensor]]
channel = "B2"
gain_m_s2_per_code = 0.3
gain_m_s2_per_code_expanded = 0.001
offset_code = 512.0
offset_code_expanded = 1.0
date = 2026-05-31
valid_until = 2027-05-31
"""
