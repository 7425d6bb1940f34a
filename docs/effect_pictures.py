"""An effect in three panels: the law or mechanism itself, the channel that changes most against
time, and where the change lies by motion (or channel) and frequency."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from effect_stage import (
    DURATION_S,
    RATE_HZ,
    RUN_UP_S,
    Array,
    Change,
    Stage,
    extension,
    history,
    most_telling,
    strengths,
)
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, PowerNorm
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from wheelhop.compare.motion import MOTIONS, motion_matrix
from wheelhop.compare.thirds import third_octave_of, third_octaves
from wheelhop.effects import Effect, RandomHeights, WheelShape
from wheelhop.effects.acceleration_moment import AccelerationMoment
from wheelhop.simulate import RunSimulator, frequency_response
from wheelhop.track import Wheel, make_track
from wheelhop.vehicle import corner_position

SHOWN_FROM_S = 3.0
DAMPER_LAWS = ("asymmetric-damper", "digressive-damper")  # drawn against velocity
STRUT_LAWS = ("backlash", "mount-bushing")  # in series with spring and damper

INK, SOFT, RULE = "#1b1f24", "#5b6470", "#dfe3e8"
BASELINE, EFFECT = "#c8540a", "#0b66a8"
PANELS = [(0.07, 0.25, 0.2, 0.6), (0.335, 0.25, 0.26, 0.6), (0.69, 0.25, 0.235, 0.6)]
HEAT = LinearSegmentedColormap.from_list("paper to blue", ["#ffffff", "#9cc3e0", EFFECT, "#06263f"])
STYLE: dict[Any, object] = {
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.titlecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "axes.edgecolor": SOFT,
    "axes.labelcolor": SOFT,
    "xtick.color": SOFT,
    "ytick.color": SOFT,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "text.color": INK,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
}


def picture(effect: Effect, stage: Stage) -> Figure:
    """The effect's three panels."""
    change = most_telling(effect, stage)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10.4, 3.0))
        left, middle, right = (figure.add_axes(place) for place in PANELS)
        draw_mechanism(left, effect, stage, change)
        draw_time(middle, stage, change)
        draw_where(right, effect, stage, change)
        run = f"{change.run.id}, {change.run.speed_m_s * 3.6:.3g} km/h"
        words = f"{run}.  {setting_words(effect, stage)}"
        figure.text(0.012, 0.025, words, fontsize=7.8, color=SOFT)
    return figure


def setting_words(effect: Effect, stage: Stage) -> str:
    """At which values of its parameters the effect is shown."""
    words = [f"{name} = {float(f'{v:.3g}'):g}" for name, v in strengths(effect, stage).items()]
    choice = effect.choices(stage.campaign.channels)[0]
    if choice:
        words.insert(0, choice)
    free = effect.per_run(stage.setting(stage.campaign.runs[0]))
    if history(effect, len(free)).any():
        words.append("what is free in each run at half its scale")
    return ", ".join(words)


