"""What a user may know of a vehicle: asked on the page, and by `wheelhop new`; and of the tracks.
Loads no room."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wheelhop.vehicle.estimate import Known

Answers = Mapping[str, float | None]


@dataclass(frozen=True)
class Question:
    """A number that a user may know; what lies outside `low` … `high` is in another unit."""

    name: str
    words: str
    unit: str
    low: float
    high: float
    needed: bool = False

    @property
    def option(self) -> str:
        """As it is written on the command line."""
        return f"--{self.name.replace('_', '-')}"

    def read(self, text: str) -> float:
        """The answer as a number. Raises ValueError with a line for the user."""
        try:
            value = float(text.replace(",", "."))
        except ValueError:
            raise ValueError(f"'{text}' is not a number") from None
        if not self.low <= value <= self.high:
            raise ValueError(f"{value:g} {self.unit}: vehicles have {self.low:g} to {self.high:g}")
        return value


WEIGHT = "weight on both {} wheels, ready to drive, driver aboard"
SPRING = "{} springs: rate of one of them"
RATIO = "{} motion ratio: travel of the spring over travel of the wheel"
RIDE = "{} ride frequency: how often the body bounces a second, pushed down above that axle"
QUESTIONS = (
    *(
        Question(f"{end}_kg", WEIGHT.format(end), "kg", 5.0, 50e3, True)
        for end in ("front", "rear")
    ),
    Question("wheelbase_m", "wheelbase, from axle to axle", "m", 0.3, 15.0, True),
    Question(
        "track_width_m", "track width, from tyre's middle to tyre's middle", "m", 0.2, 5.0, True
    ),
    *(
        question
        for end in ("front", "rear")
        for question in (
            Question(f"{end}_spring_n_mm", SPRING.format(end), "N/mm", 0.2, 5000.0),
            Question(f"{end}_motion_ratio", RATIO.format(end), "", 0.1, 3.0),
            Question(f"{end}_ride_hz", RIDE.format(end), "Hz", 0.3, 10.0),
        )
    ),
    Question("wheel_radius_m", "radius of the wheels, from hub to ground", "m", 0.03, 2.0),
    Question("driver_kg", "weight of the driver", "kg", 20.0, 250.0),
)

RECORDER_WORDS = {
    "averaging_ms": "each sample is the mean over so long, ms",
    "noise_rms_m_s2": "noise of a channel at rest, engine off, rms in band, m/s²",
}
"""What a data sheet of an instrument may tell, by its key in campaign.toml."""

TRACK_WORDS = {
    "washboard": "washboard: waves across the track",
    "one-sided-washboard": "washboard under the left wheels only",
    "herringbone": "herringbone: waves at an angle",
    "chassis-twist": "chassis twist: left and right in antiphase",
    "sine-sweep": "sine sweep: waves that grow shorter",
    "half-sine-bump": "one bump, half a sine",
    "step-bump": "one bump, a step",
    "flat": "flat ground",
    "unknown": "not surveyed: a lawn, a trail",
}
FIELD_WORDS = {
    "amplitude_mm": "amplitude, mm (half of trough to crest)",
    "pitch_mm": "wavelength, mm",
    "pitch_start_mm": "wavelength at the start, mm",
    "pitch_end_mm": "wavelength at the end, mm",
    "length_mm": "length, mm",
    "height_mm": "height, mm",
    "width_mm": "width, from edge to edge, mm",
    "angle_deg": "angle, °",
    "lateral_offset_mm": "how far left of its middle you drove, mm",
}

CORNERS = ("front left", "front right", "rear left", "rear right")
PLACE_WORDS = {
    **{f"A{i}": f"A{i}: axle, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    **{f"B{i}": f"B{i}: body, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    "body": "body, place not known",
    "along:x": "body, acceleration forward",
    "along:y": "body, acceleration to the left",
    "on:driver": "driver, upwards",
    "on:engine": "engine, upwards",
    **{f"travel:{i}": f"travel of strut, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    **{f"force:{i}": f"force in strut, {corner}" for i, corner in enumerate(CORNERS, start=1)},
    "rate:pitch": "pitch rate, positive nose down",
    "rate:roll": "roll rate, positive left side up",
    "speed": "speed of travel, GPS",
    "speed:engine": "speed of the engine",
    **{
        f"speed:wheel:{i}": f"speed of wheel, {corner}" for i, corner in enumerate(CORNERS, start=1)
    },
}
"""Where a column sits, or what it measures, by the word a campaign is made of."""


def known(name: str, given: Answers) -> Known:
    """What is known of a vehicle from the answers, those that are needed among them."""
    from wheelhop.vehicle.estimate import Axle, Known

    def number(key: str) -> float:
        value = given[key]
        assert value is not None  # all that are needed are there
        return value

    def axle(end: str) -> Axle:
        spring = given[f"{end}_spring_n_mm"]
        return Axle(
            number(f"{end}_kg"),
            None if spring is None else spring * 1e3,
            given[f"{end}_motion_ratio"] or 1.0,
            given[f"{end}_ride_hz"],
        )

    return Known(
        name,
        axle("front"),
        axle("rear"),
        number("wheelbase_m"),
        number("track_width_m"),
        given["wheel_radius_m"],
        given["driver_kg"],
    )
