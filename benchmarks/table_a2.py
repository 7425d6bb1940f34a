"""Why Table A.2 of the thesis is not that of the equivalent vehicle: python -m benchmarks.table_a2

The ten unprinted numbers of a vehicle whose frame bends as well as it twists are chosen so that the
sinusoids of Table 2.1 and the guesses of Table A.2 come nearest together, once with the guesses
taken from the step at B1 alone and once from all four steps. What then is left is printed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, optimize

from wheelhop.identify import published
from wheelhop.identify.equivalent import STEP_TIME_S, step_responses
from wheelhop.identify.quarter_car import Struts
from wheelhop.identify.statespace import StateSpace
from wheelhop.identify.steps import refine

Array = NDArray[np.float64]

FIRST = np.array([0.405, 0.354, 0.415, 4.31, 16.6, 0.077, -0.387, 3.91, 29.3, 0.185])
"""Front share of the wheelbase, two radii of gyration; of the twist and of bending: stiffness over
the struts', rad/s, damping ratio; bending's motion of the rear over the front, before its three."""
LEAST = np.array([0.3, 0.2, 0.2, 0.5, 8.0, 0.001, -4.0, 0.3, 10.0, 0.001])
MOST = np.array([0.7, 1.2, 1.2, 80.0, 300.0, 0.7, 4.0, 80.0, 300.0, 0.7])
STEPS = {"the step at B1 alone": [0], "all four steps": [0, 1, 2, 3]}


def main() -> None:
    """Print what is left of both tables, per cent."""
    for name, which in STEPS.items():
        found = optimize.least_squares(
            off,
            FIRST,
            bounds=(LEAST, MOST),
            diff_step=1e-4,
            x_scale=np.abs(FIRST),
            args=(which,),
            max_nfev=30,
        )
        rest = 100 * off(found.x, which)
        print(f"{name}: Table 2.1 {np.round(rest[:12]).astype(int)} %")
        print(f"  Table A.2, σ and ω in its order: {np.round(rest[12:]).astype(int)} %")


def off(numbers: Array, which: list[int]) -> Array:
    """Relative differences from Table 2.1 (12,) and from Table A.2 (12,)."""
    responses, rest = step_responses(body(numbers)), []
    for printed in map(np.array, published.TABLE_2_1.values()):
        found = refine(STEP_TIME_S, responses, *printed.T, starts_at_rest=False)
        rest.append((np.column_stack([found.sigma, found.omega]) / printed - 1.0).ravel())
    increments = np.diff(responses, axis=2)[which]
    for count, pairs in published.TABLE_A_2.items():
        left = eigenvalues(increments, count)
        for sigma, omega in pairs:
            if not left:
                rest.append(-np.ones(2))
                continue
            near = min(left, key=lambda p: abs(p[0] / sigma - 1) + 3 * abs(p[1] / omega - 1))
            left.remove(near)
            rest.append(np.array([near[0] / sigma - 1.0, near[1] / omega - 1.0]))
    return np.concatenate(rest)


def body(numbers: Array) -> StateSpace:
    """S of the vehicle, as `EquivalentVehicle.body` with one mode more."""
    front, pitch, roll, *modes = numbers.tolist()
    struts, mass = Struts(*published.TABLE_2_2["old"]), published.SPRUNG_MASS_KG
    x, y = np.repeat([front, front - 1.0], 2), np.array([0.5, -0.5, 0.5, -0.5])
    flexible = (modes[:3], modes[4:])
    bending = np.array([1.0, 1.0, modes[3], modes[3]])
    shape = np.column_stack([np.ones(4), x, y, [1, -1, -1, 1], bending])
    stiff = np.array([f[0] * struts.stiffness.sum() for f in flexible])
    omega, zeta = (np.array([f[i] for f in flexible]) for i in (1, 2))
    m = np.diag([mass, mass * pitch**2, mass * roll**2, *(stiff / omega**2)])
    k = shape.T @ np.diag(struts.stiffness) @ shape + np.diag([0, 0, 0, *stiff])
    c = shape.T @ np.diag(struts.damping) @ shape + np.diag([0, 0, 0, *(2 * zeta * stiff / omega)])
    inverse, n = np.linalg.inv(m), len(m)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ k, -inverse @ c]])
    b = np.vstack([np.zeros((n, 4)), inverse @ shape.T])
    return StateSpace(a, b, np.hstack([shape, np.zeros((4, n))]), np.zeros((4, 4)))


def eigenvalues(increments: Array, count: int) -> list[tuple[float, float]]:
    """All pairs σ, ω of the incremental model (thesis A.1 to A.9)."""
    length = increments.shape[2] - count + 1
    z = np.concatenate([increments[:, :, k : k + length] for k in range(count)], axis=1)
    before, after = np.hstack(list(z[:, :, :-1])), np.hstack(list(z[:, :, 1:]))
    forward = linalg.lstsq(before.T, after.T, cond=1e-10)[0].T
    rates = np.log(np.linalg.eigvals(forward).astype(complex)) / (STEP_TIME_S[1] - STEP_TIME_S[0])
    return [(-r.real, r.imag) for r in rates.tolist() if 0.5 < r.imag < 150.0]


if __name__ == "__main__":
    main()
