"""What may be varied, and how far: shares, bounds, springs and dampers that can be bought."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isclose, isfinite
from pathlib import Path

import numpy as np

from wheelhop.campaign import CampaignError
from wheelhop.campaign.curves import read_curve
from wheelhop.files import did_you_mean
from wheelhop.predict.drives import Word
from wheelhop.predict.known_car import KnownCar
from wheelhop.tune.damper_curve import Clicks, DamperCurve, click_key, read_clicks
from wheelhop.vehicle import axles, changed

OPTION = Path("--vary")
SHORT = {
    "{}.stiffness": "suspension.{}.stiffness_N_m",
    "{}.damping": "suspension.{}.damping_N_s_m",
    "{}.friction": "dry-friction.{}_N",
    "{}.tyre_stiffness": "wheel.{}.tyre_stiffness_N_m",
    "{}.unsprung_mass": "wheel.{}.unsprung_mass_kg",
}
"""What people call numbers, by axle; any number may be given by its full name."""
SPRINGS, DAMPER = "springs", "damper"
SPRING = {"stiffness": {"N_mm": 1e3, "N_m": 1.0}}
EXAMPLE = "write NAME=±50%, NAME=-20%:+50%, NAME=LOW:HIGH, or NAME=FILE.csv"
SHARE = re.compile(r"([+-]?\d+(?:\.\d*)?)%")


@dataclass(frozen=True)
class Variable:
    """A number of the car that may be set: `name` as the user calls it, `key` among the model's
    numbers, between `low` and `high` or one of `choices`; `now` is what it is, SI."""

    name: str
    key: str
    low: float
    high: float
    now: float
    choices: tuple[float, ...] = ()

    def at(self, share: float) -> float:
        """The value at a share, 0 … 1, of the way; of choices the one there."""
        if self.choices:
            return self.choices[min(int(share * len(self.choices)), len(self.choices) - 1)]
        return self.low + share * (self.high - self.low)

    def share_of(self, value: float) -> float:
        """Where a value lies, 0 … 1; of choices the middle of the nearest."""
        if self.choices:
            nearest = int(np.argmin(np.abs(np.array(self.choices) - value)))
            return (nearest + 0.5) / len(self.choices)
        return min(max((value - self.low) / (self.high - self.low), 0.0), 1.0)

    @property
    def is_damper(self) -> bool:
        """Whether it sets a damper."""
        return "damp" in self.key


@dataclass(frozen=True, eq=False)
class Freedom:
    """All that may be set: the variables, and the curves of dampers among them."""

    variables: tuple[Variable, ...]
    curves: DamperCurve | None

    def changes(self, shares: Sequence[float]) -> dict[str, float]:
        """Values by key of a setting whose variables lie at these shares."""
        return {v.key: v.at(float(share)) for v, share in zip(self.variables, shares, strict=True)}

    @property
    def holds_now(self) -> bool:
        """Whether the present setting is one of those there are."""
        return all(isclose(v.at(v.share_of(v.now)), v.now) for v in self.variables)

    @property
    def now(self) -> list[float]:
        """The shares of the present setting, or of the one nearest to it."""
        return [v.share_of(v.now) for v in self.variables]


def read_freedom(texts: Sequence[str], car: KnownCar) -> Freedom:
    """What `--vary` says, for a car. Raises CampaignError for a number that the car does not have
    or that is given twice, and bounds outside of what it can be."""
    if not texts:
        raise CampaignError(f"{OPTION}: say what may be varied: {EXAMPLE}")
    found, curves = list[Variable](), dict[str, Clicks]()
    for text in texts:
        name, equals, far = text.partition("=")
        if not (name and equals and far):
            raise CampaignError(f"{OPTION} {text}: {EXAMPLE}")
        end, _, part = name.partition(".")
        if part == DAMPER and end in axles(car.vehicle.values):
            options = _options(far, text, ("now", "ratio"))
            if "now" not in options:
                raise CampaignError(f"{OPTION} {text}: say the click it is at: :now=8")
            ratio = _ratio(options, text)
            clicks = read_clicks(Path(far.split(":")[0]), options["now"], ratio)
            curves[end] = clicks
            key = f"{DamperCurve.id}.{click_key(end)}"
            low, high = min(clicks.clicks), max(clicks.clicks)
            found.append(Variable(name, key, low, high, clicks.now, clicks.clicks))
        else:
            found.append(_variable(name, far, text, car))
    keys = [variable.key for variable in found]
    for name, key in zip((v.name for v in found), keys, strict=True):
        if keys.count(key) > 1:
            raise CampaignError(f"{OPTION} {name}: is varied twice")
    return Freedom(tuple(found), DamperCurve(curves) if curves else None)


def _variable(name: str, far: str, text: str, car: KnownCar) -> Variable:
    values = car.values
    short = {
        pattern.format(end): key.format(end)
        for end in axles(car.vehicle.values)
        for pattern, key in SHORT.items()
    }
    springs = {f"{end}.{SPRINGS}": short[f"{end}.stiffness"] for end in axles(car.vehicle.values)}
    key = (short | springs).get(name, name)
    if key not in values:
        known = [*springs, *(n for n, k in short.items() if k in values), *values]
        near = did_you_mean(name, known) or "; docs/tune.md says what may be varied"
        raise CampaignError(f"{OPTION} {text}: the car has no {name}{near}")
    now = values[key]
    if name in springs or far.split(":")[0].lower().endswith(".csv"):
        ratio = _ratio(_options(far, text, ("ratio",)), text)
        rates = read_curve(Path(far.split(":")[0]), SPRING, 2)["stiffness"]
        choices = tuple(np.unique(ratio**2 * rates).tolist())
        found = Variable(name, key, choices[0], choices[-1], now, choices)
    else:
        low, high = _bounds(far, now, text)
        found = Variable(name, key, low, high, now)
    _check(found, text, car)
    return found


def _bounds(far: str, now: float, text: str) -> tuple[float, float]:
    """What a range says: ±50%, -20%:+50%, or two values."""
    plain = far.replace("+-", "±")
    words = [f"-{plain[1:]}", f"+{plain[1:]}"] if plain.startswith("±") else plain.split(":")
    matches = [SHARE.fullmatch(word) for word in words]
    if len(words) == 2 and all(matches):
        if now == 0.0:
            raise CampaignError(f"{OPTION} {text}: it is 0 now: give LOW:HIGH in SI")
        parts = [now * (1.0 + float(match[1]) / 100) for match in matches if match]
    else:
        try:
            parts = [float(word) for word in words]
        except ValueError:
            parts = []
    if len(parts) != 2 or not all(map(isfinite, parts)) or parts[0] == parts[1]:
        raise CampaignError(f"{OPTION} {text}: {EXAMPLE}")
    return min(parts), max(parts)


def _check(variable: Variable, text: str, car: KnownCar) -> None:
    """Raise CampaignError where a bound lies outside of what the number can be."""
    for value in (variable.low, variable.high):
        if variable.key in car.vehicle.values:
            changed(car.vehicle, {variable.key: value}, Path(f"{OPTION} {text}"))
        elif car.bounded({variable.key: value}) != {variable.key: value}:
            raise CampaignError(f"{OPTION} {text}: {value:g} is outside of what it can be")


def _options(far: str, text: str, known: Sequence[str]) -> Mapping[str, float]:
    """What stands behind a file's name, `:key=number`."""
    found: dict[str, float] = {}
    for key, value in Word.parse(far, f"{OPTION} {text.partition('=')[0]}").options.items():
        if key not in known:
            raise CampaignError(f"{OPTION} {text}: {key} is none of {', '.join(known)}")
        if isinstance(value, str) or not isfinite(value):
            raise CampaignError(f"{OPTION} {text}: {key} must be a number")
        found[key] = value
    return found


def _ratio(options: Mapping[str, float], text: str) -> float:
    ratio = options.get("ratio", 1.0)
    if not 0.0 < ratio <= 2.0:
        raise CampaignError(f"{OPTION} {text}: ratio, travel there over that of the wheel: 0 … 2")
    return ratio
