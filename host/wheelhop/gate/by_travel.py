"""A run on a road nobody described, all struts measured: does what they do explain the body?

The forces along the measured travel move the body, whatever the road: y = H δ for the nominal
linear vehicle, y being accelerations and rates of the body. What a mistake would have made of the
channels is undone in their spectral matrix, and the share of every body channel that is explained
then is its likelihood.

H is a sum of what every end's springs and dampers do, and each may do more or less than stated, as
far as is believed: they have the likeliest sizes under every description. Else a soft spring, or a
damper that a law weakens, passes for a wrong ratio of sensor to wheel, which changes both alike.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run
from wheelhop.gate.match import MOST, Match, Places, log_likelihood
from wheelhop.gate.spectra import PADDING, Spectra
from wheelhop.simulate import Model, frequency_response
from wheelhop.simulate.measured import driving
from wheelhop.vehicle import Vehicle, axle_name, wheels

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


FORCES = ("stiffness_N_m", "damping_N_s_m")
ROUNDS = 4
"""So often the weights of channels follow what is left of them."""


@dataclass(frozen=True, eq=False)
class Struts:
    """What the nominal linear vehicle makes of the travel that is recorded: `shown` (f, b, w) at
    the frequencies of spectra, what the channels `body` hold per what the channels `pots` do; of
    that `parts` (j, f, b, w) are the springs' and the dampers' of every end, believed to `spread`
    (j,), relative; and the `weight` (f, b) of each, one over the power of the noise of both."""

    body: tuple[int, ...]
    pots: tuple[int, ...]
    shown: ComplexArray
    parts: ComplexArray
    spread: Array
    weight: Array

    @classmethod
    def of(cls, campaign: Campaign, vehicle: Vehicle, at_hz: Array, noise: Array) -> Struts | None:
        """None unless every strut is measured, and something that they move."""
        values = vehicle.values
        column, rolling = driving(campaign, "travel"), wheels(values)
        if not set(rolling) <= set(column):
            return None
        places = {
            f"{c.key}.{axis}": 0.0
            for c in campaign.channels
            if c.point == "body"
            for axis in ("x_m", "y_m")
        }
        pots = tuple(column[i] for i in rolling)
        scale = campaign.noise_scale
        ratio = np.array([campaign.channels[i].per_wheel for i in pots])

        def answer(changed: Mapping[str, float]) -> ComplexArray:
            model = Model(values={**values, **places, **changed})
            found = frequency_response(model.system(campaign.channels, "travel"), at_hz)
            return np.asarray(found * (scale[list(pots)] / ratio) / scale[:, None])

        shown = answer({})
        moved = np.asarray(~np.isnan(shown).any(axis=(0, 2)))
        body = tuple(
            i
            for i, c in enumerate(campaign.channels)
            if c.is_on_body and moved[i] and i not in pots
        )
        if not body:
            return None
        ends = dict.fromkeys(axle_name(i) for i in rolling)
        forces = [f"suspension.{end}.{force}" for end, force in product(ends, FORCES)]
        # The body's motion is linear in them: twice as much shows what each does.
        parts = np.array([answer({key: 2 * values[key]}) - shown for key in forces])
        spread = np.array([vehicle.uncertainty[key] / values[key] for key in forces])
        shown, parts = shown[:, body], parts[:, :, body]
        power = (np.abs(shown) ** 2 * noise[list(pots)] ** 2).sum(axis=2) + noise[list(body)] ** 2
        return cls(body, pots, shown, parts, np.maximum(spread, np.finfo(float).eps), 1.0 / power)


@dataclass(frozen=True, eq=False)
class ByTravel:
    """A run on any road, by what its struts do; one of so many `runs` of a vehicle."""

    spectra: Spectra
    struts: Struts
    runs: int
    _found: dict[Places, Match] = field(default_factory=dict)

    @property
    def run(self) -> Run:
        """The run."""
        return self.spectra.run

    def match(self, speeds_m_s: Array, places: Sequence[Places], rate: float = 1.0) -> list[Match]:
        """The share of each body channel that travel explains, as it would be were the record made
        as a description says; speed and sample rate it does not tell."""
        speed = float(np.mean(speeds_m_s))
        for place in places:
            if place not in self._found:
                share, likely = self._likeliest(place)
                self._found[place] = Match(share, np.nan, speed, likely)
        return [self._found[place] for place in places]

    def is_told(self, speed: float, gain: float) -> bool:
        """What it says depends on neither."""
        return True

    def _likeliest(self, place: Places) -> tuple[float, float]:
        """The share explained and the likelihood with the likeliest springs and dampers. What is
        believed of them counts once in all runs."""
        products, power = self._products(place)
        nothing, along, square = products[:, 0, 0], products[:, 1:, 0], products[:, 1:, 1:]
        told = 1.0 / (self.runs * self.struts.spread**2)
        left: Array = nothing
        more: Array = np.zeros(len(told))
        for _ in range(ROUNDS):
            weight = self.spectra.blocks / len(power) / np.maximum(left, (1.0 - MOST) * power)
            matrix = np.tensordot(weight, square, 1) + np.diag(told)
            more = np.asarray(np.linalg.solve(matrix, weight @ along), np.float64)
            left = np.asarray(nothing - 2.0 * along @ more + (square @ more) @ more)
        share = np.clip(1.0 - left / power, 0.0, MOST)
        likely = np.mean([log_likelihood(self.spectra, each) for each in share])
        return float(share.mean()), float(likely - 0.5 * (told @ more**2))

    def _products(self, place: Places) -> tuple[Array, Array]:
        """Of each channel of the body what is left of it, and its parts, multiplied with each other
        (b, 1 + j, 1 + j), and its power (b,)."""
        struts, count = self.struts, self.spectra.lines.shape[1]
        holder = {place.of(column)[0]: column for column in range(count)}
        columns = np.array([holder.get(i, i) for i in (*struts.body, *struts.pots)])
        late = np.array([place.late(column) for column in columns])
        gain = np.array([place.of(column)[1] for column in columns])
        undone = np.exp(2j * np.pi * np.outer(self._hertz, late)) / gain
        true = self.spectra.lines[::PADDING, columns[:, None], columns]
        true = true * undone[:, :, None] * undone[:, None].conj()
        b = len(struts.body)
        among = np.array([[i, *range(b, len(columns))] for i in range(b)])
        mine = true[:, among[:, :, None], among[:, None]]  # (f, b, 1 + w, 1 + w)
        weighed = (self._rows @ mine) * struts.weight[:, :, None, None]
        flat = weighed.transpose(1, 2, 0, 3).reshape(b, self._rows.shape[2], -1)
        rows = self._rows.transpose(1, 2, 0, 3).reshape(flat.shape)
        products = (flat @ rows.conj().swapaxes(1, 2)).real
        held = np.einsum("fb,fb->b", mine[:, :, 0, 0].real, struts.weight)
        return products, np.maximum(held, 1e-300)

    @cached_property
    def _rows(self) -> ComplexArray:
        """What is left of a channel of the body, and its parts, of the channel itself and of all
        travel (f, b, 1 + j, 1 + w)."""
        of_travel = np.concatenate([-self.struts.shown[None], self.struts.parts])
        itself = np.zeros((*of_travel.shape[:3], 1))
        itself[0] = 1.0
        return np.ascontiguousarray(np.concatenate([itself, of_travel], 3).transpose(1, 2, 0, 3))

    @property
    def _hertz(self) -> Array:
        return self.spectra.frequency_hz[::PADDING]
