"""The mistakes, each as a function that plants it into a campaign and its vehicle."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Run, TrackSpec
from wheelhop.vehicle import Vehicle

Array = NDArray[np.float64]
Asked = tuple[Campaign, Vehicle]
Mistake = Callable[[Campaign, Vehicle, np.random.Generator], Asked]

GRAVITY = 9.80665


def recorded(campaign: Campaign, change: Callable[[Array], Array], ids: object = None) -> Campaign:
    """The campaign with its records changed: all of them, or those of one run id."""
    runs = tuple(
        replace(run, record=change(run.record)) if ids in (None, run.id) else run
        for run in campaign.runs
    )
    return replace(campaign, runs=runs)


def columns(campaign: Campaign, renamed: dict[str, str]) -> Callable[[Array], Array]:
    """What a record is if each channel holds what belongs to another."""
    names = [c.name for c in campaign.channels]
    order = [names.index(renamed.get(name, name)) for name in names]
    return lambda y: y[:, order]


def scaled(campaign: Campaign, factor: float, *names: str) -> Callable[[Array], Array]:
    """A record with channels (all, if none is named) multiplied."""
    gains = np.array([factor if not names or c.name in names else 1.0 for c in campaign.channels])
    return lambda y: y * gains


def speeds(campaign: Campaign, factor: float) -> Campaign:
    """All stated speeds multiplied."""
    runs = tuple(replace(r, speed_m_s=r.speed_m_s * factor) for r in campaign.runs)
    return replace(campaign, runs=runs)


def tracks(campaign: Campaign, key: str, factor: float, ids: object = None) -> Campaign:
    """A length of the stated tracks multiplied."""

    def changed(track: TrackSpec) -> TrackSpec:
        values = dict(track.values)
        values[key] = float(values[key]) * factor
        return replace(track, values=values)

    runs = tuple(
        replace(r, track=changed(r.track)) if ids in (None, r.id) else r for r in campaign.runs
    )
    return replace(campaign, runs=runs)


def loud(campaign: Campaign, rng: np.random.Generator, count: int = 1) -> list[str]:
    """Ids of some runs that move more than in the middle."""
    size = {run.id: float(run.record.std()) for run in campaign.runs}
    middle = statistics.median(size.values())
    return [str(name) for name in rng.permutation([k for k, v in size.items() if v > middle])][
        :count
    ]


def loud_run(campaign: Campaign, rng: np.random.Generator) -> Run:
    """One of them."""
    chosen = loud(campaign, rng)[0]
    return next(run for run in campaign.runs if run.id == chosen)


def some(campaign: Campaign, rng: np.random.Generator, count: int = 1) -> list[str]:
    """Names of some channels."""
    return [str(name) for name in rng.permutation([c.name for c in campaign.channels])][:count]


SIDES = {"A1": "A2", "A2": "A1", "A3": "A4", "A4": "A3", "B1": "B2", "B2": "B1"} | {
    "B3": "B4",
    "B4": "B3",
}
ENDS = {f"{k}{i}": f"{k}{(i + 1) % 4 + 1}" for k in "AB" for i in (1, 2, 3, 4)}
KINDS = {f"{k}{i}": f"{'BA'['AB'.index(k)]}{i}" for k in "AB" for i in (1, 2, 3, 4)}


def exchanged_files(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """The recordings of two runs on different tracks, or at different speeds, exchanged."""
    first, second = loud(c, rng, 2)
    record = {run.id: run.record for run in c.runs}
    swapped = {first: record[second], second: record[first]}
    runs = tuple(replace(r, record=swapped.get(r.id, r.record)) for r in c.runs)
    return replace(c, runs=runs), v


def same_file(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """One recording under two ids."""
    first, second = loud(c, rng, 2)
    record = {run.id: run.record for run in c.runs}
    return recorded(c, lambda y: record[first], second), v


def overlapping(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """A run cut from a recording that another run holds, too: 60 % of it, and the next 40 %."""
    source = loud_run(c, rng)
    part = round(0.6 * len(source.record))
    other = np.vstack([source.record[-part:], np.roll(source.record, 7, axis=0)[:-part]])
    added = replace(source, id=f"{source.id}-again", record=other, role="validate")
    return replace(c, runs=(*c.runs, added)), v


def exported_again(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """One recording twice, once with its means taken out, rounded otherwise."""
    source = loud_run(c, rng)
    other = np.round(source.record - source.record.mean(axis=0), 4)
    added = replace(source, id=f"{source.id}-again", record=other)
    return replace(c, runs=(*c.runs, added)), v


def dead(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """A channel that holds nothing but noise."""
    gone = np.isin([ch.name for ch in c.channels], some(c, rng))
    noise = c.noise_rms or 0.1
    return recorded(c, lambda y: np.where(gone, noise * rng.normal(size=y.shape), y)), v


def stuck(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """A channel that stands still from somewhere in a run on."""
    gone, start = np.isin([ch.name for ch in c.channels], some(c, rng)), int(rng.integers(100, 600))

    def hold(y: Array) -> Array:
        held = np.where(gone, y[start], y)
        return np.vstack([y[:start], held[start:]])

    return recorded(c, hold), v


def clipped(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """A channel whose range ends at 60 % of its peaks in the loudest run."""
    name = some(c, rng)[0]
    column = [ch.name for ch in c.channels].index(name)
    limit = 0.6 * max(float(np.abs(run.record[:, column]).max()) for run in c.runs)
    at = np.array([limit if ch.name == name else np.inf for ch in c.channels])
    return recorded(c, lambda y: np.clip(y, -at, at)), v


def at_rest(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """A run's recording cut from where the vehicle stood."""
    noise = c.noise_rms or 0.1
    return recorded(c, lambda y: noise * rng.normal(size=y.shape), loud(c, rng)[0]), v


