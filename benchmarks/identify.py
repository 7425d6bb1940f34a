"""Transfer matrices: time and held-out error beside other ways: python -m benchmarks.identify

Processor seconds on one thread, from records in memory; of five times the least. The runs are made
of the thesis's own H(s) (appendix D.2) with 10 % noise: 18 runs of 1024 samples, 8 poles, 48
numerators, and 6 runs more to judge on.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.identify import (
    Sections,
    Spectra,
    StateSpace,
    Structure,
    TransferMatrix,
    frf_h1,
    identify,
    judge,
    of_fractions,
    spectra,
)
from wheelhop.identify.published import TABLE_5_2
from wheelhop.identify.sections import from_parameters
from wheelhop.identify.synthetic import BAND_HZ, RATE_HZ, records, thesis_matrix, thesis_runs

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
THESIS = Structure("symmetric", rigid=False)
PLACE = THESIS.elements((0, 1, 2, 3), (0, 1, 2, 3))
START = Sections(2 * np.pi * np.array([3.03, 4.93, 10.56, 26.49]), np.full(4, 0.1))
SIMPLEX = 200 * 8  # evaluations fminsearch allows eight numbers; its tolerances are 1e-4
TIMES = 5
RECORDS = (  # runs, samples, Hz, band
    (18, 1024, 100.0, (0.5, 30.0)),
    (18, 1024, 100.0, (0.5, 45.0)),
    (18, 1024, 200.0, (0.5, 90.0)),
    (18, 4096, 200.0, (0.5, 90.0)),
    (18, 16384, 200.0, (0.5, 90.0)),
)

Matrix = Callable[[ComplexArray], ComplexArray]


def main() -> None:
    """Print the table, then how the time grows with runs."""
    recorded = records(thesis_matrix(), 0.1)
    held = thesis_runs(0.1, runs=6, seed=99)
    fit, cold = _timed(lambda: spectra(*recorded, RATE_HZ, BAND_HZ), TIMES)
    model, ours = _timed(lambda: identify([fit], THESIS), TIMES)
    ways: list[tuple[str, float, float]] = [
        ("wheelhop identify", cold + ours, judge(model, [held]).error)
    ]
    for name, way, times in (
        ("thesis: simplex around weighted least squares", thesis_algorithm, 1),
        ("  the same, its regressors factored once", lambda f: thesis_algorithm(f, once=True), 1),
        ("scikit-rf: vector fitting of estimated FRFs", vector_fitting, TIMES),
    ):
        found, seconds = _timed(partial(way, fit), times)
        ways.append((name, cold + seconds, error(found, held)))
    ways.append(("the true matrix", 0.0, error(thesis_matrix(), held)))
    print("way                                              seconds   ratio   held-out error")
    for name, seconds, off in ways:
        print(f"{name:48s} {seconds:7.3f} {seconds / ways[0][1]:7.1f}   {off:.5f}", flush=True)

    print(
        "\npoles at 10 % noise by record: worst of the three lower modes, and the mode at 27.46 Hz"
    )
    for runs, samples, rate, band in RECORDS:
        made = records(thesis_matrix(), 0.1, runs=runs, samples=samples, rate_hz=rate)
        model = identify([spectra(*made, rate, band)], THESIS)
        print(
            f"{runs:3d} x {samples:5d} at {rate:3.0f} Hz, {band[0]:g}-{band[1]:g} Hz: {_off(model)}"
        )

    print("\norder 40, of a matrix that has 20 modes; least of three")
    truth = many_modes()
    for runs in (12, 25, 50, 100):
        some = spectra(*records(truth, 0.1, runs=runs), RATE_HZ, BAND_HZ)
        wide, seconds = _timed(partial(identify, [some], THESIS, order=40), 3)
        left = judge(wide, [some]).error
        print(f"{runs:4d} runs {seconds:6.2f} s {seconds / runs:6.3f} s each, error {left:.4f}")


def _off(model: TransferMatrix) -> str:
    """By how much poles are off, and the standard errors of the fourth."""
    rows = sorted(model.poles_table())
    truth = list(zip(TABLE_5_2.frequency_hz, TABLE_5_2.zeta, strict=True))
    off = np.array(
        [(f / a - 1, z / b - 1) for (f, _, z, _), (a, b) in zip(rows, truth, strict=True)]
    )
    f, df, z, dz = rows[3]
    return (
        f"{np.abs(off[:3]).max():6.2%}; {off[3, 0]:+6.1%} Hz (s.e. {df / f:.1%}),"
        f" {off[3, 1]:+6.1%} ζ (s.e. {dz / z:.1%})"
    )


def _timed(call: Callable[[], Any], times: int) -> tuple[Any, float]:
    """What a call returns, and the least processor time of several."""
    taken = []
    for _ in range(times):
        begin = time.process_time()
        result = call()
        taken.append(time.process_time() - begin)
    return result, min(taken)


def many_modes() -> StateSpace:
    """A symmetric matrix of 20 lightly damped modes within the band."""
    rng = np.random.default_rng(7)
    sections = Sections(2 * np.pi * np.linspace(1.0, 28.0, 20), rng.uniform(0.02, 0.06, 20))
    elements = 0.1 * rng.standard_normal((6, 40))
    return of_fractions(sections, elements[PLACE])


def error(h: Matrix, runs: Spectra) -> float:
    """As `judge` has it, with the true poles' initial states projected out for all alike."""
    from wheelhop.identify.gram import projected, transient_basis
    from wheelhop.identify.spectra import through

    basis = transient_basis(runs.omega, TABLE_5_2, np.ones(len(runs.omega)))
    s: ComplexArray = np.multiply(1j, runs.omega)
    missed: ComplexArray = np.subtract(runs.outputs, through(h(s), runs.inputs))
    rest = projected(missed, basis)
    charge = len(basis) / (len(basis) - basis.shape[1])
    return float(np.sqrt(charge * np.sum(rest**2) / np.sum(np.abs(runs.outputs) ** 2)))