def window(change: Change, column: int) -> tuple[float, float]:
    """Two and a half waves of the road, but no more than 16 periods of the change, s."""
    half = change.band.coefficients(change.in_band[:, column])
    power = half[: len(half) // 2] ** 2 + half[len(half) // 2 :] ** 2
    frequency = change.band.frequency_hz[np.argmax(power)]
    waves = 2.5 * float(change.run.track.values["pitch_m"]) / change.run.speed_m_s
    shown = min(max(waves, 0.5), 16 / frequency, DURATION_S - SHOWN_FROM_S)
    return SHOWN_FROM_S, SHOWN_FROM_S + shown


def draw_time(axes: Axes, stage: Stage, change: Change) -> None:
    """The channel that changes most."""
    column = int(np.argmax(np.sum(change.in_band**2, axis=0)))
    time = change.run.time_s
    start, stop = window(change, column)
    shown = (time >= start) & (time <= stop)
    before, after = change.before[shown, column], change.after[shown, column]
    axes.plot(time[shown], before, color=BASELINE, lw=1.0, zorder=3, label="baseline")
    axes.plot(time[shown], after, color=EFFECT, label="with the effect")
    axes.set_title(f"acceleration at {stage.campaign.channels[column].name}", pad=15)
    axes.set_xlim(start, stop)
    axes.set_xlabel("time, s")
    axes.set_ylabel("m/s²")
    axes.legend(loc="lower left", bbox_to_anchor=(-0.02, 0.98), ncols=2, borderaxespad=0.0)


def draw_where(axes: Axes, effect: Effect, stage: Stage, change: Change) -> None:
    """The change's sum of squares, shared out over third-octaves and motions or channels."""
    names: tuple[str, ...] = tuple(channel.name for channel in stage.campaign.channels)
    combine = np.eye(len(names))
    if effect.place != "sensor":
        names = MOTIONS
        combine = motion_matrix(stage.campaign.channels, np.ones(len(combine), dtype=bool))
    coefficients = change.band.coefficients(change.after - change.before) @ combine.T
    bands = third_octaves(stage.campaign.band_hz)
    number = np.tile(third_octave_of(change.band.frequency_hz), 2)
    member = np.array([number == band.x for band in bands], dtype=float)
    power = (member @ coefficients**2).T
    share = 100 * power / power.sum()
    image = axes.imshow(share, aspect="auto", cmap=HEAT, norm=PowerNorm(0.5, 0, share.max()))
    axes.set_title("where the change lies", pad=15)
    axes.set_yticks(range(len(names)), names)
    ticks = range(0, len(bands), 3)
    axes.set_xticks(ticks, [bands[i].name for i in ticks])
    axes.tick_params(length=0)
    axes.set_xlabel("third-octave band, Hz")
    axes.spines[:].set_visible(False)
    axes.set_xticks(np.arange(len(bands) + 1) - 0.5, minor=True)
    axes.set_yticks(np.arange(len(names) + 1) - 0.5, minor=True)
    axes.grid(which="minor", color=RULE, linewidth=0.5)
    axes.tick_params(which="minor", length=0)
    bar = axes.figure.colorbar(image, cax=axes.inset_axes((1.03, 0.0, 0.03, 1.0)))
    bar.outline.set_visible(False)
    bar.ax.tick_params(length=0)
    bar.locator = MaxNLocator(4)
    bar.set_label("share of the change, %")


def draw_mechanism(axes: Axes, effect: Effect, stage: Stage, change: Change) -> None:
    """What the effect is, chosen by what it adds to the vehicle."""
    channels = stage.campaign.channels
    system = change.model.system(channels, "road")
    plain = stage.model.system(channels, "road")
    added = system.output[:, len(plain.mass) :]
    if effect.place == "sensor":
        draw_reading(axes, change)
    elif system.laws:
        draw_law(axes, effect, stage, change)
    elif system.force.shape[1]:
        draw_force(axes, effect, stage, change)
    elif added.any():
        draw_shape(axes, stage, added[:, 0])
    elif effect.place == "speed":
        draw_travel(axes, effect, stage, change)
    elif isinstance(effect, RandomHeights):
        draw_heights(axes, stage, change)
    elif isinstance(effect, WheelShape):
        draw_path(axes, effect, stage, change)
    else:
        draw_response(axes, stage, change)


def draw_law(axes: Axes, effect: Effect, stage: Stage, change: Change) -> None:
    """The force at the first part the law acts on, along the motion of this run."""
    x, v = extension(stage, change)
    system = change.model.system(stage.campaign.channels, "road")
    law, parameters = system.laws[system.port_law[0]], system.law_parameters[0]
    force, memory = np.zeros(len(x)), 0.0
    for i in range(1, len(x)):
        force[i], memory = law(x[i], v[i], x[i] - x[i - 1], 1 / RATE_HZ, memory, parameters)
    end = stage.vehicle.values
    if effect.place == "tyre":
        linear = (
            end["wheel.front.tyre_stiffness_N_m"] * x + end["wheel.front.tyre_damping_N_s_m"] * v
        )
        across, label, what = 1e3 * x, "deflection, mm (positive: lifted)", "tyre"
    elif effect.id in DAMPER_LAWS:
        linear = end["suspension.front.damping_N_s_m"] * v
        across, label, what = v, "rate, m/s (positive: rebound)", "damper"
    elif effect.id in STRUT_LAWS:
        linear = (
            end["suspension.front.stiffness_N_m"] * x + end["suspension.front.damping_N_s_m"] * v
        )
        across, label, what = 1e3 * x, "extension, mm (positive: rebound)", "strut"
    else:
        linear = end["suspension.front.stiffness_N_m"] * x
        across, label, what = 1e3 * x, "extension, mm (positive: rebound)", "spring"
    shown = change.run.time_s > SHOWN_FROM_S
    axes.plot(across[shown], linear[shown], color=BASELINE)
    axes.plot(across[shown], (linear + force)[shown], color=EFFECT)
    axes.set_title(f"front left {what} and effect", pad=15)
    axes.set_xlabel(label)
    axes.set_ylabel("force, N")


def draw_force(axes: Axes, effect: Effect, stage: Stage, change: Change) -> None:
    """An applied force against time, for two periods of what it does."""
    time, speed = change.run.time_s, change.run.speed_m_s
    theta, setting = change.model.theta(effect, change.run.id), stage.setting(change.run)
    way = np.repeat(speed * time[:, None], 4, axis=1)
    history = effect.forces(theta, setting, time, way, np.full_like(way, speed))[0]
    if isinstance(effect, AccelerationMoment):
        axes.plot(time, history, color=EFFECT)
        axes.axhline(0.0, color=BASELINE)
        axes.set_title(f"acceleration {effect.direction}", pad=15)
        axes.set_xlabel("time, s")
        axes.set_ylabel("m/s²")
        return
    # What the effect makes of its history is a force on something; levers are shorter than 1 m.
    system = change.model.system(stage.campaign.channels, "road")
    history = history * np.abs(system.force[:, 0]).max()
    turned = np.flatnonzero(np.diff(np.sign(history)) > 0)
    shown = slice(turned[0], turned[2] + 1) if len(turned) > 2 else slice(None)
    axes.plot(1e3 * (time[shown] - time[shown][0]), history[shown], color=EFFECT)
    axes.axhline(0.0, color=BASELINE)
    axes.set_title("force on the axle" if effect.place == "axle" else "force on the body", pad=15)
    axes.set_xlabel("time, ms")
    axes.set_ylabel("force, N")


def draw_path(axes: Axes, effect: WheelShape, stage: Stage, change: Change) -> None:
    """The path of the front left wheel's centre over two waves: rigid, and with the effect."""
    values = stage.vehicle.values
    pitch = float(change.run.track.values["pitch_m"])
    x = np.linspace(0.0, 2 * pitch, 801)
    y = corner_position(values, 0)[1]
    track, radius = make_track(change.run.track), values["wheel.front.radius_m"]
    wheel = Wheel(track, y, radius, -pitch, 3 * pitch)
    path = effect.wheel_path(change.model.theta(effect), 0, wheel)
    axes.plot(x, 1e3 * wheel.rigid().height(x), color=BASELINE)
    axes.plot(x, 1e3 * path.height_and_slope(x)[0], color=EFFECT)
    axes.set_title("path of the front left wheel", pad=15)
    axes.set_xlabel("way, m")
    axes.set_ylabel("height, mm")


def draw_heights(axes: Axes, stage: Stage, change: Change) -> None:
    """What lies on top of the track under the left wheels, and under the right ones."""
    series = RunSimulator(stage.campaign, change.run, RUN_UP_S).series
    assert series is not None
    way = np.linspace(0.0, 4.0, 801)
    height, _ = series.at(change.model.heights[change.run.id], np.repeat(way[:, None], 4, axis=1))
    axes.plot(way, 1e3 * height[:, 0], color=EFFECT, label="left")
    axes.plot(way, 1e3 * height[:, 1], color=SOFT, linewidth=0.8, label="right")
    axes.set_title("height on top of the track", pad=15)
    axes.set_xlabel("way, m")
    axes.set_ylabel("mm")
    axes.legend(loc="upper right")


def draw_travel(axes: Axes, effect: Effect, stage: Stage, change: Change) -> None:
    """What a wheel gains over constant speed: a lead of the left wheels, or a changing speed."""
    theta = change.model.theta(effect, change.run.id)
    time, speed = change.run.time_s, change.run.speed_m_s
    extra = effect.travel(theta, stage.setting(change.run), time, speed * time, speed)
    assert extra is not None
    distance, rate = extra
    if np.ptp(distance, axis=1).any():
        axes.plot(time, 1e3 * (distance[:, 0] - distance[:, 1]), color=EFFECT)
        axes.axhline(0.0, color=BASELINE)
        axes.set_title("lead of the left wheels", pad=15)
        axes.set_ylabel("mm")
    else:
        axes.plot(time, 3.6 * (speed + rate[:, 0]), color=EFFECT)
        axes.axhline(3.6 * speed, color=BASELINE)
        axes.set_title("forward speed", pad=15)
        axes.set_ylabel("km/h")
    axes.set_xlim(0.0, 5.5)  # towards their end splines are stiffer
    axes.set_xlabel("time, s")


def draw_reading(axes: Axes, change: Change) -> None:
    """What the sensor reads against what is there, for the channel most affected."""
    column = int(np.argmax(np.sum(change.in_band**2, axis=0)))
    true, read = change.before[:, column], change.after[:, column]
    order = np.argsort(true)
    axes.plot(true[order], true[order], color=BASELINE)
    axes.plot(true[order], read[order], color=EFFECT)
    axes.set_title("reading against truth", pad=15)
    axes.set_xlabel("true acceleration, m/s²")
    axes.set_ylabel("reading, m/s²")


def draw_response(axes: Axes, stage: Stage, change: Change) -> None:
    """The body's heave or roll, whichever changes more, over that of the road under all wheels."""
    frequency = np.geomspace(0.5, 30.0, 400)
    combine = motion_matrix(stage.campaign.channels, np.ones(8, dtype=bool))
    systems = [m.system(stage.campaign.channels, "road") for m in (stage.model, change.model)]
    shown: dict[str, Array] = {}
    for motion, road in (("heave", [1, 1, 1, 1]), ("roll", [1, -1, 1, -1])):
        responses = np.stack([frequency_response(s, frequency) @ road for s in systems])
        moved = responses @ combine[MOTIONS.index(motion)]
        shown[motion] = np.abs(moved) / 2 / (2 * np.pi * frequency) ** 2
    motion = max(shown, key=lambda name: float(np.abs(np.diff(shown[name], axis=0)).max()))
    for curve, colour in zip(shown[motion], (BASELINE, EFFECT), strict=True):
        axes.plot(frequency, curve, color=colour)
    axes.set_xscale("log")
    axes.set_xticks([0.5, 1, 2, 5, 10, 20], ["0.5", "1", "2", "5", "10", "20"])
    axes.set_title(f"{motion}, body over road", pad=15)
    axes.set_xlabel("frequency, Hz")
    axes.set_ylabel("transmissibility")


def draw_shape(axes: Axes, stage: Stage, mode: Array) -> None:
    """A mode of the body, seen obliquely: the corners before and after."""
    body = {c.corner: i for i, c in enumerate(stage.campaign.channels) if not c.is_axle}
    order = (0, 1, 3, 2, 0)
    corner = np.array([corner_position(stage.vehicle.values, i) for i in order])
    height = np.array([mode[body[i]] for i in order])
    across = corner[:, 0] - 0.45 * corner[:, 1]
    for up, colour in ((np.zeros(5), BASELINE), (0.22 * height, EFFECT)):
        axes.plot(across, 0.30 * corner[:, 1] + up, "o-", color=colour, ms=3.5)
    for i in range(4):
        foot, tip = 0.30 * corner[i, 1], 0.30 * corner[i, 1] + 0.22 * height[i]
        axes.plot([across[i]] * 2, [foot, tip], color=SOFT, lw=0.7)
        axes.annotate(
            f"B{order[i] + 1}",
            (across[i], tip),
            xytext=(0, 7 * np.sign(height[i])),
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=8,
        )
    axes.annotate("front →", (0.42, -0.05), xycoords="axes fraction", ha="center", color=SOFT)
    axes.margins(0.16)
    axes.set_axis_off()
    axes.set_title("shape of the mode", pad=15)
