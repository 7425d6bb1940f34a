"""What reality does to a campaign: noise nobody stated, wrong beliefs, channels that are dead.

Each circumstance is a kind of the benchmark. Its campaigns hide nothing or one clear effect; the
folder is then changed as a workshop, a logger or an owner would have changed it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.signal import lfilter

from benchmarks.blind.folder import Array, Rng, Table, edit, list_channels, records, scale_tracks
from benchmarks.blind.recipes import Recipe
from benchmarks.blind.strength import Hidden
from benchmarks.blind.vehicles import Car
from tests.truth import CHANNELS, in_band
from tests.truth.other_laws import (
    BristleFriction,
    FoamStop,
    MeasuredDamper,
    TanhFriction,
    WanderingEngine,
)
from wheelhop.calibration import nominal_constants, write_constants

Spoil = Callable[[Path, Rng], None]
COMMON = ("", "dry-friction", "driver-seat", "left-right-drift", "anti-roll-bar")
"""One of these is hidden; "" is nothing."""

CODE_M_S2 = 0.2  # a 10-bit code of 0.55 m/s², a mean of eight conversions that noise hardly moves


@dataclass(frozen=True)
class Circumstance:
    """`hides` are the effects of which one is drawn, `laws` how the machine obeys them where not as
    the library has it; `spoil` changes the folder once it is written. A verdict may also name a
    hypothesis whose name begins with `belief`."""

    spoil: Spoil = lambda folder, rng: None
    hides: Sequence[str] = COMMON
    laws: Mapping[str, Recipe] = field(default_factory=dict)
    rate_hz: float = 100.0
    belief: str = ""


def _scale(file: Path, key: str, factor: float, count: int = 0) -> None:
    """Multiply the numbers that stand behind a key, the first `count` of them or all."""

    def scaled(found: re.Match[str]) -> str:
        return f"{found[1]}{float(found[2]) * factor:.8g}"

    edit(file, lambda text: re.sub(rf"(?m)^({re.escape(key)} = )(\S+)$", scaled, text, count=count))


def _noise_unstated(folder: Path, rng: Rng) -> None:
    edit(folder / "campaign.toml", lambda t: re.sub(r"(?m)^noise_rms_m_s2.*\n", "", t))


def _noise_misstated(folder: Path, rng: Rng) -> None:
    _scale(folder / "campaign.toml", "noise_rms_m_s2", float(rng.choice([0.8, 1.25])))


def _noise_coloured(folder: Path, rng: Rng) -> None:
    """As much again as the sensors' white noise, mostly below 3 Hz; the sum of both is stated."""
    found = re.search(r"noise_rms_m_s2 = (\S+)", (folder / "campaign.toml").read_text())
    assert found is not None
    rms = float(found[1])

    def add(names: list[str], rows: Array) -> Table:
        drift = lfilter([1.0], [1.0, -0.85], rng.normal(size=rows[:, 1:].shape), axis=0)
        rows[:, 1:] += rms / np.sqrt(np.mean(in_band(drift) ** 2)) * drift
        return names, rows

    records(folder, add)
    _scale(folder / "campaign.toml", "noise_rms_m_s2", np.sqrt(2.0))


def _codes(folder: Path, rng: Rng) -> None:
    """Rounded as a 10-bit converter does; the noise stated is the sensors'."""

    def rounded(names: list[str], rows: Array) -> Table:
        rows[:, 1:] = np.round(rows[:, 1:] / CODE_M_S2) * CODE_M_S2
        return names, rows

    records(folder, rounded)


def _scales(folder: Path, rng: Rng) -> None:
    """Every channel's scale off by 1.5 % (1 sd); a calibration beside it says data-sheet limits."""
    gains = 1.0 + 0.015 * rng.normal(size=len(CHANNELS))

    def scaled(names: list[str], rows: Array) -> Table:
        rows[:, 1:] *= gains
        return names, rows

    records(folder, scaled)
    write_constants(nominal_constants(CHANNELS), folder / "calibration.toml")


def _mass_believed(folder: Path, rng: Rng) -> None:
    _scale(folder / "vehicle.toml", "mass_kg", 1.25, count=1)  # the body's; claimed: 10 %


