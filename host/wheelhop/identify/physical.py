"""Transfer matrices of physical models, at the places of identified ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import BODY_POINTS, Channel
from wheelhop.identify.matrix import TransferMatrix
from wheelhop.identify.structure import VERTICAL
from wheelhop.simulate import Model, frequency_response

Array = NDArray[np.floating[Any]]
ComplexArray = NDArray[np.complex128]


def physical_matrix(
    channels: Sequence[Channel], physical: Model, model: TransferMatrix, frequency_hz: Array
) -> ComplexArray:
    """H of a physical model at the places of an identified one (f, n, m), NaN for axles that move
    fore and aft, which it has not. Its force laws, which are not linear, are left out."""
    wanted = {BODY_POINTS[corner]: row for row, corner in enumerate(model.outputs)}
    places = sorted((c for c in channels if c.point in wanted), key=lambda c: wanted[c.point])
    system = physical.system(places, "axles")
    omega = 2 * np.pi * frequency_hz[:, None, None]
    response = frequency_response(system, frequency_hz) / -(omega**2)
    found = np.full((*response.shape[:2], len(model.inputs)), np.nan, complex)
    for j, corner in enumerate(model.inputs):
        if corner < VERTICAL:
            found[:, :, j] = response[:, :, corner]
    return found
