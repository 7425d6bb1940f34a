"""Where the fit of a component begins: mass, damping and stiffness by least squares in band."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.campaign import ComponentCampaign, RigRun
from wheelhop.compare.band import InBand
from wheelhop.fit.parameters import Free
from wheelhop.simulate import Model
from wheelhop.vehicle import Motion
from wheelhop.vehicle.nominal import TERMS

Array = NDArray[np.float64]

REWEIGHTED = 5
"""Rounds of weighting with the response of the round before; most settle in two."""


def begin_component(campaign: ComponentCampaign, model: Model, free: Sequence[Free]) -> Model:
    """The model with those numbers of the component, of all that are free, whose linear response
    comes nearest to the fitted runs; the nominal ones if none comes nearer.

    Under an imposed force the equation m ẍ + c ẋ + k x = F is weighted with |x/F| of the last
    solution, so that displacements are compared (K. Steiglitz, L. McBride, IEEE Trans. Autom.
    Control 10 (1965) 461). A lightly damped resonance that the nominal numbers put beside the
    measured one would otherwise lead the fit through many small steps.
    """
    runs = [run for run in campaign.fit_runs if isinstance(run, RigRun)]
    parts = [_in_band(campaign, run) for run in runs]
    frequency, moved, force = (np.concatenate(part) for part in zip(*parts, strict=True))
    names = [f"component.{term}" for term in TERMS]
    bounds = {one.name: (one.lower, one.upper) for one in free}
    if not force.any():  # free decays show nothing but ratios
        bounds.pop("component.mass_kg", None)
    moving = [i for i, name in enumerate(names) if name in bounds]
    if not moving:
        return model
    low, high = np.array([bounds[names[i]] for i in moving]).T
    value = np.array([model.values[name] for name in names])
    best, least = value, np.inf
    for _ in range(REWEIGHTED):
        weight = _weight(campaign, value, frequency)
        equation = moved * weight[:, None]
        left = float(np.sum((equation @ value - force * weight) ** 2))
        if left < least:
            best, least = value, left
        fixed = np.delete(np.arange(3), moving)
        target = force * weight - equation[:, fixed] @ value[fixed]
        size = np.sqrt((equation[:, moving] ** 2).mean(axis=0))
        found = optimize.lsq_linear(
            equation[:, moving] / size, target, (low * size, np.maximum(high * size, low * size))
        )
        value = value.copy()
        value[moving] = found.x / size
    return model.with_values(dict(zip(names, best.tolist(), strict=True)))


def _in_band(campaign: ComponentCampaign, run: RigRun) -> tuple[Array, Array, Array]:
    """Frequency (size,), x, ẋ and ẍ (size, 3), and force (size,) in band."""
    band = InBand(len(run.time_s), campaign.sample_rate_hz, campaign.band_hz)
    moved = band.coefficients(Motion(campaign, run).at(run.time_s).T)
    return np.tile(band.frequency_hz, 2), moved, band.coefficients(run.force)


def _weight(campaign: ComponentCampaign, value: Array, frequency: Array) -> Array:
    """What turns a force that is left over into the measured quantity."""
    if campaign.drive == "displacement":
        return np.ones(len(frequency))
    omega = 2 * np.pi * frequency
    return np.asarray(1.0 / np.hypot(value[0] - value[2] * omega**2, value[1] * omega))
