"""From the points to the motions of the vehicle: what moves, rather than which sensor."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Channel

Array = NDArray[np.float64]

BODY_MOTIONS = ("heave", "pitch", "roll", "warp")
AXLE_MOTIONS = ("front hop", "front tramp", "rear hop", "rear tramp")
MOTIONS = BODY_MOTIONS + AXLE_MOTIONS

# Columns of an orthonormal basis of four points (front left, front right, rear left, rear
# right): a sum of squares over the points is one over the motions.
_BODY = 0.5 * np.array(
    [  # heave up, pitch nose down, roll left side up, warp
        [1, -1, 1, 1],
        [1, -1, -1, -1],
        [1, 1, 1, -1],
        [1, 1, -1, 1],
    ]
)
_AXLE = np.sqrt(0.5) * np.array([[1, 1], [1, -1]])  # hop: both sides alike; tramp: in antiphase


def motion_matrix(channels: Sequence[Channel], predicted: NDArray[np.bool_]) -> Array:
    """Matrix (8, n_channels) that takes the channels to the motions named in `MOTIONS`.

    With all eight points it is orthonormal. With body points missing, the body is taken as
    rigid and a motion is given if the points left determine it: three give heave, pitch and
    roll, two abreast give roll. Hop and tramp of an axle need both its ends. Rows
    of motions that are not determined are NaN. Channels at other places, or of other quantities,
    take no part.
    """
    matrix = np.full((len(MOTIONS), len(channels)), np.nan)
    body, axles = (
        {
            channel.corner: i
            for i, channel in enumerate(channels)
            if predicted[i]
            and channel.corner is not None
            and (channel.is_axle if is_axle else channel.is_body_point)
        }
        for is_axle in (False, True)
    )
    rigid = _BODY if len(body) == 4 else _BODY[:, :3]
    if body:
        inverse = np.linalg.pinv(rigid[list(body)])
        determined = np.isclose(np.diag(inverse @ rigid[list(body)]), 1.0)
        for motion in np.flatnonzero(determined):
            matrix[motion] = 0.0
            matrix[motion, list(body.values())] = inverse[motion]
    for axle, ends in enumerate(((0, 1), (2, 3))):
        if all(corner in axles for corner in ends):
            rows = slice(4 + 2 * axle, 6 + 2 * axle)
            matrix[rows] = 0.0
            matrix[rows, [axles[corner] for corner in ends]] = _AXLE
    return matrix