def _positions_believed(folder: Path, rng: Rng) -> None:
    """Two body points stated 10 cm from where they are."""
    vehicle = (folder / "vehicle.toml").read_text()
    length, width, ahead = (
        float(re.search(rf"{key} = (\S+)", vehicle)[1])  # type: ignore[index]
        for key in ("wheelbase_m", "track_width_m", "cg_to_front_axle_m")
    )
    moved = {f"B{k}" for k in rng.choice([1, 2, 3, 4], 2, replace=False)}
    places = {}
    for name in CHANNELS:
        corner = int(name[1]) - 1
        x = ahead - length * (corner // 2) + 0.1 * float(rng.choice([-1, 1]))
        y = width * (0.5 - corner % 2)
        places[name] = f"[{x:.4f}, {y:.4f}]" if name in moved else f'"{name}"'
    list_channels(folder, places)


def _surveyed(key: str, factor: float) -> Spoil:
    """All tracks of one kind are stated by that factor off."""

    def spoil(folder: Path, rng: Rng) -> None:
        kind = str(rng.choice(["washboard", "herringbone"]))

        scale_tracks(folder, key, lambda one: 1.0 / factor if one == kind else 1.0)

    return spoil


def _speed_believed(folder: Path, rng: Rng) -> None:
    _scale(folder / "campaign.toml", "speed_kmph", 0.92)


def _few(count: int) -> Spoil:
    """Only some of the runs, at least one of them held out if there are several."""

    def spoil(folder: Path, rng: Rng) -> None:
        head, *blocks = (folder / "campaign.toml").read_text().split("\n[[run]]")
        held = [b for b in blocks if 'role = "validate"' in b]
        fitted = [b for b in blocks if 'role = "fit"' in b]
        kept = fitted[:1] if count == 1 else held[: count // 3] + fitted[: count - count // 3]
        chosen = [b for b in blocks if b in kept]
        (folder / "campaign.toml").write_text("\n[[run]]".join([head, *chosen]))

    return spoil


def _dead(folder: Path, rng: Rng) -> None:
    """One channel shows the same number all the time."""
    column = 1 + int(rng.integers(len(CHANNELS)))

    def still(names: list[str], rows: Array) -> Table:
        rows[:, column] = rows[0, column]
        return names, rows

    records(folder, still)


def _only(count: int) -> Spoil:
    """So many channels, drawn."""

    def spoil(folder: Path, rng: Rng) -> None:
        kept = sorted(1 + rng.choice(len(CHANNELS), count, replace=False))
        columns = [0, *kept]
        records(folder, lambda names, rows: ([names[c] for c in columns], rows[:, columns]))
        list_channels(folder, {CHANNELS[c - 1]: f'"{CHANNELS[c - 1]}"' for c in kept})

    return spoil


def _tanh(rng: Rng, car: Car) -> Hidden:
    front, rear = 0.02 * car.static_load_N[[0, 2]] * rng.permutation([1.0, rng.uniform(0.0, 1.0)])
    creep = float(np.exp(rng.uniform(*np.log([0.002, 0.02]))))
    return Hidden(lambda s: TanhFriction(float(front * s), float(rear * s), creep))


def _bristles(rng: Rng, car: Car) -> Hidden:
    front, rear = 0.02 * car.static_load_N[[0, 2]] * rng.uniform(0.6, 1.4, 2)
    return Hidden(lambda s: BristleFriction(float(front * s), float(rear * s)))


def _dynamometer(rng: Rng, car: Car) -> Hidden:
    knee, lead = rng.uniform(0.1, 0.4) * float(car.rate_m_s.max()), rng.uniform(0.0, 0.15)
    return Hidden(lambda s: MeasuredDamper(knee, 1.0 - 0.1 * s, lead), most=9.0)


def _foam(rng: Rng, car: Car) -> Hidden:
    clearance = rng.uniform(0.4, 0.7) * float(car.travel_m.max())
    onset = rng.uniform(0.1, 0.4) * float(car.travel_m.max())
    stiffness = 2.0 * car.vehicle["suspension.front.stiffness_N_m"]
    return Hidden(lambda s: FoamStop(clearance, stiffness * s, onset))


def _idling(rng: Rng, car: Car) -> Hidden:
    force, freq = 0.2 * car.vehicle["body.mass_kg"], rng.uniform(12.0, 25.0)
    x, y = car.vehicle["engine.x_m"], car.vehicle["engine.y_m"]
    return Hidden(lambda s: WanderingEngine(force * s, freq, 0.02 * freq, 0.006 * freq, x, y))


def _as(name: str, law: Recipe) -> Circumstance:
    return Circumstance(hides=(name,), laws={name: law})


REALITY: dict[str, Circumstance] = {
    "noise-unstated": Circumstance(_noise_unstated),
    "noise-misstated": Circumstance(_noise_misstated),
    "noise-coloured": Circumstance(_noise_coloured),
    "codes": Circumstance(_codes),
    "scales": Circumstance(_scales, belief="sensor-gain"),
    "tanh-friction": _as("dry-friction", _tanh),
    "bristle-friction": _as("dry-friction", _bristles),
    "measured-damper": _as("digressive-damper", _dynamometer),
    "foam-stop": _as("bump-stop", _foam),
    "idling-engine": _as("engine-vibration", _idling),
    "mass-believed": Circumstance(_mass_believed),
    "positions-believed": Circumstance(_positions_believed, belief="belief: position of"),
    "amplitude-believed": Circumstance(_surveyed("amplitude_mm", 1.1), belief="belief: amplitude"),
    "wavelength-believed": Circumstance(_surveyed("pitch_mm", 1.01), belief="belief: wavelength"),
    "speed-believed": Circumstance(_speed_believed),
    "six-runs": Circumstance(_few(6)),
    "three-runs": Circumstance(_few(3)),
    "one-run": Circumstance(_few(1)),
    "dead-channel": Circumstance(_dead),
    "missing-channel": Circumstance(_only(7)),
    "four-channels": Circumstance(_only(4)),
    "400-hz": Circumstance(rate_hz=400.0),
    "1000-hz": Circumstance(rate_hz=1000.0),
}
"""In this order: a circumstance keeps its seeds for good."""
