"""Motion that was measured and moves a model: that of the axles, or the travel of the struts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign import Campaign, Channel, Run
from wheelhop.simulate.job import OFFSET
from wheelhop.simulate.model import Model
from wheelhop.simulate.prescribed import twice_integrated, unaveraged
from wheelhop.simulate.sensors import as_read
from wheelhop.vehicle import Drive, wheels

Array = NDArray[np.float64]

REFLECTED = 20
"""So many samples are added to both ends of measured travel: a spline forgets within a few."""


def driven_by(campaign: Campaign, run: Run) -> Drive:
    """What moves the model in a run of a vehicle: on ground that is not known the measured axles,
    or, where more struts have a potentiometer than axles an accelerometer, the travel of the
    struts."""
    if run.track.kind != "unknown":
        return "road"
    return (
        "travel" if len(driving(campaign, "travel")) > len(driving(campaign, "axles")) else "axles"
    )


def driving(campaign: Campaign, drive: Drive) -> dict[int, int]:
    """The columns of the channels that move the model, by their corners; none on a known road."""
    return {
        channel.corner: i
        for i, channel in enumerate(campaign.channels)
        if channel.corner is not None and _drives(channel, drive)
    }


def _drives(channel: Channel, drive: Drive) -> bool:
    if drive == "axles":
        return channel.is_axle
    return drive == "travel" and channel.quantity == "travel"


def per_strut(campaign: Campaign, columns: list[int]) -> Array:
    """What driving channels show (c,) per what they measure at the wheel."""
    return np.array([campaign.channels[i].per_wheel for i in columns])


def measured_motion(
    campaign: Campaign, run: Run, drive: Drive, model: Model, beyond: int, time_s: Array
) -> tuple[Array, Array]:
    """Displacements and their rates (T, wheels), m and m/s, of what moves the model; so many
    samples `beyond` its ends the record goes on as it was there.

    Axles: accelerations as they were before the recorder, twice integrated and free of drift.
    Travel: about its mean over the run, or what the run says that it rests at beside that.
    """
    channels, rate_hz = campaign.channels, campaign.sample_rate_hz
    measured = as_read(run.record, rate_hz, campaign, model.values)
    for effect in model.effects:
        measured = effect.restore(model.theta(effect, run.id), measured, channels, rate_hz)
    corner, corners = driving(campaign, drive), wheels(model.values)
    columns = [corner[i] for i in corners]
    shown = measured[:, columns]
    if drive == "axles":
        signal = unaveraged(run.time_s, shown, campaign.averaging, beyond)
        return twice_integrated(signal, time_s, campaign.band_hz[0])
    signal = unaveraged(*_longer(run.time_s, shown), campaign.averaging, beyond)
    ratio, own = per_strut(campaign, columns), model.runs.get(run.id, {})
    rest = np.array([own.get(offset_name(i), 0.0) for i in corners])
    middle = shown.mean(axis=0)
    return (signal(time_s) - middle) / ratio - rest, signal(time_s, 1) / ratio


def _longer(time_s: Array, record: Array) -> tuple[Array, Array]:
    """A record (n, c) that goes on beyond its ends as it came, point-reflected there: a damper asks
    for the slope at the ends, which must not jump."""
    period = float(time_s[-1] - time_s[0]) / (len(time_s) - 1)
    more = min(REFLECTED, len(record) - 1)
    longer = np.pad(record, ((more, more), (0, 0)), mode="reflect", reflect_type="odd")
    return time_s[0] + period * np.arange(-more, len(record) + more), longer


def offset_name(corner: int) -> str:
    """How a run calls the extension at which a strut rests, over its mean in the run, m."""
    return f"{OFFSET}{corner + 1}_m"