def integrated(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """Velocities, m/s, in place of accelerations."""

    def once(y: Array) -> Array:
        sums = np.cumsum(y - y.mean(axis=0), axis=0) / c.sample_rate_hz
        return np.asarray(sums - sums.mean(axis=0))

    return recorded(c, once), v


def on_the_hub(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """The wire of an axle's sensor on a body channel, too."""
    point = int(rng.integers(1, 5))
    return recorded(c, columns(c, {f"B{point}": f"A{point}"})), v


def elsewhere(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """A body sensor that was screwed to the axle below, beside the axle's own."""
    point = int(rng.integers(1, 5))
    on_axle = columns(c, {f"B{point}": f"A{point}"})
    own = np.array([0.1 * (ch.name == f"B{point}") for ch in c.channels])
    return recorded(c, lambda y: on_axle(y) + own * rng.normal(size=y.shape)), v


def out_of_step(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """Axles and body on two loggers whose clocks are 60 ms apart."""
    late = [ch.is_axle for ch in c.channels]
    lag = round(0.06 * c.sample_rate_hz)
    return recorded(c, lambda y: np.where(late, np.roll(y, lag, axis=0), y)), v


def sample_file(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """Numbers of vehicle.toml left as `wheelhop campaign new` wrote them, all but the weight."""
    from wheelhop.campaign.sample import VEHICLE
    from wheelhop.vehicle import read_vehicle

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "vehicle.toml"
        file.write_text(VEHICLE.format(title='"mine"'), encoding="utf-8")
        sample = read_vehicle(file)
    mass = {"body.mass_kg": v["body.mass_kg"]}
    return c, sample.with_values(mass)


def number(key: str, factor: float) -> Mistake:
    """A number of vehicle.toml in another unit."""

    def wrong(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
        return c, replace(
            v,
            values={**v.values, key: v[key] * factor},
            uncertainty={**v.uncertainty, key: v.uncertainty[key] * factor},
        )

    return wrong


def kept_gravity(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """In g, gravity kept."""
    return recorded(c, lambda y: y / GRAVITY + 1.0), v


def codes(c: Campaign, v: Vehicle, rng: np.random.Generator) -> Asked:
    """Codes of a converter of 10 bits."""
    return recorded(c, lambda y: np.clip(np.round(512 + y / GRAVITY * 17.6), 0, 1023)), v


def of_one_run(change: Callable[[Campaign, str], Campaign]) -> Mistake:
    """A mistake in a single run that moves."""
    return lambda c, v, rng: (change(c, loud(c, rng)[0]), v)


def run_speed(c: Campaign, run_id: str, factor: float) -> Campaign:
    """The stated speed of one run multiplied."""
    runs = tuple(
        replace(r, speed_m_s=r.speed_m_s * factor) if r.id == run_id else r for r in c.runs
    )
    return replace(c, runs=runs)


MISTAKES: dict[str, tuple[str, Mistake]] = {
    "records in g": ("units", lambda c, v, r: (recorded(c, scaled(c, 1 / GRAVITY)), v)),
    "in g, gravity kept": ("units", kept_gravity),
    "in mm/s²": ("units", lambda c, v, r: (recorded(c, scaled(c, 1000.0)), v)),
    "codes, not calibrated": ("units", codes),
    "one channel in g": (
        "units",
        lambda c, v, r: (recorded(c, scaled(c, 1 / GRAVITY, *some(c, r))), v),
    ),
    "velocities": ("units", integrated),
    "m/s under km/h": ("speed", lambda c, v, r: (speeds(c, 1 / 3.6), v)),
    "miles per hour": ("speed", lambda c, v, r: (speeds(c, 1 / 1.609344), v)),
    "sample rate halved": (
        "sample-rate speed",
        lambda c, v, r: (
            replace(
                c,
                sample_rate_hz=c.sample_rate_hz / 2,
                band_hz=(c.band_hz[0], min(c.band_hz[1], 0.45 * c.sample_rate_hz / 2)),
                runs=tuple(replace(run, time_s=run.time_s * 2) for run in c.runs),
            ),
            v,
        ),
    ),
    "one run's speed halved": (
        "track-or-speed",
        of_one_run(lambda c, name: run_speed(c, name, 0.5)),
    ),
    "one run's pitch": (
        "track-or-speed",
        of_one_run(lambda c, name: tracks(c, "pitch_m", 1.6, name)),
    ),
    "heights in cm": ("heights units", lambda c, v, r: (tracks(c, "amplitude_m", 0.1), v)),
    "one run's height in cm": (
        "heights",
        of_one_run(lambda c, name: tracks(c, "amplitude_m", 0.1, name)),
    ),
    "two recordings exchanged": ("runs-exchanged", exchanged_files),
    "one recording twice": ("copy", same_file),
    "overlapping recordings": ("copy", overlapping),
    "exported twice": ("copy", exported_again),
    "a run at rest": ("at-rest", at_rest),
    "body and axle exchanged": ("exchanged", lambda c, v, r: (recorded(c, columns(c, KINDS)), v)),
    "left and right exchanged": ("exchanged", lambda c, v, r: (recorded(c, columns(c, SIDES)), v)),
    "front and rear exchanged": ("exchanged", lambda c, v, r: (recorded(c, columns(c, ENDS)), v)),
    "one channel inverted": (
        "polarity",
        lambda c, v, r: (recorded(c, scaled(c, -1.0, *some(c, r))), v),
    ),
    "the axles inverted": (
        "polarity",
        lambda c, v, r: (recorded(c, scaled(c, -1.0, "A1", "A2", "A3", "A4")), v),
    ),
    "two channels exchanged": (
        "swapped",
        lambda c, v, r: (
            recorded(c, columns(c, dict(zip(*[(p := some(c, r, 2)), p[::-1]], strict=True)))),
            v,
        ),
    ),
    "a channel dead": ("dead", dead),
    "a channel stuck": ("stuck", stuck),
    "a channel clipped": ("clipping", clipped),
    "one wire on two inputs": ("same-signal", on_the_hub),
    "a body sensor on the axle": ("not-rigid same-signal misplaced", elsewhere),
    "two loggers out of step": ("out-of-step", out_of_step),
    "the sample vehicle": ("template", sample_file),
    "a spring in N/mm": ("no-vehicle", number("suspension.front.stiffness_N_m", 1e-3)),
    "a damper in N s/mm": ("no-vehicle", number("suspension.rear.damping_N_s_m", 1e-3)),
    "an inertia in g m²": ("no-vehicle", number("body.pitch_inertia_kg_m2", 1e3)),
    "lengths in mm": ("no-vehicle", number("geometry.wheelbase_m", 1e3)),
    "noise in mm/s²": (
        "noise",
        lambda c, v, r: (replace(c, noise_rms=(c.noise_rms or 0.1) * 1000), v),
    ),
    "noise in g": (
        "noise",
        lambda c, v, r: (replace(c, noise_rms=(c.noise_rms or 0.1) / GRAVITY), v),
    ),
}
"""What is planted: the kinds of findings that name it, and how it is done."""
