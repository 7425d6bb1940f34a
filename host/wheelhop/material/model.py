"""What a model of the complex modulus is: M(iω) = M_d(ω) + i M_l(ω), a dynamic stiffness in N/m.

ω is in rad/s wherever a logarithm or a power of it is taken: the parameters mean nothing without
that unit.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True)
class Coefficient:
    """One parameter of a model: its name, its unit, and where it makes sense."""

    name: str
    unit: str
    lower: float = -np.inf
    upper: float = np.inf


class ModulusModel(ABC):
    """Base class. A model is linear in `weights` once its `shape` (an exponent, a relaxation time)
    is chosen; `basis` says how, and from there a fit finds where to begin."""

    id: ClassVar[str]
    title: ClassVar[str]  #: what it is, in one line
    equation: ClassVar[str]
    source: ClassVar[str]
    coefficients: tuple[Coefficient, ...]
    non_negative: ClassVar[bool] = False
    """Whether no weight may be negative."""

    @abstractmethod
    def modulus(self, omega: Array, parameters: Array) -> ComplexArray:
        """M(iω) (f,), N/m, at ω (f,), rad/s."""

    @abstractmethod
    def derivatives(self, omega: Array, parameters: Array) -> ComplexArray:
        """∂M/∂p (f, n) at ω (f,)."""

    @abstractmethod
    def shapes(self, omega: Array) -> Iterable[Array]:
        """Shapes worth a start, spread over what is plausible for data at ω (f,); all positive."""

    @abstractmethod
    def basis(self, omega: Array, shape: Array) -> ComplexArray:
        """M = basis (f, m) @ weights (m,)."""

    @abstractmethod
    def assembled(self, weights: Array, shape: Array) -> Array:
        """The parameters (n,) that weights and shape make."""

    def name_values(self, parameters: Array) -> dict[str, float]:
        """Values by name."""
        names = (c.name for c in self.coefficients)
        return dict(zip(names, parameters.tolist(), strict=True))

    @abstractmethod
    def admits(self, shape: Array) -> bool:
        """Whether the shape lies within its bounds."""

    @property
    def lower(self) -> Array:
        """Least values (n,)."""
        return np.array([c.lower for c in self.coefficients])

    @property
    def upper(self) -> Array:
        """Largest values (n,)."""
        return np.array([c.upper for c in self.coefficients])
