"""What a linear fault of the instrument makes of a record: a transfer function, applied to it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.effects.base import Array

MARGIN_S = 0.5
"""Records are continued by this much at both ends, as what comes before and after is not known."""


def transferred(
    record: Array, rate_hz: float, transfer: Callable[[Array], NDArray[np.complex128]]
) -> Array:
    """A record (n, c) after a filter whose transfer function at frequencies (f,), Hz, is `transfer`
    (f, c) or (f, 1), with exp(+iωt).

    The filter acts in the frequency domain. Beyond its ends the record is continued by its own
    point reflection, so that it does not jump where the transform closes it to a ring.
    """
    margin = min(round(MARGIN_S * rate_hz), len(record) - 1)
    longer = np.pad(record, ((margin, margin), (0, 0)), mode="reflect", reflect_type="odd")
    n = len(longer)
    spectrum = fft.rfft(longer, axis=0) * transfer(fft.rfftfreq(n, 1.0 / rate_hz))
    return np.asarray(fft.irfft(spectrum, n, axis=0)[margin : margin + len(record)])
