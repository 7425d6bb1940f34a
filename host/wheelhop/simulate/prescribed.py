"""Prescribed motion: what of a measured one is drift, and the path of a wheel over the track."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate, linalg

from wheelhop.campaign import Averaging, Campaign, CampaignError, Run
from wheelhop.effects import Effect, RunSetting, TrackSurvey, WheelShape
from wheelhop.simulate.model import Model
from wheelhop.track import CannotClimb, Track, Wheel, WheelPath, make_track
from wheelhop.vehicle import CORNERS, behind_m

Array = NDArray[np.float64]

KEPT_BELOW = 2.0
"""Measured axle motion is kept down to the band's lower edge over this. It is not compared there,
but it moves what is not linear: friction holds or slips as the whole stroke goes. Further down the
sensors' noise, twice integrated, is larger than the road."""


FADE_S = 1.0
"""The road rises from flat over this time at the beginning of the run-up."""


@dataclass(frozen=True, eq=False)
class Prescribed:
    """What moves a model at every step of a run: heights (T, m), m, under its wheels and their
    rates (T, m), m/s, and applied forces (T, k), N; so many steps `stride` to a sample, `first` of
    them before the record."""

    height: Array
    rate: Array
    force: Array
    stride: int
    first: int


def applied_forces(
    model: Model, effects: Iterable[Effect], run: RunSetting, time_s: Array
) -> Array:
    """Histories (T, k), N, of the forces that these effects of a model apply in a run."""
    way, speed = ways(model, run, time_s)
    histories = [
        history
        for effect in effects
        for history in effect.forces(model.theta(effect, run.run_id), run, time_s, way, speed)
    ]
    return np.stack(histories, axis=1)


def slow_part(time_s: Array, height: Array, spacing_s: float) -> interpolate.BSpline:
    """Least-squares cubic spline with knots one period of the band's lower edge apart: it follows
    what drifts, constants of integration included, and leaves what lies in band. Unlike a filter
    it has no transient at the ends."""
    count = max(int((time_s[-1] - time_s[0]) / spacing_s), 1)
    inner = np.linspace(time_s[0], time_s[-1], count + 1)
    knots = np.concatenate([[inner[0]] * 3, inner, [inner[-1]] * 3])
    return interpolate.make_lsq_spline(time_s, height, knots, k=3)


def unaveraged(
    time_s: Array, record: Array, averaging: Averaging, beyond: int
) -> interpolate.CubicSpline:
    """The cubic spline whose means about the samples are the record (n, c).

    Averaging commutes with a linear model, not with friction: the axle must move as it did, and
    what the model then shows is averaged. The means are sums of the B-splines about each sample,
    weighted by the means of one of them (M. Unser, Splines: a perfect fit for signal and image
    processing, IEEE Signal Processing Magazine 16 (1999) 22, there without averaging). Below half
    the sample rate a window of one period keeps at least 2/π of every frequency: there is one such
    spline. Outside the record, `beyond` samples on, the acceleration stays what it was at its end.
    """
    period = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
    reach = 2 + math.ceil(averaging.reach_s / period)
    near = np.arange(-reach, reach + 1, dtype=np.float64) * period
    one = np.zeros(4 * reach + 1)
    one[2 * reach] = 1.0
    weights = _means(_uniform(2 * near[0], period, one), averaging, near)
    values = np.pad(record, ((beyond, beyond), (0, 0)), mode="edge")
    matrix = np.repeat(weights[:, None], len(values), axis=1)  # its diagonals, as LAPACK has them
    for k in range(reach):  # B-splines beyond the ends are as high as the last ones
        matrix[[reach + k, reach - k], [0, -1]] += weights[: reach - k].sum()
    heights = linalg.solve_banded((reach, reach), matrix, values)
    instants = time_s[0] + period * np.arange(-beyond, len(time_s) + beyond)
    found = _uniform(instants[0], period, heights)
    slopes = found(instants[[0, -1]], 1)
    # The same spline piece by piece: it is evaluated faster.
    return interpolate.CubicSpline(
        instants, found(instants), bc_type=((1, slopes[0]), (1, slopes[1]))
    )


def _uniform(first_s: float, period_s: float, heights: Array) -> interpolate.BSpline:
    """Cubic B-splines a period apart, from `first_s` on; beyond both ends they go on as high."""
    knots = first_s + period_s * np.arange(-3, len(heights) + 3)
    return interpolate.BSpline(knots, np.concatenate([heights[:1], heights, heights[-1:]]), 3)