def thesis_algorithm(runs: Spectra, *, once: bool = False) -> Matrix:
    """5.6-5.10: numerators by least squares of the error times the denominator, the output error
    minimised over ζ and ω by Nelder and Mead; no initial states. The regressors do not depend on
    the poles: `once` spares their factorisation at each trial, which the thesis does not."""
    s = 1j * runs.omega
    powers = (s[:, None] / 100.0) ** np.arange(8)
    outputs = runs.outputs
    regressors = np.zeros((*outputs.shape, 48), complex)
    for i in range(4):
        for j in range(4):
            columns = slice(8 * PLACE[i, j], 8 * PLACE[i, j] + 8)
            regressors[:, :, i, columns] += runs.inputs[:, :, j, None] * powers
    flat = regressors.reshape(-1, 48)
    a = np.vstack([flat.real, flat.imag])
    inverse = np.linalg.pinv(a) if once else None

    def solve(numbers: Array) -> tuple[float, Array]:
        sections = from_parameters(numbers)
        below = np.polyval(sections.denominator(), s) / 100.0**8
        weighted = (outputs * below[:, None]).ravel()
        right = np.concatenate([weighted.real, weighted.imag])
        c = np.linalg.lstsq(a, right, rcond=None)[0] if inverse is None else inverse @ right
        rest = outputs - (flat @ c).reshape(outputs.shape) / below[:, None]
        return float(np.sum(np.abs(rest) ** 2)), c

    found = optimize.minimize(
        lambda numbers: solve(numbers)[0],
        START.parameters(),
        method="Nelder-Mead",
        options={"maxfev": SIMPLEX, "xatol": 1e-4, "fatol": 1e-4},
    )
    sections, numerators = from_parameters(found.x), solve(found.x)[1]

    def matrix(s: ComplexArray) -> ComplexArray:
        over = (s[:, None] / 100.0) ** np.arange(8) @ numerators.reshape(6, 8).T
        below = np.polyval(sections.denominator(), s) / 100.0**8
        return np.asarray((over / below[:, None])[:, PLACE])

    return matrix


def vector_fitting(runs: Spectra) -> Matrix:
    """scikit-rf on the H1 estimate, 4 complex pairs for all 16 elements."""
    import skrf
    from skrf.vectorFitting import VectorFitting

    h = frf_h1([runs]).matrix
    frequency = runs.omega / (2 * np.pi)
    fitting = VectorFitting(skrf.Network(f=frequency, s=h, z0=50, f_unit="Hz"))
    fitting.vector_fit(n_poles_real=0, n_poles_cmplx=4, fit_constant=False)

    def response(s: ComplexArray) -> ComplexArray:
        out = np.empty((len(s), 4, 4), complex)
        for i in range(4):
            for j in range(4):
                out[:, i, j] = fitting.get_model_response(i, j, s.imag / (2 * np.pi))
        return out

    return response


if __name__ == "__main__":
    main()
