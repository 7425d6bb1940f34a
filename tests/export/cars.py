"""Cars and a ground for what is exported: smooth, known in closed form, and rough enough that
joints slip, stops are struck and tyres lift off."""

from pathlib import Path

import numpy as np

from wheelhop.campaign import Averaging
from wheelhop.effects import load_effects
from wheelhop.predict import Case, read_drives, read_effects
from wheelhop.simulate.integrator import Task, integrate
from wheelhop.vehicle import read_vehicle

FOLDER = Path(__file__).parents[2] / "examples"
ROUGH = (
    "dry-friction:front_N=73:rear_N=54",
    "bump-stop:form=both:clearance_m=0.02",
    "tyre-lift-off",
    "driver-seat",
)
WAVES = ((0.02, 1.7, 0.3), (0.012, 4.1, 1.1), (0.004, 9.3, 2.2))
"""Amplitude, m, frequency, Hz, and phase of the ground; wheels meet it one after the other."""
LATE_S = (0.0, 0.031, 0.17, 0.21)


def model(effects=ROUGH):
    """The model of a car with effects."""
    chosen = read_effects(effects, load_effects())
    known = read_vehicle(FOLDER / "clean/vehicle.toml")
    return Case(known, chosen, read_drives(["washboard/low"], [10.0])).nominal


def ground(time_s, corners):
    """Heights of the ground (T, m), m, and their first three derivatives, from rest on."""
    found = np.zeros((4, len(time_s), len(corners)))
    for j, corner in enumerate(corners):
        at = np.asarray(time_s) - LATE_S[corner]
        for amplitude, frequency, phase in WAVES:
            w = 2 * np.pi * frequency
            for order in range(4):
                turned = w * at + phase + order * np.pi / 2
                found[order, :, j] += amplitude * w**order * np.sin(turned)
    return found


def ours(plant, step_s, steps):
    """What wheelhop's own integrator says of the outputs at the steps 1 … steps − 1."""
    time_s = step_s * np.arange(steps + 1)
    height, rate = ground(time_s, plant.corners)[:2]
    k, n = plant.system.force.shape[1], len(plant.system.mass)
    task = Task(plant.system, height, rate, np.zeros((2 * steps + 1, k)), np.zeros(2 * n))
    (found,) = integrate(
        [task], step_s=step_s, first=1, stride=1, averaging=Averaging(0.0), n_samples=steps - 1
    )
    return time_s, found