def _means(signal: interpolate.BSpline, averaging: Averaging, time_s: Array) -> Array:
    """Means (n, c) of a signal about some instants."""
    half = averaging.window_s / 2
    instants = [time_s + centre for centre in averaging.centres_s]
    if half == 0.0:
        return np.asarray(np.mean([signal(t) for t in instants], axis=0))
    way = signal.antiderivative()
    return np.asarray(np.mean([way(t + half) - way(t - half) for t in instants], axis=0)) / (
        2 * half
    )


def twice_integrated(
    acceleration: interpolate.CubicSpline, time_s: Array, lowest_hz: float
) -> tuple[Array, Array]:
    """Displacement and velocity (T, c) of an acceleration, without what drifts; the band that is
    compared begins at `lowest_hz`."""
    velocity, height = (acceleration.antiderivative(i)(time_s) for i in (1, 2))
    drift = slow_part(time_s, height, KEPT_BELOW / lowest_hz)
    return height - drift(time_s), velocity - drift(time_s, 1)


def track_of(model: Model, run: Run, track: Track) -> Track:
    """The track under a run: as surveyed, or as an effect says that it really is."""
    spec = run.track
    for effect in model.effects:
        if isinstance(effect, TrackSurvey):
            spec = effect.surveyed(model.theta(effect), spec)
    return track if spec is run.track else make_track(spec)


def ways(model: Model, run: RunSetting, time_s: Array) -> tuple[Array, Array]:
    """Distance (T, 4), m, each corner has come along the track, and its rate, m/s."""
    free = model.runs.get(run.run_id, {})
    speed = free.get("speed_m_s", run.speed_m_s)
    start = free.get("start_m", 0.0)
    position, now = start + speed * time_s, np.full_like(time_s, speed)
    if run.course is not None:  # all of it faster, or slower
        faster = speed / run.speed_m_s
        position = run.course.place(run.course.time(start) + faster * time_s)
        now = faster * run.course.speed(position)
    if run.driven is not None:
        position = start + speed * run.driven.gone(time_s)
        now = speed * run.driven.faster(time_s)
    stretch = model.stretch(run.run_id)
    position, now = stretch * position, stretch * now
    x = position[:, None] - np.array([behind_m(model.values, i) for i in CORNERS])
    rate = np.repeat(now[:, None], len(CORNERS), axis=1)
    for effect in model.effects:
        theta = model.theta(effect, run.run_id)
        extra = effect.travel(theta, run, time_s, position, stretch * speed)
        if extra is not None:
            x, rate = x + extra[0], rate + extra[1]
    return x, rate


def span(track: Track, x: Array) -> tuple[float, float]:
    """A stretch of track around x whose ends stay put when x moves a little; if it holds more than
    a period, all of the track, so that runs over it share their paths."""
    low, high = math.floor(x.min() / 5.0 - 0.2) * 5.0, math.ceil(x.max() / 5.0 + 0.2) * 5.0
    if track.period_m is not None and track.period_m < high - low:
        return -math.inf, math.inf
    return low, high


def rise(time_s: Array, height: Array, rate: Array) -> None:
    """Let the road (T, m) begin flat, in place."""
    rising = np.searchsorted(time_s, time_s[0] + FADE_S)
    ramp = ((time_s[:rising] - time_s[0]) / FADE_S)[:, None]
    fade, fade_rate = ramp**2 * (3 - 2 * ramp), 6 * ramp * (1 - ramp) / FADE_S
    rate[:rising] = rate[:rising] * fade + height[:rising] * fade_rate
    height[:rising] *= fade


def wheel_path(model: Model, corner: int, wheel: Wheel) -> WheelPath:
    """What an effect makes of the wheel's path, else that of a rigid wheel."""
    for effect in model.effects:
        if isinstance(effect, WheelShape):
            return effect.wheel_path(model.theta(effect), corner, wheel)
    return wheel.rigid()


@contextmanager
def climbing(campaign: Campaign, run: Run) -> Iterator[None]:
    """For what rolls the nominal wheels over a run's track: raises CampaignError where one of them
    cannot climb it."""
    try:
        yield
    except CannotClimb as error:
        where = campaign.folder / "campaign.toml"
        raise CampaignError(
            f'{where}: run "{run.id}": {error}: correct its track, or the vehicle\'s radius_m'
        ) from None
