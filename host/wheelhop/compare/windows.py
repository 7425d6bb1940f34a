"""Windows for spectra of records, periodic in their length; scipy.signal has them, too, but takes a
quarter of a second to import."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

BLACKMAN_HARRIS = (0.35875, -0.48829, 0.14128, -0.01168)
"""The four-term window with the lowest sidelobes (F. Harris, Proc. IEEE 66 (1978) 51, table I)."""


def hann(n: int) -> Array:
    """Hann's window (n,)."""
    return np.hanning(n + 1)[:-1]


def blackman_harris(n: int) -> Array:
    """The four-term Blackman-Harris window (n,); its main lobe is eight bins wide."""
    phase = 2.0 * np.pi * np.arange(n) / n
    return np.asarray(np.cos(np.outer(phase, np.arange(4))) @ np.array(BLACKMAN_HARRIS))
