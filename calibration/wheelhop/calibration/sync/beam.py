"""A cantilever with point masses, exactly: dynamic stiffness of Euler-Bernoulli segments.

    E I (1 + iη) w'''' − ρ A ω² w = 0 between the points, w = w' = 0 at the clamp

The harmonic stiffness matrix of a segment relates forces and moments at its two ends to deflections
and slopes there without any approximation (R. Clough, J. Penzien, Dynamics of Structures, dynamic
direct stiffness method). Point masses and springs add to its diagonal. Natural frequencies are
counted, so that none is missed (W. Wittrick, F. Williams, Q. J. Mech. Appl. Math. 24, 1971).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

SHORT = 0.1  # β l below which cos and cosh cancel; the series is exact to (β l)⁸ there
SAME = 1e-3  # of the length: nearer points are one, a shorter segment is too stiff for the numbers
RELATIVE_STEP = 1e-10  # to which a natural frequency is bisected
Matrix = NDArray[np.float64] | NDArray[np.complex128]


@dataclass(frozen=True)
class Beam:
    """A clamped-free beam of one section, SI units, positions measured from the clamp.

    `stations_m` are the points with something on them, `masses_kg` and `springs_N_m` (to ground)
    what is there; rotary inertia and shear are neglected, as is right for a slender beam.
    """

    length_m: float
    bending_stiffness_N_m2: float
    mass_per_length_kg_m: float
    stations_m: tuple[float, ...]
    masses_kg: tuple[float, ...]
    springs_N_m: tuple[float, ...]

    @classmethod
    def rectangular(
        cls,
        length_m: float,
        width_m: float,
        height_m: float,
        youngs_modulus_Pa: float,
        density_kg_m3: float,
    ) -> "Beam":
        """A bare beam of rectangular section that bends along its height."""
        area, second_moment = width_m * height_m, width_m * height_m**3 / 12
        return cls(length_m, youngs_modulus_Pa * second_moment, density_kg_m3 * area, (), (), ())

    def carrying(self, at_m: float, mass_kg: float = 0.0, spring_N_m: float = 0.0) -> "Beam":
        """The beam with one thing more on it."""
        return Beam(
            self.length_m,
            self.bending_stiffness_N_m2,
            self.mass_per_length_kg_m,
            (*self.stations_m, at_m),
            (*self.masses_kg, mass_kg),
            (*self.springs_N_m, spring_N_m),
        )

    def receptance(
        self, frequency_hz: ArrayLike, force_at_m: float, at_m: ArrayLike, loss_factor: float = 0.0
    ) -> NDArray[np.complex128]:
        """Deflection per harmonic force, (n_frequencies, n_points), m/N; e^{+iωt}.

        Structural damping: E (1 + iη), η = `loss_factor`.
        """
        points = np.atleast_1d(np.asarray(at_m, dtype=np.float64))
        nodes = self._nodes((*points, force_at_m))
        driven = _nearest(nodes, force_at_m)
        wanted = [2 * _nearest(nodes, point) for point in points]
        out = []
        for frequency in np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64)):
            stiffness = self._assembled(nodes, 2 * np.pi * frequency, loss_factor)
            force, motion = np.zeros(len(stiffness)), np.zeros(len(stiffness), np.complex128)
            force[2 * driven] = 1.0
            motion[2:] = np.linalg.solve(stiffness[2:, 2:], force[2:])
            out.append(motion[wanted])
        return np.array(out, dtype=np.complex128)

    def natural_frequencies_hz(self, below_hz: float) -> NDArray[np.float64]:
        """All undamped natural frequencies below a limit, ascending, Hz."""
        found = []
        for number in range(1, self._count(below_hz) + 1):
            low, high = 0.0, below_hz
            while high - low > RELATIVE_STEP * high:
                middle = (low + high) / 2
                low, high = (middle, high) if self._count(middle) < number else (low, middle)
            found.append((low + high) / 2)
        return np.array(found)

    def _count(self, frequency_hz: float) -> int:
        """How many natural frequencies lie below: J = Σ clamped segments' + negative pivots."""
        omega = 2 * np.pi * frequency_hz
        nodes = self._nodes(())
        stiffness = self._assembled(nodes, omega, 0.0)[2:, 2:]
        negative = int(np.sum(np.linalg.eigvalsh(stiffness) < 0))
        return negative + sum(_clamped_below(self._beta(omega) * l_m) for l_m in np.diff(nodes))

    def _beta(self, omega: float) -> float:
        ratio = self.mass_per_length_kg_m * omega**2 / self.bending_stiffness_N_m2
        return float(ratio**0.25)

    def _nodes(self, more: tuple[float, ...]) -> NDArray[np.float64]:
        nodes = [0.0, self.length_m]
        for point in (*self.stations_m, *more):
            if min(abs(point - node) for node in nodes) > SAME * self.length_m:
                nodes.append(point)
        return np.sort(nodes)

    def _assembled(self, nodes: NDArray[np.float64], omega: float, loss_factor: float) -> Matrix:
        """(2n, 2n) deflection and slope of each node, the clamp's first."""
        bending: complex | float = self.bending_stiffness_N_m2
        if loss_factor:
            bending = bending * (1 + 1j * loss_factor)
        total = np.zeros((2 * len(nodes), 2 * len(nodes)), dtype=type(bending))
        for i, length in enumerate(np.diff(nodes)):
            block = slice(2 * i, 2 * i + 4)
            total[block, block] += _segment(bending, self.mass_per_length_kg_m, length, omega)
        for at, mass, spring in zip(self.stations_m, self.masses_kg, self.springs_N_m, strict=True):
            row = 2 * _nearest(nodes, at)
            total[row, row] += spring - mass * omega**2
        return total


def _nearest(nodes: NDArray[np.float64], point: float) -> int:
    return int(np.argmin(np.abs(nodes - point)))


def _segment(bending: complex | float, mass_per_m: float, length: float, omega: float) -> Matrix:
    """(4, 4) dynamic stiffness for w₁ w₁' w₂ w₂'; its static limit is the Hermite beam element."""
    scale = np.array([1.0, length, 1.0, length])
    beta_l = (mass_per_m * omega**2 * length**4 / bending) ** 0.25
    if abs(beta_l) < SHORT:
        inertia = mass_per_m * omega**2 * length**4 / bending
        unit = _STATIC - inertia * _CONSISTENT / 420
    else:
        c, s, ch, sh = np.cos(beta_l), np.sin(beta_l), np.cosh(beta_l), np.sinh(beta_l)
        force = beta_l**3 * np.array([c * sh + s * ch, -(s + sh)])
        mixed = beta_l**2 * np.array([s * sh, ch - c])
        moment = beta_l * np.array([s * ch - c * sh, sh - s])
        unit = np.array(
            [
                [force[0], mixed[0], force[1], mixed[1]],
                [mixed[0], moment[0], -mixed[1], moment[1]],
                [force[1], -mixed[1], force[0], -mixed[0]],
                [mixed[1], moment[1], -mixed[0], moment[0]],
            ]
        ) / (1 - c * ch)
    return np.asarray(bending / length**3 * unit * np.outer(scale, scale))


def _clamped_below(beta_l: float) -> int:
    """Natural frequencies of a clamped-clamped segment below β l: those of cos cosh = 1."""
    whole = int(beta_l / np.pi)
    if whole == 0:
        return 0
    sign = np.sign(1 - np.cos(beta_l) * np.cosh(beta_l))
    return int(whole - (1 - (-1) ** whole * sign) // 2)


_STATIC = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
_CONSISTENT = np.array(
    [[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]], dtype=float
)
