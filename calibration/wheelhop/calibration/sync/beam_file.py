"""`beam.toml`: the cantilever of a synchronicity check, its drive, and what sits where."""

from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.sync.beam import Beam
from wheelhop.files import Table, read_toml

SLENDER = 10.0  # length over height from which shear and rotary inertia do not matter


@dataclass(frozen=True)
class BeamSession:
    """A cantilever that carries sensors and is driven by a harmonic force.

    `beam` has the sensors' masses and what hangs at the drive on it; `channels` and `positions_m`
    belong together. `loss_factor` is what the damping is believed to be, `force_N` the amplitude of
    the force where it acts on the beam, 0: not known.
    """

    beam: Beam
    loss_factor: float
    drive_m: float
    frequencies_hz: tuple[float, ...]
    channels: tuple[str, ...]
    positions_m: tuple[float, ...]
    force_N: float = 0.0

    def shape(
        self, frequencies_hz: NDArray[np.float64], loss_factor: float
    ) -> NDArray[np.complex128]:
        """Acceleration of the sensors per force, (n_frequencies, n_sensors), m/s² per N."""
        omega = 2 * np.pi * frequencies_hz[:, None]
        return -(omega**2) * self.beam.receptance(
            frequencies_hz, self.drive_m, self.positions_m, loss_factor
        )


def read_beam(path: Path) -> BeamSession:
    """Read `beam.toml` (docs/synchronicity.md has its keys).

    Raises CalibrationError that names file, table and key, and what to do.
    """
    top = read_toml(path, CalibrationError)
    top.only(("format", "beam", "drive", "sensor"))
    top.format()
    table = top.table_if_any("beam")
    bare = _bare(table)
    drive = top.table_if_any("drive")
    drive.only(("position_mm", "frequencies_hz", "mass_g", "stiffness_N_m", "force_N"))
    drive_m = _position(drive, bare.length_m, default_mm=bare.length_m * 1e3)
    beam = bare.carrying(
        drive_m,
        drive.number("mass_g", 0.0, at_least=0.0) * 1e-3,
        drive.number("stiffness_N_m", 0.0, at_least=0.0),
    )
    channels, positions = [], []
    for sensor in top.tables("sensor", "channel"):
        sensor.only(("channel", "position_mm", "mass_g"))
        channels.append(sensor.text("channel"))
        positions.append(_position(sensor, bare.length_m))
        beam = beam.carrying(positions[-1], sensor.number("mass_g", at_least=0.0) * 1e-3)
    if len(channels) < 2:
        raise top.error("one [[sensor]] alone is in step with itself: give two or more")
    if len(set(channels)) < len(channels):
        twice = next(name for name in channels if channels.count(name) > 1)
        raise top.error(f"[[sensor]] {twice!r}: this channel is there twice, name each once")
    return BeamSession(
        beam,
        table.number("loss_factor", 0.01, at_least=0.0),
        drive_m,
        _frequencies(drive),
        tuple(channels),
        tuple(positions),
        drive.number("force_N", 0.0, at_least=0.0),
    )


def _bare(table: Table) -> Beam:
    keys = ("length_mm", "width_mm", "height_mm", "youngs_modulus_GPa", "density_kg_m3")
    table.only((*keys, "loss_factor"))
    length, width, height, modulus, density = (table.number(key, above=0.0) for key in keys)
    if length < SLENDER * height:
        raise table.error(
            f"height_mm = {height:g} (along which it bends) is not small against length_mm ="
            f" {length:g}: this theory needs a slender beam"
        )
    return Beam.rectangular(length * 1e-3, width * 1e-3, height * 1e-3, modulus * 1e9, density)


def _position(table: Table, length_m: float, default_mm: float | None = None) -> float:
    position = table.number("position_mm", default_mm, above=0.0) * 1e-3
    if position > length_m * (1 + 1e-9):
        raise table.error(
            f"position_mm = {position * 1e3:g} is beyond the free end, {length_m * 1e3:g}:"
            " it is measured from the clamp"
        )
    return min(position, length_m)


def _frequencies(drive: Table) -> tuple[float, ...]:
    values = drive.values.get("frequencies_hz")
    good = (
        isinstance(values, list)
        and values
        and all(
            isinstance(value, int | float) and not isinstance(value, bool) and 0 < value < 1e4
            for value in values
        )
    )
    if not good or not isinstance(values, list):
        raise drive.error("frequencies_hz must be a list of what drove the beam: [15.0, 32.0]")
    ordered = tuple(sorted(float(value) for value in values))
    if any(b - a < 0.02 * b for a, b in pairwise(ordered)):
        raise CalibrationError(
            f"{drive.file}: [drive]: frequencies_hz: two are nearer than 2 %: leave one out"
        )
    return ordered
