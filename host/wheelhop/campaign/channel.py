"""A channel: what one column of the recordings is."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from wheelhop.campaign.low_pass import LowPass
from wheelhop.files import dotted

if TYPE_CHECKING:
    from wheelhop.campaign.rocker import Rocker

AXLE_POINTS = ("A1", "A2", "A3", "A4")
BODY_POINTS = ("B1", "B2", "B3", "B4")
STRUT_POINTS = ("S1", "S2", "S3", "S4")
ABOARD = ("driver", "engine", "battery", "payload")
"""What vehicle.toml may put on a mount of its own, each a table there."""
ACCELERATION = "acceleration"
ROTATION = "rad/s"
"""Of an engine's speed, or a wheel's."""


@dataclass(frozen=True)
class Channel:
    """One measured signal: what of a vehicle (`wheelhop.campaign.channels`), or of a rig.

    `point` is "A1".."A4" (wheel axles), "B1".."B4" (suspension-to-body points), "body-xy" (on the
    sprung body at `x_m` ahead and `y_m` to the left of its centre of mass) or "body" (on the
    sprung body, position unknown), or what it sits on of `ABOARD`, for a vertical acceleration,
    "S1".."S4" (struts) for travel or force, "pitch" or "roll" for a rate, or "rig". 1 front left,
    2 front right, 3 rear left, 4 rear right. A channel of a strut shows `per_wheel` times what the
    strut does at the wheel. An acceleration along another `axis` than z, up, is known alone: x
    forward, y to the left.

    `noise_rms` is the noise in band that is stated of this channel or its quantity, in `unit`,
    None where the campaign's holds, or none is stated. `noise_scale` is its noise over the
    campaign's: records are compared per that, so that every channel counts in units of its noise
    (`wheelhop.compare.weights`).

    `scale_uncertainty` is the standard uncertainty of what the channel shows, relative, as its
    calibration states it, `gain_uncertainty` the gain's share in it; `corner_hz` that of the
    sensor's low-pass, which was undone, `corner_uncertainty` how well it is known, relative. 0 if
    nothing is stated.

    Behind a `rocker` a channel of travel showed a curve over the wheel's travel; records are as if
    it were a line, of the ratio at ride height, `per_wheel`.

    `low_pass` is the filter that it passed, None: that of all channels, if the campaign states one.

    A speed in rad/s is that of the `point` "engine", or of the wheel of an axle's point, which
    rolls on `radius_m` (0: not stated). `mean` is that of a speed over all runs.
    """

    name: str
    point: str
    x_m: float | None = None
    y_m: float | None = None
    quantity: str = "acceleration"
    unit: str = "m/s²"
    per_wheel: float = 1.0
    noise_rms: float | None = None
    noise_scale: float = 1.0
    scale_uncertainty: float = 0.0
    gain_uncertainty: float = 0.0
    corner_hz: float = 0.0
    corner_uncertainty: float = 0.0
    axis: str = "z"
    radius_m: float = 0.0
    low_pass: LowPass | None = None
    rocker: Rocker | None = None
    mean: float = 0.0

    @property
    def corner(self) -> int | None:
        """0..3 for the points 1..4 of axle, body or strut, None for any other place."""
        named = self.point in (*AXLE_POINTS, *BODY_POINTS, *STRUT_POINTS)
        return int(self.point[1]) - 1 if named else None

    @property
    def key(self) -> str:
        """What the names of its numbers in a model begin with, before another dot:
        "channel.imu"."""
        return f"channel.{dotted(self.name)}"

    @property
    def is_axle(self) -> bool:
        """Whether it is an acceleration of a wheel axle."""
        return self.point in AXLE_POINTS and self.is_acceleration

    @property
    def is_body_point(self) -> bool:
        """Whether it is an acceleration of a suspension-to-body point."""
        return self.point in BODY_POINTS

    @property
    def is_on_body(self) -> bool:
        """Whether it shows how the sprung body moves, whatever its struts do."""
        return self.quantity == "rate" or (self.is_acceleration and not self.is_axle)

    @property
    def is_turning(self) -> bool:
        """Whether it is the speed of an engine or a wheel."""
        return self.quantity == "speed" and self.unit == ROTATION

    @property
    def is_acceleration(self) -> bool:
        """Whether it is a vertical acceleration, wherever it is measured."""
        return self.quantity == ACCELERATION
