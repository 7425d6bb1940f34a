"""The numbers of an effect: amplitudes, shapes and switches."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np

from wheelhop.campaign import CampaignError


class _Old(type):
    """Lets `Parameter(…)` make one of the three classes, as before there were three."""

    def __call__(cls, *args: Any, **named: Any) -> Any:
        if cls is Parameter:
            return _of_its_class(*args, **named)
        return super().__call__(*args, **named)


@dataclass(frozen=True)
class Parameter(metaclass=_Old):
    """One number of an effect: an `Amplitude`, a `Shape` or a `Switch`.

    ``span_s`` says when in its run a number acts that is free in every run: derivatives of numbers
    that act far apart come from one simulation.
    """

    name: str
    unit: str
    meaning: str
    scale: float
    lower: float = -np.inf
    upper: float = np.inf
    span_s: tuple[float, float] = (-np.inf, np.inf)

    @property
    def start(self) -> float:
        """Where a fit begins it: an amplitude where it is absent."""
        raise NotImplementedError

    @property
    def typical(self) -> float:
        """A value with which the effect shows clearly."""
        raise NotImplementedError


@dataclass(frozen=True)
class Amplitude(Parameter):
    """A number that vanishes with the effect: ``absent`` is its value then, and ``scale`` a clearly
    visible strength on the nominal vehicle."""

    absent: float = 0.0

    @property
    def start(self) -> float:
        """Its value where the effect is absent."""
        return self.absent

    @property
    def typical(self) -> float:
        """One scale from there."""
        return self.absent + self.scale


@dataclass(frozen=True)
class Switch(Amplitude):
    """An amplitude that physics fixes: an effect of this kind is there in full, 1, or not at all,
    0. Nothing is fitted."""

    scale: float = 1.0
    lower: float = 0.0
    upper: float = 1.0


@dataclass(frozen=True, kw_only=True)
class Shape(Parameter):
    """A number that means nothing while the amplitudes vanish (a knee velocity, a frequency).

    Screening tries each of its ``starts``, and ``scale`` is one standard deviation of what is
    believed about it beforehand: to be near ``believed``, or if that is None, near where it begins.
    """

    starts: tuple[float, ...]
    believed: float | None = None

    def __post_init__(self) -> None:
        if not self.starts:
            raise CampaignError(f"{self.name}: a shape begins somewhere: give it starts = (…,)")

    @property
    def start(self) -> float:
        """The first of its starts."""
        return self.starts[0]

    @property
    def typical(self) -> float:
        """The first of its starts."""
        return self.starts[0]


def _of_its_class(
    name: str,
    unit: str,
    meaning: str,
    scale: float,
    absent: float = 0.0,
    lower: float = -np.inf,
    upper: float = np.inf,
    starts: tuple[float, ...] = (),
    believed: float | None = None,
    switch: bool = False,
    span_s: tuple[float, float] = (-np.inf, np.inf),
) -> Amplitude | Shape:
    """What `Parameter` was called with, as one of the three."""
    kind = Shape if starts else Switch if switch else Amplitude
    message = f"{name}: write {kind.__name__}(…) instead of Parameter(…)"
    warnings.warn(message, DeprecationWarning, stacklevel=3)
    common = (name, unit, meaning, scale, lower, upper, span_s)
    if starts:
        return Shape(*common, starts=tuple(starts), believed=believed)
    return (Switch if switch else Amplitude)(*common, absent=absent)
