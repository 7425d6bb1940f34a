"""Screening of an effect that adds heights nobody knows: how much of the residual they explain.

Any residual is explained to a part by heights that may be chosen freely: two unknowns for eight
channels. Two controls tell whether it was the ground. The rear wheels must meet what the front
wheels met: if heights of its own under every wheel make better use of their greater freedom, it was
not. And heights must be random: a residual of lines, which follow from the known track, is not.
"""

from __future__ import annotations

from math import log
from typing import NamedTuple

from wheelhop.effects import Effect
from wheelhop.fit import Explained, Fit, Ground, Noise, Spectrum, Workshop, explained, find_density

RANDOM = 4.0
"""Dispersion up to which heights are taken for random; 1.1 to 1.7 where they are, 30 and more where
they stand for friction, a stop or a wandering speed on tracks that repeat."""


class Heights(NamedTuple):
    """What heights of the best density would explain: its parameters, the drop of the cost, how
    much of that they are worth after their price, the degrees of freedom they spend, and the sum of
    squares they leave."""

    theta: dict[str, float]
    gain: float
    worth: float
    freedom: float
    rss: float


def screen_heights(workshop: Workshop, base: Fit, effect: Effect) -> Heights | None:
    """The heights that explain the base's residual best; None if no run rolls on a track."""
    if all(run.bench.simulator.series is None for run in base.runs):
        return None
    theta, noise, found = _best(workshop, base, effect, coherent=True)
    _, other_noise, control = _best(workshop, base, effect, coherent=False)
    evidence = found.evidence(base.size, noise.sigma)
    is_ground = evidence > control.evidence(base.size, other_noise.sigma)
    cost = sum(run.bench.cost(run.residual, base.sigma) for run in base.runs)
    worth = 2.0 * (evidence + base.size * log(base.sigma)) + cost
    gain = worth - found.log_volume
    if not is_ground or found.dispersion > RANDOM:
        worth = -abs(gain)
    return Heights(theta, gain, worth, found.freedom, noise.rss)


def _best(
    workshop: Workshop, base: Fit, effect: Effect, *, coherent: bool
) -> tuple[dict[str, float], Noise, Explained]:
    systems = workshop.systems(base.model)
    grounds = [
        (run, Ground(run.bench, base.model, systems[run.bench.drive], coherent))
        for run in base.runs
        if run.bench.simulator.series is not None
    ]
    spectra = [Spectrum.of(ground, run.residual, run.residual) for run, ground in grounds]
    parameters = workshop.parameters_of(effect)
    given = sum(len(run.own) for run in base.runs) + len(base.shared)
    start = {p.name: p.starts[0] for p in parameters}
    noise = Noise(base.rss, base.size - given, workshop.noise)
    theta, noise = find_density(effect, parameters, start, spectra, noise)
    return theta, noise, explained(effect, theta, spectra, noise.sigma)
