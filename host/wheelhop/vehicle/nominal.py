"""What is believed of the thing tested, before any fit: a vehicle's numbers or a component's."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from wheelhop.campaign import Campaign, CampaignError, Channel, ComponentCampaign, RigRun
from wheelhop.campaign.channel import ABOARD
from wheelhop.vehicle.layout import motions, wheels
from wheelhop.vehicle.motion import Motion
from wheelhop.vehicle.mount import mount_values
from wheelhop.vehicle.vehicle import Vehicle, read_vehicle

Array = NDArray[np.float64]

TERMS = ("stiffness_N_m", "damping_N_s_m", "mass_kg")
"""The numbers that displacement, velocity and acceleration are multiplied with."""

LEAST_INERTIA = 0.03
"""A force can only move a mass: at the band's upper end it takes at least this share of it."""


def read_nominal(campaign: Campaign) -> Vehicle:
    """The numbers of vehicle.toml, or of a component campaign's [component].

    A nominal 0 of a component leaves that number free, unless the component is without it: it
    begins where least squares on the fitted runs put it, and its uncertainty is what it would be if
    it alone caused the force. Beside the component's numbers, "component.…", stand those of the
    rig, "rig.…": rms force, largest displacement and a third of the largest speed of the fitted
    runs, the largest value of each input, and, where force is measured, the load it shows at
    displacement 0.

    Raises
    ------
    CampaignError
        vehicle.toml is wrong, or the runs cannot tell what is left free; a channel sits at a corner
        that the vehicle does not have.
    """
    if isinstance(campaign, ComponentCampaign):
        return _component(campaign)
    vehicle = read_vehicle(campaign.vehicle_file)
    for channel in campaign.channels:
        if missing := _missing(channel, vehicle):
            raise CampaignError(
                f"{campaign.folder / 'campaign.toml'}: channel {channel.name} {missing}"
            )
    return vehicle


def _missing(channel: Channel, vehicle: Vehicle) -> str:
    """What the vehicle lacks for a channel, and what cures it, in words; empty if nothing."""
    lacks = _lacks(channel, vehicle)
    if channel.point in ABOARD and lacks:
        return f"{lacks}: say there what it weighs and where it is, or leave the channel out"
    return f"{lacks}: list the channels that are there under [channels]" if lacks else ""


def _lacks(channel: Channel, vehicle: Vehicle) -> str:
    rolling = wheels(vehicle.values)
    if channel.point in ABOARD and f"{channel.point}.mass_kg" not in vehicle.values:
        return f"sits on the {channel.point}, and vehicle.toml has no [{channel.point}]"
    if channel.quantity == "rate" and channel.point not in motions(vehicle.values):
        return f"is a rate of {channel.point}, and the vehicle does not {channel.point}"
    if channel.corner is None or channel.corner in rolling:
        return ""
    if channel.is_acceleration:
        there = ", ".join(f"{place}{i + 1}" for place in "AB" for i in rolling)
        return f"sits at {channel.point}, and the vehicle has only {there}"
    corners = ", ".join(str(i + 1) for i in rolling)
    return f"is of corner {channel.corner + 1}, and the vehicle has only {corners}"


def _component(campaign: ComponentCampaign) -> Vehicle:
    runs = [run for run in campaign.fit_runs if isinstance(run, RigRun)]
    motion = np.hstack([Motion(campaign, run).at(run.time_s) for run in runs])
    moved = np.hstack([_about_mean(Motion(campaign, run).at(run.time_s)) for run in runs])
    force = np.concatenate([_about_mean(run.force) for run in runs])
    nominal = np.array([campaign.nominal[key] for key in TERMS])
    stated = np.array([campaign.uncertainty[key] for key in TERMS])
    size = np.sqrt((moved**2).mean(axis=1))
    known = (stated > 0.0) | np.array([key in campaign.without for key in TERMS])
    typical = max(float(np.sqrt((force**2).mean())), float((nominal * size)[known].max(initial=0)))
    if typical == 0.0:
        raise CampaignError(
            f"{campaign.vehicle_file}: [component]: no run has a force, and free decays show"
            " nothing but ratios: give mass_kg or stiffness_N_m"
        )
    value = nominal.copy()
    if not known.all():
        rest = force - nominal[known] @ moved[known]
        scaled = moved[~known] / size[~known, None]
        value[~known] = optimize.nnls(scaled.T, rest)[0] / size[~known]
    uncertainty = np.where(known, stated, typical / size)
    if campaign.drive == "force":
        value[2] = max(value[2], _least_mass(campaign, value, typical / size))
    rig = {
        "force_N": typical,
        "travel_m": float(np.abs(motion[0]).max()),
        "speed_m_s": float(np.abs(motion[1]).max()) / 3,
    }
    for name in runs[0].inputs:
        rig[name] = max(float(np.abs(run.inputs[name]).max()) for run in runs) or 1.0
    if campaign.drive == "displacement":
        carried = value @ motion - np.concatenate([run.force for run in runs])
        rig["static_load_N"] = float(carried.mean())
    mount = {} if campaign.mount_file is None else mount_values(campaign.mount_file)
    values = dict(zip(TERMS, value.tolist(), strict=True))
    spread = dict(zip(TERMS, uncertainty.tolist(), strict=True))
    return Vehicle(
        campaign.title,
        {f"component.{k}": v for k, v in values.items()}
        | {f"rig.{k}": v for k, v in rig.items()}
        | mount,
        {f"component.{k}": v for k, v in spread.items()}
        | {f"rig.{k}": 0.0 for k in rig}
        | dict.fromkeys(mount, 0.0),
    )


def _about_mean(values: Array) -> Array:
    """What a record holds beside a constant, which no band contains."""
    return np.asarray(values - values.mean(axis=-1, keepdims=True))


def _least_mass(campaign: ComponentCampaign, value: Array, alone: Array) -> float:
    """The mass an imposed force must find, from the stiffness and damping it works against."""
    omega = 2 * np.pi * campaign.band_hz[1]
    stiffness, damping = (v if v > 0.0 else a for v, a in zip(value[:2], alone[:2], strict=True))
    return LEAST_INERTIA * float(np.hypot(stiffness, omega * damping)) / omega**2
