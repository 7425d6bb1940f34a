"""Table 3.2 of the source: two models of eight specimens, forces in N and displacements in mm."""

import numpy as np

from wheelhop.material import LogarithmicPolynomial, ModifiedPowerLaw, ModulusData

N_mm = 1e3  # N/m
# Bushing, specimen, highest frequency (Table 3.1), A0, beta, M0, and A0, A1, A2 of the polynomial.
ROWS = (
    (1, 1, 30, (529.720, 0.056, 485.635), (1019.674, 26.861, 2.625)),
    (1, 2, 30, (649.802, 0.048, 355.167), (1002.370, 28.931, 2.304)),
    (2, 1, 30, (855.702, 0.090, 44.132), (904.701, 59.552, 13.658)),
    (2, 2, 30, (894.934, 0.089, -54.369), (839.987, 61.474, 14.078)),
    (3, 1, 25, (517.930, 0.060, -109.340), (413.357, 26.932, 3.069)),
    (3, 2, 25, (365.390, 0.078, 23.210), (389.852, 24.116, 4.086)),
    (4, 1, 50, (441.464, 0.060, 132.586), (576.690, 23.094, 2.758)),
    (4, 2, 50, (433.754, 0.050, 185.934), (620.944, 20.043, 1.770)),
)
POWER = [np.array([a * N_mm, beta, m * N_mm]) for *_, (a, beta, m), _ in ROWS]
POLYNOMIAL = [N_mm * np.array(row[-1]) for row in ROWS]
FREQUENCY = np.arange(1.0, 31.0)


def power_law(i, omega):
    return ModifiedPowerLaw().modulus(omega, POWER[i])


def polynomial(i, omega):
    return LogarithmicPolynomial().modulus(omega, POLYNOMIAL[i])


def data_of(modulus, frequency_hz=FREQUENCY, noise=0.0, seed=0, name="specimen"):
    """What a rig would report of a modulus, each part with its own relative noise."""
    exact = modulus(2 * np.pi * frequency_hz)
    draw = np.random.default_rng(seed).normal(0.0, noise, (2, len(frequency_hz)))
    measured = exact.real * (1 + draw[0]) + 1j * exact.imag * (1 + draw[1])
    return ModulusData(name, frequency_hz, measured, np.full(len(frequency_hz), np.nan))
