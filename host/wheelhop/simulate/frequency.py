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
    """What every output shows per prescribed motion, (f, c, m): accelerations in 1/s².

    H(ω) = −ω² L (K + Pᵀ Z P − ω² M + iωC)⁻¹ (B + iωD − Pᵀ Z R), with exp(+iωt), and for readings
    what `System.reading` makes of the same motion. Force laws are left out, unless
    `port_stiffness` Z (f, p), N/m, says how stiff each of their ports is.
    """
    omega = 2 * np.pi * np.atleast_1d(np.asarray(frequency_hz, dtype=np.float64))[:, None, None]
    dynamic = system.stiffness - omega**2 * system.mass + 1j * omega * system.damping
    driven = system.input_stiffness + 1j * omega * system.input_damping
    if port_stiffness is not None:
        pushed = system.port if system.port_force is None else system.port_force
        force = pushed.T * port_stiffness[:, None, :]
        dynamic = dynamic + force @ system.port
        driven = driven - force @ system.port_input
    moved = np.asarray(np.linalg.solve(dynamic, driven), np.complex128)
    shown = np.asarray(-(omega**2) * (system.output @ moved), np.complex128)
    imposed = np.eye(driven.shape[-1])
    return _with_readings(shown, system, omega, moved, imposed, port_stiffness)


def _with_readings(
    shown: ComplexArray,
    system: System,
    omega: Array,
    moved: ComplexArray,
    imposed: Array,
    port_stiffness: ComplexArray | None = None,
) -> ComplexArray:
    """What outputs show (f, c, k), those filled in that are readings; `moved` (f, n, k) are the
    free coordinates, `imposed` (m, k) the prescribed ones."""
    if not system.reads:
        return shown
    n, m = system.input_stiffness.shape
    x, v, u, u_rate, law = np.split(system.reading, np.cumsum([n, n, m, m]), axis=1)
    read = (x + 1j * omega * v) @ moved + (u + 1j * omega * u_rate) @ imposed
    if port_stiffness is not None:
        extension = system.port @ moved + system.port_input @ imposed
        read = read + (law * port_stiffness[:, None, :]) @ extension
    shown[:, system.reads] = read
    return shown


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
        moved: ComplexArray = np.linalg.solve(dynamic, system.force.astype(complex))
        kept = averaging.kept(frequency)[:, None, None]
        accelerated = -(omega**2) * kept * (system.output @ moved)
        still = np.zeros((system.input_stiffness.shape[1], system.force.shape[1]))
        self._response = _with_readings(accelerated, system, omega, kept * moved, still)

    def __call__(self, force: Array) -> Array:
        """What the outputs show (n, c) for histories (n, k), N."""
        spectrum = fft.rfft(force, self._n, axis=0)
        moved = np.einsum("fck,fk->fc", self._response, spectrum)
        return np.asarray(fft.irfft(moved, self._n, axis=0)[: len(force)])
