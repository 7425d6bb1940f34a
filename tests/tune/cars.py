"""Small cars and roads that the tests of tuning share."""

from pathlib import Path

import numpy as np

from wheelhop.effects import load_effects
from wheelhop.predict import read_drives, read_effects
from wheelhop.predict.known_car import KnownCar
from wheelhop.tune.objectives import read_objectives
from wheelhop.tune.tuning import tune_car
from wheelhop.tune.variables import read_freedom
from wheelhop.vehicle import read_vehicle

FILE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
VEHICLE = read_vehicle(FILE)
ROAD = read_drives(["iso8608:unevenness_m3=1e-6:waviness=2:seed=1"], [20.0])
SHORT_S = 4.0


def car(effects=(), relative=0.0, misfit=0.0):
    """The example's car; its struts are known to `relative`, one standard deviation."""
    names = tuple(name for name in VEHICLE.values if name.startswith("suspension."))
    spread = np.array([relative * VEHICLE[name] for name in names])
    chosen = read_effects(effects, load_effects())
    return KnownCar(VEHICLE, chosen, names, np.diag(spread**2), misfit, True)


def tuned(known, vary, objectives=("comfort",), settings=40, drives=ROAD):
    """What a short search finds."""
    return tune_car(
        known,
        drives,
        read_objectives(objectives),
        read_freedom(vary, known),
        seconds=SHORT_S,
        settings=settings,
    )
