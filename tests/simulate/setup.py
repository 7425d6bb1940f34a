"""Runs and vehicles of the independent simulator, put to wheelhop in its own terms."""

from collections.abc import Mapping
from math import radians
from pathlib import Path

import numpy as np

from tests import truth
from wheelhop.campaign import Campaign, Channel, Run, TrackSpec
from wheelhop.effects import load_effects
from wheelhop.simulate import Model, RunSimulator, frequency_response
from wheelhop.vehicle import System

CHANNELS = tuple(Channel(name, name) for name in truth.CHANNELS)
ATV = dict(truth.PRESETS["atv"].vehicle)
EFFECTS = load_effects()
TIME = np.arange(512) / 100.0
DEFAULTS = {
    "herringbone": {"angle_deg": 20.0},
    "chassis-twist": {"width_mm": 4000.0, "lateral_offset_mm": 0.0},
    "half-sine-bump": {"side": "both"},
    "step-bump": {"side": "both"},
}


def track_spec(track: truth.Track) -> TrackSpec:
    """The track in SI, defaults filled in."""
    values = {}
    for key, value in (DEFAULTS.get(track.kind, {}) | track.keys).items():
        if key.endswith("_mm"):
            values[key.removesuffix("mm") + "m"] = float(value) / 1000.0
        elif key == "angle_deg":
            values["angle_rad"] = radians(float(value))
        else:
            values[key] = value
    return TrackSpec(track.kind, values)


def campaign_of(
    runs: Mapping[str, truth.Run],
    recorded: Mapping[str, np.ndarray] | None = None,
    *,
    roles: Mapping[str, str] | None = None,
    nominal_m_s: Mapping[str, float] | None = None,
    noise_rms: float | None = None,
    channels: tuple[Channel, ...] = CHANNELS,
) -> Campaign:
    """A campaign of these runs; without recordings every record is zero."""
    return Campaign(
        folder=Path(),
        title="test",
        vehicle_file=Path("vehicle.toml"),
        sample_rate_hz=100.0,
        band_hz=truth.campaign.BAND_HZ,
        averaging_s=next(iter(runs.values())).averaging_s,
        noise_rms=noise_rms,
        channels=channels,
        runs=tuple(
            Run(
                name,
                Path(f"{name}.csv"),
                (roles or {}).get(name, "fit"),
                (nominal_m_s or {}).get(name, run.speed_m_s),
                track_spec(run.track),
                run.time_s,
                np.zeros((len(run.time_s), len(channels))) if recorded is None else recorded[name],
            )
            for name, run in runs.items()
        ),
    )


def model_of(
    vehicle: Mapping[str, float],
    runs: Mapping[str, truth.Run],
    effect: str = "",
    theta: Mapping[str, float] | None = None,
    *,
    choice: str = "",
    own: Mapping[str, float] | None = None,
) -> Model:
    """The model whose numbers are known: vehicle, every run's speed and start, one effect."""
    values, effects = dict(vehicle), ()
    free = {
        name: {"speed_m_s": run.speed_m_s, "start_m": run.start_m} for name, run in runs.items()
    }
    if effect:
        form = EFFECTS[effect]
        effects = (form.with_choice(choice) if choice else form,)
        values |= {f"{effect}.{key}": value for key, value in (theta or {}).items()}
        for name in free:
            free[name] |= {f"{effect}.{key}": value for key, value in (own or {}).items()}
    return Model(values, effects, free)


def simulated(campaign: Campaign, model: Model, *, run_up_s: float = 4.0) -> dict[str, np.ndarray]:
    """Accelerations (n, c) of every run, m/s²."""
    found = {}
    for run in campaign.runs:
        simulator = RunSimulator(campaign, run, run_up_s)
        system = model.system(campaign.channels, simulator.drive)
        found[run.id] = simulator.record(model, system)
    return found


def linear_response(system: System, height: np.ndarray, step_s: float) -> np.ndarray:
    """Accelerations (T, c), m/s², for motions (T, m), m, of the wheels that repeat after T steps,
    by the discrete Fourier transform."""
    frequency = np.fft.rfftfreq(len(height), step_s)
    moved = frequency_response(system, frequency) @ np.fft.rfft(height, axis=0)[:, :, None]
    return np.fft.irfft(moved[:, :, 0], len(height), axis=0)


def relative(one: np.ndarray, other: np.ndarray) -> float:
    """Rms of the difference in band, over the rms of `other` in band."""
    return float(np.linalg.norm(truth.in_band(one - other)) / np.linalg.norm(truth.in_band(other)))
