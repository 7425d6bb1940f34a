"""Transfer matrices: time and held-out error beside other ways: python -m benchmarks.identify

Processor seconds on one thread. The runs are made of the thesis's own H(s) (appendix D.2) with 10 %
noise: 18 runs of 1024 samples, 8 poles, 48 numerators, and 6 runs more to judge on.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.identify import Sections, Spectra, Structure, frf_h1, identify, judge
from wheelhop.identify.sections import from_parameters
from wheelhop.identify.synthetic import thesis_matrix, thesis_runs

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
THESIS = Structure("symmetric", rigid=False)
PLACE = THESIS.elements((0, 1, 2, 3), (0, 1, 2, 3))
START = Sections(2 * np.pi * np.array([3.03, 4.93, 10.56, 26.49]), np.full(4, 0.1))
SIMPLEX = 300  # evaluations: it has not converged then, and is already slow enough to judge


def main() -> None:
    """Print the table, then how the time grows with runs."""
    fit, held = thesis_runs(0.1), thesis_runs(0.1, runs=6, seed=99)
    rows: list[tuple[str, float, float]] = []

    begin = time.process_time()
    model = identify([fit], THESIS)
    ours = time.process_time() - begin
    _add(rows, ("wheelhop identify", ours, judge(model, [held]).error))

    begin = time.process_time()
    sections, numerators = thesis_algorithm(fit)
    seconds = time.process_time() - begin
    basis = lambda s: matrix_of(sections, numerators, s)  # noqa: E731
    _add(rows, ("thesis: simplex around weighted least squares", seconds, error(basis, held)))

    begin = time.process_time()
    fitted = vector_fitting(fit)
    seconds = time.process_time() - begin
    _add(rows, ("scikit-rf: vector fitting of estimated FRFs", seconds, error(fitted, held)))
    _add(rows, ("the true matrix", 0.0, error(thesis_matrix(), held)))

    print("\nway                                              seconds   ratio   held-out error")
    for name, seconds, off in rows:
        print(f"{name:48s} {seconds:7.2f} {seconds / ours:7.1f}   {off:.5f}", flush=True)

    print("\norder 40, seconds by runs")
    for runs in (25, 50, 100):
        some = thesis_runs(0.1, runs=runs)
        begin = time.process_time()
        identify([some], THESIS, order=40)
        taken = time.process_time() - begin
        print(f"{runs:4d} runs {taken:7.1f} s {taken / runs:7.3f} s each", flush=True)


def _add(rows: list[tuple[str, float, float]], row: tuple[str, float, float]) -> None:
    rows.append(row)
    print(f"{row[0]}: {row[1]:.2f} s", flush=True)


def error(h: Callable[[ComplexArray], ComplexArray], runs: Spectra) -> float:
    """As `judge` has it, with the true poles' initial states projected out for all alike."""
    from wheelhop.identify.gram import projected, transient_basis
    from wheelhop.identify.published import TABLE_5_2
    from wheelhop.identify.spectra import through

    basis = transient_basis(runs.omega, TABLE_5_2, np.ones(len(runs.omega)))
    rest = projected(runs.outputs - through(h(1j * runs.omega), runs.inputs), basis)
    charge = len(basis) / (len(basis) - basis.shape[1])
    return float(np.sqrt(charge * np.sum(rest**2) / np.sum(np.abs(runs.outputs) ** 2)))


def thesis_algorithm(runs: Spectra) -> tuple[Sections, Array]:
    """5.6-5.10: numerators by least squares of the error times the denominator, the output error
    minimised over ζ and ω by Nelder and Mead; no initial states."""
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

    def solve(numbers: Array) -> tuple[float, Array]:
        sections = from_parameters(numbers)
        below = np.polyval(sections.denominator(), s) / 100.0**8
        right = (outputs * below[:, None]).ravel()
        c = np.linalg.lstsq(a, np.concatenate([right.real, right.imag]), rcond=None)[0]
        rest = outputs - (flat @ c).reshape(outputs.shape) / below[:, None]
        return float(np.sum(np.abs(rest) ** 2)), c

    found = optimize.minimize(
        lambda numbers: solve(numbers)[0],
        START.parameters(),
        method="Nelder-Mead",
        options={"maxfev": SIMPLEX, "xatol": 1e-4, "fatol": 1e-4},
    )
    return from_parameters(found.x), solve(found.x)[1]


def matrix_of(sections: Sections, numerators: Array, s: ComplexArray) -> ComplexArray:
    """H of `thesis_algorithm`'s coefficients."""
    powers = (s[:, None] / 100.0) ** np.arange(8)
    below = np.polyval(sections.denominator(), s) / 100.0**8
    elements = powers @ numerators.reshape(6, 8).T / below[:, None]
    return np.asarray(elements[:, PLACE])


def vector_fitting(runs: Spectra) -> Callable[[ComplexArray], ComplexArray]:
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
