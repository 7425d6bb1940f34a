"""What a rig measured of one specimen: the complex modulus at some frequencies."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.material.error import MaterialError
from wheelhop.material.model import Array, ComplexArray

FEWEST = 4
"""Frequencies: three parameters and something to judge them by."""


@dataclass(frozen=True, eq=False)
class ModulusData:
    """The complex modulus of one specimen.

    ``frequency_hz`` (f,) rises; ``modulus`` (f,) is complex, N/m; ``uncertainty`` (f,) is one
    standard deviation of its real and of its imaginary part, N/m, NaN where nobody knows.
    """

    name: str
    frequency_hz: Array
    modulus: ComplexArray
    uncertainty: Array

    @property
    def omega(self) -> Array:
        """Angular frequency (f,), rad/s."""
        return 2 * np.pi * self.frequency_hz

    def part(self, which: NDArray[Any]) -> ModulusData:
        """The data at some of the frequencies: a mask or indices."""
        return replace(
            self,
            frequency_hz=self.frequency_hz[which],
            modulus=self.modulus[which],
            uncertainty=self.uncertainty[which],
        )


def checked(data: ModulusData) -> ModulusData:
    """The data in rising order of frequency.

    Raises `MaterialError` for values that are not finite, frequencies that are not positive or
    come twice, moduli that are not positive, and fewer than four frequencies.
    """
    data = data.part(np.argsort(data.frequency_hz, kind="stable"))
    frequency = data.frequency_hz
    for what, values in (
        ("frequency", frequency),
        ("dynamic modulus", data.modulus.real),
        ("loss modulus", data.modulus.imag),
    ):
        for f, value in zip(frequency, values, strict=True):
            if not np.isfinite(value):
                raise MaterialError(f"{data.name}: the {what} is {value}: leave the row out")
            if value <= 0.0:
                where = "" if what == "frequency" else f" at {f:g} Hz"
                why = {
                    "frequency": "frequencies are positive",
                    "dynamic modulus": "displacement and force count in opposite directions",
                    "loss modulus": "a specimen that gives energy; is the sign of the phase wrong?",
                }[what]
                raise MaterialError(f"{data.name}: the {what} is {value:g}{where}: {why}")
    twice = np.flatnonzero(np.diff(frequency) == 0.0)
    if len(twice):
        raise MaterialError(
            f"{data.name}: {frequency[twice[0]]:g} Hz comes twice; give each frequency once, and"
            " each amplitude in a file of its own"
        )
    if len(frequency) < FEWEST:
        number = "one frequency" if len(frequency) == 1 else f"{len(frequency)} frequencies"
        raise MaterialError(
            f"{data.name}: {number}; a model of three parameters needs at least {FEWEST}"
        )
    return data
