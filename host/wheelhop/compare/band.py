"""The in-band signal: what every error figure of wheelhop is computed from.

A record is projected onto the Fourier bins of its own length that lie inside the
campaign's band. An orthogonal projection, unlike a recursive filter, has no
start-up transient, leaves white noise white, and gives the same sum of squares in
time and in frequency (Parseval's theorem), so residuals may be formed, weighted and
summed on either side.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import fft

Array = NDArray[np.float64]


class InBand:
    """Projection of records of ``n`` samples onto a frequency band.

    Parameters
    ----------
    n : samples per record.
    rate_hz : sample rate.
    band_hz : (low, high), both ends belong to the band. The bins at zero and at half
        the sample rate never do: a constant offset is not a vibration, and the latter
        bin has no phase.

    Attributes
    ----------
    frequency_hz : (n_bins,) frequencies kept.
    count : 2 n_bins, the degrees of freedom of one channel in band.

    Raises
    ------
    ValueError : no bin lies in the band (the record is too short for it).
    """

    def __init__(self, n: int, rate_hz: float, band_hz: tuple[float, float]) -> None:
        low, high = band_hz
        step = rate_hz / n
        # An edge that falls on a bin up to rounding belongs to the band.
        first = max(1, int(np.ceil(low / step - 1e-9)))
        last = min((n - 1) // 2, int(np.floor(high / step + 1e-9)))
        if last < first:
            raise ValueError(
                f"a record of {n} samples at {rate_hz:g} Hz resolves nothing"
                f" between {low:g} and {high:g} Hz"
            )
        self.n = n
        self.rate_hz = rate_hz
        self.frequency_hz: Array = np.arange(first, last + 1, dtype=float) * step
        self.count = 2 * (last + 1 - first)
        self._bins = slice(first, last + 1)

    def coefficients(self, y: ArrayLike) -> Array:
        """Coordinates of ``y`` (n, …) in the band's orthonormal basis, (2 n_bins, …).

        The first n_bins rows are the cosine parts, sqrt(2/n) Re of the discrete Fourier
        transform, the others the sine parts, sqrt(2/n) Im (sign of exp(-iωt)). Sums of
        products over the rows equal those of the band-passed signals over time.
        """
        spectrum = fft.rfft(self._checked(y), axis=0)[self._bins]
        half = len(spectrum)
        out = np.empty((2 * half, *spectrum.shape[1:]))
        scale = np.sqrt(2.0 / self.n)
        np.multiply(spectrum.real, scale, out=out[:half])
        np.multiply(spectrum.imag, scale, out=out[half:])
        return out

    def signal(self, y: ArrayLike) -> Array:
        """Band-pass ``y`` (n, …): the part of it that lies in band, same shape."""
        spectrum = fft.rfft(self._checked(y), axis=0)
        spectrum[: self._bins.start] = 0.0
        spectrum[self._bins.stop :] = 0.0
        return np.asarray(fft.irfft(spectrum, self.n, axis=0))

    def from_coefficients(self, c: ArrayLike) -> Array:
        """Band-passed signal (n, …) whose :meth:`coefficients` are ``c`` (2 n_bins, …)."""
        c = np.asarray(c, dtype=float)
        half = self.count // 2
        spectrum = np.zeros((self.n // 2 + 1, *c.shape[1:]), dtype=complex)
        spectrum[self._bins] = np.sqrt(self.n / 2.0) * (c[:half] + 1j * c[half:])
        return np.asarray(fft.irfft(spectrum, self.n, axis=0))

    def integrated_twice(self, c: ArrayLike) -> Array:
        """Coefficients (2 n_bins, …) of what has ``c`` as its second derivative in time: of the
        motion in band, m, if ``c`` is of an acceleration, m/s²."""
        c = np.asarray(c, dtype=float)
        omega = 2.0 * np.pi * np.tile(self.frequency_hz, 2)
        return np.asarray(-c / (omega**2).reshape(-1, *[1] * (c.ndim - 1)))

    def differentiated(self, c: ArrayLike) -> Array:
        """Coefficients (2 n_bins, …) of the derivative in time of what has the coefficients ``c``:
        of a velocity, m/s, if ``c`` is of a displacement, m."""
        c = np.asarray(c, dtype=float)
        half = self.count // 2
        omega = (2.0 * np.pi * self.frequency_hz).reshape(-1, *[1] * (c.ndim - 1))
        return np.concatenate([-omega * c[half:], omega * c[:half]])

    def _checked(self, y: ArrayLike) -> Array:
        y = np.asarray(y, dtype=float)
        if y.shape[:1] != (self.n,):
            raise ValueError(f"expected {self.n} samples along the first axis, got {y.shape}")
        return y
