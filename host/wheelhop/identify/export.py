"""A transfer matrix in the forms other programs read: states, poles and residues, polynomials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS, CampaignError
from wheelhop.files import replacing
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.statespace import StateSpace, of_fractions
from wheelhop.identify.structure import input_name

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def state_space(model: TransferMatrix) -> StateSpace:
    """H(s) with order · m states. `control.ss(h.a, h.b, h.c, h.d)` of it is python-control's."""
    system = of_fractions(model.sections, model.theta)
    if model.suspensions is None:
        return system
    # C (sI - A)⁻¹ B (1 + τ s) κ = C (sI - A)⁻¹ (B + τ A B) κ + τ C B κ
    at = model.suspensions.factor(
        model.suspensions.value, np.array([0.0, 1.0], complex), model.inputs
    ).real
    ratio, tau = at[0], at[1] / at[0] - 1.0
    b = (system.b + system.a @ system.b * tau) * ratio
    return StateSpace(system.a, b, system.c, system.c @ system.b * tau * ratio)


def poles_and_residues(model: TransferMatrix) -> tuple[ComplexArray, ComplexArray, Array]:
    """Poles (k,), of conjugate pairs the one above the axis, residues (n, m, k) and constant term
    (n, m), as scikit-rf's VectorFitting keeps them: H = Σ r/(s - p) (+ conjugates) + d.

    Raises ValueError for a pole that appears twice, which has no residue.
    """
    system = state_space(model)
    a, b, c = model.sections.state_matrix()
    values, left = np.linalg.eig(a)
    gaps = np.abs(values[:, None] - values) + np.diag(np.full(len(values), np.inf))
    if gaps.min() < 1e-9 * np.abs(values).max():
        raise ValueError("two poles coincide: there are no residues")
    weight = np.linalg.solve(left, b.astype(complex))
    residues = np.einsum("ijl,lm,mp,p->ijp", model.theta, c, left, weight)
    if model.suspensions is not None:
        factor = model.suspensions.factor(model.suspensions.value, values, model.inputs)
        residues = residues * factor.T[None]
    keep = values.imag >= -1e-12 * np.abs(values)
    return values[keep], residues[:, :, keep], system.d


def polynomials(model: TransferMatrix) -> tuple[Array, Array]:
    """Numerators (n, m, order + 1) and the monic denominator (order + 1,), highest power first."""
    sections = model.sections
    denominator = sections.denominator()
    n, m = sections.order, len(sections.omega)
    over = np.zeros((n, n + 1))
    for k in range(m):
        factor = [1.0, 2 * sections.zeta[k] * sections.omega[k], sections.omega[k] ** 2]
        rest = np.polydiv(denominator, factor)[0]
        over[k, 2:] = sections.omega[k] ** 2 * rest
        over[m + k, 1:-1] = sections.omega[k] * rest
    if sections.rate is not None:
        over[-1, 1:] = sections.rate * np.polydiv(denominator, [1.0, sections.rate])[0]
    numerators = model.theta @ over
    if model.suspensions is not None:
        at = model.suspensions.factor(
            model.suspensions.value, np.array([0.0, 1.0], complex), model.inputs
        ).real
        slope = (at[1] - at[0])[None, :, None]
        by_s = np.concatenate([numerators[:, :, 1:], np.zeros((*numerators.shape[:2], 1))], axis=2)
        numerators = numerators * at[0][None, :, None] + slope * by_s
    return numerators, denominator


def to_json(model: TransferMatrix) -> dict[str, Any]:
    """The matrix as plain numbers: sections with standard errors, polynomials, structure."""
    numerators, denominator = polynomials(model)
    structure = model.structure
    return {
        "inputs": [input_name(corner) for corner in model.inputs],
        "outputs": [BODY_POINTS[corner] for corner in model.outputs],
        "order": model.order,
        "structure": {
            "symmetry": structure.symmetry,
            "left_right": structure.left_right,
            "rigid": structure.rigid,
            "stable": structure.stable,
        },
        "modes": [
            {"frequency_hz": f, "frequency_se_hz": df, "damping_ratio": z, "damping_ratio_se": dz}
            for f, df, z, dz in model.poles_table()
        ],
        "real_pole_1_s": None if model.sections.rate is None else -model.sections.rate,
        "suspensions": None
        if model.suspensions is None
        else dict(
            zip(
                ("stiffness_rear_over_front", "time_front_s", "time_rear_s"),
                model.suspensions.value.tolist(),
                strict=True,
            )
        ),
        "denominator": denominator.tolist(),
        "numerators": numerators.tolist(),
    }


def write_mat(model: TransferMatrix, path: Path) -> None:
    """Write A, B, C, D, num, den, and poles and residues unless two poles coincide, for MATLAB:
    `ss(A, B, C, D)` is H.

    Raises CampaignError if the file cannot be written.
    """
    numerators, denominator = polynomials(model)
    more: dict[str, Any] = {"num": numerators, "den": denominator}
    with suppress(ValueError):
        poles, residues, direct = poles_and_residues(model)
        more |= {"poles": poles, "residues": residues, "direct": direct}
    inputs, outputs = (
        [input_name(c) for c in model.inputs],
        [BODY_POINTS[c] for c in model.outputs],
    )
    write_mat_of_states(state_space(model), inputs, outputs, path, more)


def write_mat_of_states(
    system: StateSpace,
    inputs: Sequence[str],
    outputs: Sequence[str],
    path: Path,
    more: Mapping[str, Any] | None = None,
) -> None:
    """Write A, B, C, D, the names of inputs and outputs, and `more` for MATLAB.

    Raises CampaignError if the file cannot be written.
    """
    from scipy.io import savemat

    states = {"A": system.a, "B": system.b, "C": system.c, "D": system.d}
    names = {"inputs": np.array(inputs, object), "outputs": np.array(outputs, object)}
    with replacing(path, CampaignError) as draft:
        savemat(draft, {**states, **names, **(more or {})}, appendmat=False)
