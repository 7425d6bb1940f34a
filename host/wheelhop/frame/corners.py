"""What a frame that bends does at its four corners: all that the car on it needs to know."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.files import read_toml
from wheelhop.frame.assemble import FiniteElements, assemble
from wheelhop.frame.error import FrameError
from wheelhop.frame.f06 import read_f06
from wheelhop.frame.model import CORNERS
from wheelhop.frame.read import read_frame, read_places
from wheelhop.frame.reduce import reduce

Array = NDArray[np.float64]
FIXED_MODES = 20
"""Fixed-interface modes of the frame's reduction."""
RIGID, RIGID_HZ = 6, 0.5
"""A frame without supports has so many modes below this."""


@dataclass(frozen=True, eq=False)
class CornerModes:
    """Elastic modes of a frame without supports: where its corners are (4, 3), m, frequencies (k,),
    Hz, and vertical motions of the corners (4, k), 1/√kg."""

    position: Array
    frequency_hz: Array
    height: Array


def corner_modes(elements: FiniteElements, fixed_modes: int = FIXED_MODES) -> CornerModes:
    """All modes of the frame's Craig–Bampton reduction without supports: together they deflect
    under constant forces at the corners exactly as the frame does."""
    reduced = reduce(elements, fixed_modes)
    frequency_hz, shape = reduced.free_modes()
    height = shape[[reduced.interface[corner] + 2 for corner in CORNERS]]
    return CornerModes(elements.position[elements.corners], frequency_hz, height)


def read_corner_modes(file: Path) -> CornerModes:
    """The modes of a frame's file: those that Nastran found, if it names their print-out, else of
    its beams.

    Raises `FrameError` as `read_frame` and `read_f06`, and for modes that are not those of a frame
    without supports.
    """
    top = read_toml(file, FrameError)
    if "f06" not in top:
        return corner_modes(assemble(read_frame(file)))
    places, kilogram = read_places(file)
    printed = file.parent / top.text("f06")
    modes = read_f06(printed, [node for node, _ in places])
    rigid = modes.frequency_hz < RIGID_HZ
    if rigid.sum() != RIGID:
        raise FrameError(
            f"{printed}: {rigid.sum()} modes lie below {RIGID_HZ} Hz, and a frame without supports"
            f" has {RIGID}: solve it without SPC, from 0 Hz on"
        )
    if rigid.all():
        raise FrameError(f"{printed}: holds no elastic mode: ask EIGRL for more")
    order = np.argsort(modes.frequency_hz[~rigid])
    height = modes.height[:, ~rigid] / np.sqrt(modes.mass[~rigid] * kilogram)
    position = np.array([place for _, place in places])
    return CornerModes(position, modes.frequency_hz[~rigid][order], height[:, order])
