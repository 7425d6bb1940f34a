"""Frequency response of the linear part of a mechanism."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

from wheelhop.campaign import Averaging
from wheelhop.vehicle.assembly import System

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


def frequency_response(
    system: System, frequency_hz: ArrayLike, port_stiffness: ComplexArray | None = None
) -> ComplexArray:
    """Acceleration of every output per prescribed motion, (f, c, m), 1/s².

    H(ω) = −ω² L (K + Pᵀ Z P − ω² M + iωC)⁻¹ (B + iωD − Pᵀ Z R), with exp(+iωt). Force laws are left
    out, unless `port_stiffness` Z (f, p), N/m, says how stiff each of their ports is.
    """
    omega = 2 * np.pi * np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))[:, None, None]
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    driven = system.input_stiffness + 1j * omega * system.input_damping
    if port_stiffness is not None:
        force = system.port.T * port_stiffness[:, None, :]
        dynamic = dynamic + force @ system.port
        driven = driven - force @ system.port_input
    return np.asarray(-(omega**2) * (system.output @ np.linalg.solve(dynamic, driven)))


class ForceResponse:
    """What applied forces do to a mechanism without force laws, at rest before.

    Parameters
    ----------
    system
        The mechanism; its force laws are left out.
    n, memory
        Number of samples of the forces, and after how many more an impulse is forgotten.
    period_s
        Time between samples; forces must hold nothing above half their rate.
    averaging
        What accelerations are the means of.
    """

    def __init__(
        self, system: System, n: int, memory: int, period_s: float, averaging: Averaging
    ) -> None:
        self._n = fft.next_fast_len(n + memory, real=True)
        frequency = fft.rfftfreq(self._n, period_s)
        omega = 2 * np.pi * frequency[:, None, None]
        dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
        moved = system.output @ np.linalg.solve(dynamic, system.force.astype(complex))
        self._response = -(omega**2) * averaging.kept(frequency)[:, None, None] * moved

    def __call__(self, force: Array) -> Array:
        """Accelerations (n, c), m/s², for histories (n, k), N."""
        spectrum = fft.rfft(force, self._n, axis=0)
        moved = np.einsum("fck,fk->fc", self._response, spectrum)
        return np.asarray(fft.irfft(moved, self._n, axis=0)[: len(force)])
