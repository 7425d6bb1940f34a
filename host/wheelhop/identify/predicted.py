"""The body's motion as a transfer matrix foresees it from the axles' (thesis figures 5.5 to 5.22).

What was in motion when the record began rings down with the poles of H: no axle tells of it, so its
few numbers are fitted to each record, as in every error that is stated of H (`identify/gram.py`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS
from wheelhop.compare import InBand
from wheelhop.identify.gram import projected, transient_basis, unabsorbed
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.spectra import Measured, Spectra, through

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


@dataclass(frozen=True, eq=False)
class Predicted:
    """One run: n outputs, k lines in band, spectra scaled as in `Spectra`, m/s².

    ``doubt`` is the standard deviation of the real and of the imaginary part of measured minus
    predicted: of H itself, of the noise of the axles' sensors that goes through it, and of that of
    the body's. ``held_out`` says that H was not fitted to the run.
    """

    run: str
    held_out: bool
    points: tuple[str, ...]  #: (n,) such as "B1"
    omega: Array  #: (k,) rad/s
    samples: int
    measured: ComplexArray  #: (k, n)
    predicted: ComplexArray  #: (k, n)
    doubt: Array  #: (k, n)

    @property
    def frequency_hz(self) -> Array:
        """The lines (k,)."""
        return self.omega / (2 * np.pi)

    @property
    def error(self) -> Array:
        """√(Σ|measured − predicted|² / Σ|measured|²) of each output (n,)."""
        left = np.sum(np.abs(self.measured - self.predicted) ** 2, axis=0)
        return np.asarray(np.sqrt(left / np.sum(np.abs(self.measured) ** 2, axis=0)))

    @property
    def expected(self) -> Array:
        """The error (n,) of each output that `doubt` alone would leave."""
        power = 2 * np.sum(self.doubt**2, axis=0)
        return np.asarray(np.sqrt(power / np.sum(np.abs(self.measured) ** 2, axis=0)))

    @property
    def rate_hz(self) -> float:
        """Samples per second."""
        return self._band.rate_hz

    def density(self, spectrum: ComplexArray) -> Array:
        """Power density, (m/s²)²/Hz, of a spectrum of this run."""
        return np.asarray(np.abs(spectrum) ** 2 / self.rate_hz)

    @property
    def time_s(self) -> Array:
        """Times (samples,) of the signals, 0 at the record's first sample."""
        return np.arange(self.samples) / self.rate_hz

    def signal(self, spectrum: ComplexArray) -> Array:
        """A spectrum of this run (k, n) as signals (samples, n) in band, m/s²."""
        return self._band.from_coefficients(np.concatenate([spectrum.real, spectrum.imag]))

    @cached_property
    def _band(self) -> InBand:
        frequency = self.frequency_hz
        # One line alone does not tell the rate: a record's first line is then taken for its step.
        step = frequency[1] - frequency[0] if len(frequency) > 1 else frequency[0]
        ends = (float(frequency[0]), float(frequency[-1]))
        return InBand(self.samples, float(step * self.samples), ends)


def predict(h: TransferMatrix, measured: Measured) -> list[Predicted]:
    """What H says of the body in every run of a campaign, held-out runs first."""
    return [
        *_predicted(h, measured.validate, measured.noise_rms, held_out=True),
        *_predicted(h, measured.fit, measured.noise_rms, held_out=False),
    ]


def _predicted(
    h: TransferMatrix, runs: Sequence[Spectra], noise_rms: float | None, held_out: bool
) -> Iterator[Predicted]:
    points = tuple(BODY_POINTS[corner] for corner in h.outputs)
    told = h.noise_rms * np.sqrt(h.cost / h.freedom)
    noise = told if noise_rms is None else np.full(len(points), noise_rms)
    for part in runs:
        s, k = 1j * part.omega, len(part.omega)
        response = h(s)
        rest = part.outputs - through(response, part.inputs)
        basis = transient_basis(part.omega, h.sections, np.ones(k))
        rows = projected(rest, basis).reshape(len(part.runs), 2, k, -1)
        left = rows[:, 0] + 1j * rows[:, 1]
        each = part.samples / (2 * k) * noise**2  # of a real or imaginary part of a sensor's line
        growth = 1.0 + np.sum(np.abs(response) ** 2, axis=2)
        shown = unabsorbed(part.omega, h.sections, np.ones(k))[:, None]
        variance = shown * (each * growth + h.doubt(s, part.inputs) ** 2)
        for i, name in enumerate(part.runs):
            outputs = part.outputs[i]
            yield Predicted(
                name,
                held_out,
                points,
                part.omega,
                part.samples,
                outputs,
                outputs - left[i],
                np.sqrt(variance[i]),
            )
