"""A run on a road nobody described, all struts measured: does what they do explain the body?

The forces along the measured travel move the body, whatever the road: y = H δ for the nominal
linear vehicle, y being accelerations and rates of the body. What a mistake would have made of the
channels is undone in their spectral matrix, and the share of every body channel that is explained
then is its likelihood.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.gate.match import MOST, Match, Places, log_likelihood
from wheelhop.gate.spectra import PADDING, Spectra
from wheelhop.simulate import Model, frequency_response
from wheelhop.simulate.measured import driving
from wheelhop.vehicle import wheels

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Struts:
    """What the nominal linear vehicle makes of the travel that is recorded: `shown` (f, b, w) at
    the frequencies of spectra, what the channels `body` hold per what the channels `pots` do; and
    the `weight` (f, b) of each, one over the power of the noise of both."""

    body: tuple[int, ...]
    pots: tuple[int, ...]
    shown: ComplexArray
    weight: Array

    @classmethod
    def of(
        cls, campaign: Campaign, values: Mapping[str, float], at_hz: Array, noise: Array
    ) -> Struts | None:
        """None unless every strut is measured, and something that they move."""
        column, rolling = driving(campaign, "travel"), wheels(values)
        if not set(rolling) <= set(column):
            return None
        places = {
            f"{c.key}.{axis}": 0.0
            for c in campaign.channels
            if c.point == "body"
            for axis in ("x_m", "y_m")
        }
        system = Model(values={**values, **places}).system(campaign.channels, "travel")
        pots = tuple(column[i] for i in rolling)
        moved = np.asarray(~np.isnan(system.output).any(axis=1))
        body = tuple(
            i
            for i, c in enumerate(campaign.channels)
            if c.is_on_body and moved[i] and i not in pots
        )
        if not body:
            return None
        scale = campaign.noise_scale
        ratio = np.array([campaign.channels[i].per_wheel for i in pots])
        shown = frequency_response(system, at_hz)[:, body]
        shown = shown * (scale[list(pots)] / ratio) / scale[list(body)][:, None]
        power = (np.abs(shown) ** 2 * noise[list(pots)] ** 2).sum(axis=2) + noise[list(body)] ** 2
        return cls(body, pots, np.asarray(shown), 1.0 / power)


@dataclass(frozen=True, eq=False)
class ByTravel:
    """A run on any road, by what its struts do."""

    spectra: Spectra
    struts: Struts

    @property
    def run(self) -> Run:
        """The run."""
        return self.spectra.run

    def match(self, speeds_m_s: Array, places: Sequence[Places], rate: float = 1.0) -> list[Match]:
        """The share of each body channel that travel explains, as it would be were the record made
        as a description says; speed and sample rate it does not tell."""
        found = []
        for place in places:
            shares = self._shares(place)
            likely = float(np.mean([log_likelihood(self.spectra, share) for share in shares]))
            found.append(Match(float(shares.mean()), np.nan, float(np.mean(speeds_m_s)), likely))
        return found

    def is_told(self, speed: float, gain: float) -> bool:
        """What it says depends on neither."""
        return True

    def _shares(self, place: Places) -> Array:
        """Of each channel of the body (b,)."""
        lines = self.spectra.lines[::PADDING]
        count, shown = lines.shape[1], self.struts.shown
        wanted = [*self.struts.body, *self.struts.pots]
        holder = {place.of(column)[0]: column for column in range(count)}
        undone = np.zeros((len(lines), len(wanted), count), np.complex128)
        for row, channel in enumerate(wanted):
            column = holder.get(channel, channel)
            turned = np.exp(2j * np.pi * self._hertz * place.late(column))
            undone[:, row, column] = turned / place.of(column)[1]
        b = len(self.struts.body)
        true = undone @ lines @ undone.conj().swapaxes(1, 2)
        apart = np.concatenate([np.tile(np.eye(b), (len(lines), 1, 1)), -shown], axis=2)
        left = np.einsum("fbi,fij,fbj->fb", apart, true, apart.conj()).real
        held = np.einsum("fbb->fb", true[:, :b, :b]).real
        weight = self.struts.weight
        share = 1.0 - (weight * left).sum(axis=0) / np.maximum((weight * held).sum(axis=0), 1e-300)
        return np.asarray(np.clip(share, 0.0, MOST))

    @property
    def _hertz(self) -> Array:
        return self.spectra.frequency_hz[::PADDING]
