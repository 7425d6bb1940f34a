"""One run, simulated: the road under the wheels (or measured axles), vehicle and sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import interpolate

from wheelhop.campaign import Campaign, Run
from wheelhop.effects import Effect, RunSetting
from wheelhop.simulate.integrator import integrate
from wheelhop.simulate.model import Model
from wheelhop.track import Envelope, Track, make_track, wheel_envelope
from wheelhop.vehicle import CORNERS, Drive, System, axle_name, corner_position

Array = NDArray[np.float64]

STEP_S = 0.0025
"""Longest step of the integration, 1/40 of a period of wheel hop; effects may ask for less."""

FADE_S = 1.0
"""The road rises from flat over this time at the beginning of the run-up."""

PATH_KEYS = (
    "geometry.wheelbase_m",
    "geometry.track_width_m",
    "wheel.front.radius_m",
    "wheel.rear.radius_m",
)
"""The vehicle's numbers on which the wheels' path depends."""

KEPT_MOTIONS = 12

INITIAL = ("heave", "pitch", "roll")
"""With measured axles the motion before the record is unknown: these start anywhere."""


@dataclass(frozen=True)
class Response:
    """What a model says a run should have measured.

    ``acceleration`` is (n, n_channels), m/s², at the run's samples, in the channels' order; NaN
    columns are not predicted. ``position_m`` (n,) is the x of the front axle at each sample, None
    when the track is unknown.
    """

    run_id: str
    acceleration: Array
    position_m: Array | None


class RunSimulator:
    """Everything about one run that does not change from simulation to simulation.

    Parameters
    ----------
    campaign, run
        What was recorded.
    run_up_s
        How long the vehicle drives before the first sample, so that its start is forgotten.
    """

    def __init__(self, campaign: Campaign, run: Run, run_up_s: float) -> None:
        self.campaign, self.run = campaign, run
        self.drive: Drive = "axles" if run.track.kind == "unknown" else "road"
        period = 1.0 / campaign.sample_rate_hz
        self._margin = math.ceil(campaign.averaging_s / period) + 1
        self._lead = self._margin
        if self.drive == "road":
            self._lead = max(self._margin, math.ceil(run_up_s / period))
        self.setting = RunSetting(
            run.id,
            run.speed_m_s,
            float(run.time_s[0] - self._lead * period),
            float(run.time_s[0]),
            float(run.time_s[-1] + self._margin * period),
            self.drive == "road",
        )
        self._track = make_track(run.track) if self.drive == "road" else None
        self._last: tuple[object, Array] | None = None
        self._motions: dict[tuple[object, ...], tuple[Array, Array]] = {}

    def _stride(self, model: Model) -> int:
        """Integration steps per sample."""
        longest = min([STEP_S, *(effect.longest_step_s for effect in model.effects)])
        return math.ceil(1.0 / (self.campaign.sample_rate_hz * longest) - 1e-9)

    def _times(self, stride: int, per_step: int) -> Array:
        """The instants of the integration's steps, or of their halves (per_step = 2)."""
        steps = (self._lead + len(self.run.time_s) - 1 + self._margin) * stride * per_step
        period = 1.0 / self.campaign.sample_rate_hz
        index = np.arange(steps + 1) / (stride * per_step) - self._lead
        return np.asarray(self.run.time_s[0] + index * period)

    @property
    def period_m(self) -> float | None:
        """Length after which the run's track repeats; None if it does not, or is not known."""
        return None if self._track is None else self._track.period_m

    def acts(self, effect: Effect) -> bool:
        """Whether the effect can act in this run: upstream of measured axles nothing does."""
        return self.drive == "road" or not effect.needs_road

    def simulate(self, model: Model, system: System) -> Response:
        """Response of `model`, whose equations of motion for this run's drive are `system`."""
        return Response(self.run.id, self.accelerations(model, system), self._position(model))

    def accelerations(self, model: Model, system: System) -> Array:
        """Accelerations (n, n_channels), m/s², as the instrument gives them."""
        acceleration = self._mechanics(model, system)
        for effect in filter(self.acts, model.effects):
            acceleration = effect.sense(
                model.theta(effect, self.run.id),
                acceleration,
                self.campaign.channels,
                self.campaign.sample_rate_hz,
            )
        return acceleration

    def _mechanics(self, model: Model, system: System) -> Array:
        """True accelerations; those of the last model are kept, for what only sensors change."""
        key = _without_sensors(model, self.run.id)
        if self.drive == "road" and self._last is not None and self._last[0] == key:
            return self._last[1]
        stride = self._stride(model)
        height, rate = self._motion(model, stride)
        time_s = self._times(stride, 2)
        histories = [
            history
            for effect in filter(self.acts, model.effects)
            for history in effect.forces(model.theta(effect, self.run.id), self.setting, time_s)
        ]
        acceleration = integrate(
            system,
            height,
            rate,
            np.stack(histories, axis=1) if histories else np.zeros((len(time_s), 0)),
            initial=self._initial(model, system),
            step_s=1.0 / (self.campaign.sample_rate_hz * stride),
            first=self._lead * stride,
            stride=stride,
            # Measured axle motion is averaged already, and averaging commutes with the model.
            window_s=self.campaign.averaging_s if self.drive == "road" else 0.0,
            n_samples=len(self.run.time_s),
        )
        self._last = (key, acceleration)
        return acceleration

    def _motion(self, model: Model, stride: int) -> tuple[Array, Array]:
        """Prescribed motions and rates (T, 4), m and m/s; the last few are kept."""
        upstream = [e for e in model.effects if e.needs_road or e.place == "sensor"]
        key = tuple(
            [
                float(stride),
                *(model.values[k] for k in PATH_KEYS),
                *model.runs.get(self.run.id, {}).items(),
                *((e.id, k, v) for e in upstream for k, v in model.theta(e).items()),
            ]
        )
        if key not in self._motions:
            time_s = self._times(stride, 1)
            make = self._road if self.drive == "road" else self._axles
            motion = make(model, time_s)
            while len(self._motions) >= KEPT_MOTIONS:
                del self._motions[next(iter(self._motions))]
            self._motions[key] = motion
        return self._motions[key]

    def _path(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Distance (T, 4), m, each wheel has come along the track, and its rate, m/s."""
        free = model.runs.get(self.run.id, {})
        speed = free.get("speed_m_s", self.run.speed_m_s)
        position = free.get("start_m", 0.0) + speed * time_s
        behind = [0.0, 0.0, model.values["geometry.wheelbase_m"]] * 2
        x = position[:, None] - np.array([behind[i] for i in (0, 1, 2, 5)])
        rate = np.full_like(x, speed)
        for effect in model.effects:
            theta = model.theta(effect, self.run.id)
            extra = effect.travel(theta, self.setting, time_s, position, speed)
            if extra is not None:
                x, rate = x + extra[0], rate + extra[1]
        return x, rate

    def _road(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        assert self._track is not None
        x, speed = self._path(model, time_s)
        height, rate = np.empty_like(x), np.empty_like(x)
        for i in CORNERS:
            envelope = _envelope(
                self._track,
                corner_position(model.values, i)[1],
                model.values[f"wheel.{axle_name(i)}.radius_m"],
                *_span(x[:, i]),
            )
            height[:, i], slope = envelope.height_and_slope(x[:, i])
            rate[:, i] = slope * speed[:, i]
        ramp = np.clip((time_s - time_s[0]) / FADE_S, 0.0, 1.0)[:, None]
        fade, fade_rate = ramp**2 * (3 - 2 * ramp), 6 * ramp * (1 - ramp) / FADE_S
        return height * fade, rate * fade + height * fade_rate

    def _axles(self, model: Model, time_s: Array) -> tuple[Array, Array]:
        """Measured axle accelerations, twice integrated and free of drift."""
        channels = self.campaign.channels
        measured = self.run.acceleration
        for effect in model.effects:
            measured = effect.restore(model.theta(effect, self.run.id), measured, channels)
        corner = {c.corner: i for i, c in enumerate(channels) if c.is_axle}
        columns = [corner[i] for i in CORNERS]
        inside = np.clip(time_s, self.run.time_s[0], self.run.time_s[-1])
        acceleration = interpolate.CubicSpline(self.run.time_s, measured[:, columns])
        velocity, height = (
            acceleration.antiderivative(1)(inside),
            acceleration.antiderivative(2)(inside),
        )
        drift = _slow_part(time_s, height, 1.0 / self.campaign.band_hz[0])
        return height - drift(time_s), velocity - drift(time_s, 1)

    def _initial(self, model: Model, system: System) -> Array:
        """State (2 n,) at the first step: rest, or what a run on measured axles leaves free."""
        n = len(system.mass)
        state = np.zeros(2 * n)
        free = model.runs.get(self.run.id, {})
        for i, name in enumerate(INITIAL):
            state[i] = free.get(f"initial_{name}", 0.0)
            state[n + i] = free.get(f"initial_{name}_rate", 0.0)
        return state

    def _position(self, model: Model) -> Array | None:
        if self._track is None:
            return None
        return np.asarray(self._path(model, self.run.time_s)[0][:, :2].mean(axis=1))


def _without_sensors(model: Model, run_id: str) -> object:
    """All of the model that moves the vehicle in a run."""
    sensors = tuple(f"{e.id}." for e in model.effects if e.place == "sensor")
    values = {k: v for k, v in model.values.items() if not k.startswith(sensors)}
    own = {k: v for k, v in model.runs.get(run_id, {}).items() if not k.startswith(sensors)}
    return values, own, [e for e in model.effects if e.place != "sensor"]


def _slow_part(time_s: Array, height: Array, spacing_s: float) -> interpolate.BSpline:
    """Least-squares cubic spline with knots one period of the band's lower edge apart: it follows
    what drifts, constants of integration included, and leaves what lies in band. Unlike a filter
    it has no transient at the ends."""
    count = max(int((time_s[-1] - time_s[0]) / spacing_s), 1)
    inner = np.linspace(time_s[0], time_s[-1], count + 1)
    knots = np.concatenate([[inner[0]] * 3, inner, [inner[-1]] * 3])
    return interpolate.make_lsq_spline(time_s, height, knots, k=3)


def _span(x: Array) -> tuple[float, float]:
    """A stretch of track around x whose ends stay put when x moves a little."""
    return math.floor(x.min() / 5.0 - 0.2) * 5.0, math.ceil(x.max() / 5.0 + 0.2) * 5.0


@lru_cache(maxsize=512)
def _envelope(track: Track, y_m: float, radius_m: float, low_m: float, high_m: float) -> Envelope:
    return wheel_envelope(track, y_m, radius_m, low_m, high_m)
