"""Campaign folders with hidden effects: written from a simulation, read back with their truth."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from .effect import Effect
from .effects import Parameters, make_effects
from .model import CHANNELS, STEP_S, Run, record, sense_run, simulate_run
from .presets import PRESETS, PlannedRun, Preset, draw_vehicles, planned_runs
from .sensors import KEYS, Sensor, sense, with_noise
from .tracks import Array, Track
from .vehicle import Vehicle, flatten

BAND_HZ = (0.5, 30.0)
SAMPLE_RATE_HZ = 100.0
SECONDS = 10.24
OFFSET_M_S2 = 0.05  # standard deviation of a channel's constant offset
AVERAGING_S = 0.0066  # of one sample, but no more than three periods


@dataclass(frozen=True)
class Truth:
    """A campaign as it truly was."""

    vehicle: Vehicle
    effects: list[Effect]
    runs: dict[str, Run]
    roles: dict[str, str]
    recorded: dict[str, Array]  # (n, 8) of CHANNELS, m/s^2


def in_band(samples: Array, rate_hz: float = SAMPLE_RATE_HZ) -> Array:
    """The part of each column within BAND_HZ (ideal filter on the whole record)."""
    frequency = np.fft.rfftfreq(len(samples), 1.0 / rate_hz)
    spectrum = np.fft.rfft(samples, axis=0)
    spectrum[(frequency < BAND_HZ[0]) | (frequency > BAND_HZ[1])] = 0.0
    return np.fft.irfft(spectrum, len(samples), axis=0)


def make_campaign(
    folder: str | Path,
    *,
    seed: int,
    effects: Mapping[str, Parameters],
    preset: str = "atv",
    short: bool = False,
    noise_rms: float = 0.1,
    seconds: float = SECONDS,
    draft: bool = False,
    sensors: Sequence[Sensor] = (),
) -> Path:
    """Simulate and write one campaign with its truth.toml; returns the folder.

    The same arguments give the same files. `noise_rms` is one channel's noise in band, m/s^2,
    in the mean over channels; `seconds` is the length of a run; draft and sensors are those of
    `write_campaign`. Raises ValueError for an unknown preset, effect or parameter.
    """
    if preset not in PRESETS:
        raise ValueError(f"no preset {preset!r}; there are {', '.join(PRESETS)}")
    physics = make_effects(effects)
    return write_campaign(
        folder,
        PRESETS[preset],
        physics,
        seed=seed,
        short=short,
        noise_rms=noise_rms,
        seconds=seconds,
        draft=draft,
        sensors=sensors,
    )


def write_campaign(
    folder: str | Path,
    preset: Preset,
    physics: Sequence[Effect],
    *,
    seed: int,
    short: bool = False,
    noise_rms: float = 0.1,
    rate_hz: float = SAMPLE_RATE_HZ,
    seconds: float = SECONDS,
    draft: bool = False,
    without: Collection[str] = (),
    sensors: Sequence[Sensor] = (),
) -> Path:
    """`make_campaign` for a vehicle and for effects that need not be among the named ones; the same
    seconds at another sample rate, if one is given, and `without` the runs of these ids.

    A draft, to look at and not to keep, takes twice the step and says nothing of the baseline.
    With `sensors` these are recorded in place of the eight points, each with the noise it states;
    effects on sensors do nothing, and the truth knows no errors.
    """
    rng = np.random.default_rng(seed)
    true, nominal = draw_vehicles(preset, rng)
    offset_mm = float(rng.choice([0.0, 100.0, 200.0]))
    planned = planned_runs(preset, short=short, lateral_offset_mm=offset_mm)
    planned = [run for run in planned if run.id not in without]
    noise = _channel_noise(noise_rms, rate_hz, rng)
    offset = rng.normal(0.0, OFFSET_M_S2, len(CHANNELS))

    folder = Path(folder)
    (folder / "runs").mkdir(parents=True, exist_ok=True)
    runs: dict[str, Run] = {}
    for number, plan in enumerate(planned):
        runs[plan.id] = _draw_run(plan, rate_hz, seconds, seed * 1000 + number, rng)
    error = _Sums(rate_hz)
    step = min([STEP_S, *(effect.step_s for effect in physics)]) * (2.0 if draft else 1.0)
    for plan in planned:
        run = runs[plan.id]
        if sensors:
            shown = sense(true, run, sensors, physics, step_s=step)
            noisy = with_noise(shown, sensors, _share(rate_hz), rng)
            names = [sensor.name for sensor in sensors]
            _write_recording(folder / "runs" / f"{plan.id}.csv", run.time_s, noisy, names)
            continue
        true_samples = sense_run(true, run, physics, step_s=step)
        noisy = true_samples + offset + noise * rng.normal(size=true_samples.shape)
        samples = record(noisy, physics)
        _write_recording(folder / "runs" / f"{plan.id}.csv", run.time_s, samples)
        if plan.role == "validate":
            baseline = true_samples if draft else simulate_run(true, run)[1]
            error.add(samples, record(true_samples, physics), baseline)

    text = _campaign_toml(preset.name, planned, rate_hz, noise_rms, sensors)
    (folder / "campaign.toml").write_text(text)
    (folder / "vehicle.toml").write_text(_vehicle_toml(preset.name, nominal))
    truth = _truth_toml(true, physics, runs, noise, noise_rms, error)
    (folder / "truth.toml").write_text(truth)
    return folder


def forget_tracks(folder: Path) -> None:
    """Make campaign.toml say that the tracks of all runs are unknown."""
    toml = folder / "campaign.toml"
    lines = [
        line for line in toml.read_text().split("\n") if not re.match(r"track\.(?!kind)", line)
    ]
    toml.write_text(re.sub(r"track\.kind = .*", 'track.kind = "unknown"', "\n".join(lines)))


def read_truth(folder: str | Path, truth_file: str | Path | None = None) -> Truth:
    """A campaign with its truth, which lies beside it unless `truth_file` says where."""
    folder = Path(folder)
    campaign = tomllib.loads((folder / "campaign.toml").read_text())
    truth = tomllib.loads(Path(truth_file or folder / "truth.toml").read_text())
    runs, roles, recorded = {}, {}, {}
    for entry in campaign["run"]:
        name, true_run = entry["id"], truth["run"][entry["id"]]
        table = np.loadtxt(folder / entry["file"], delimiter=",", skiprows=1)
        if "file" in entry["track"]:
            entry["track"]["file"] = str(folder / entry["track"]["file"])
        runs[name] = Run(
            track=Track(entry["track"].pop("kind"), entry["track"]),
            speed_m_s=true_run["speed_kmph"] / 3.6,
            start_m=true_run["start_m"],
            time_s=table[:, 0],
            averaging_s=campaign["averaging_ms"] / 1000.0,
            seed=true_run.get("seed", 0),
        )
        roles[name], recorded[name] = entry["role"], table[:, 1:]
    chosen = {name: truth["effect"].get(name, {}) for name in truth["effects"]}
    return Truth(flatten(truth["vehicle_true"]), make_effects(chosen), runs, roles, recorded)


class _Sums:
    """Sums of squares in band over the validate runs."""

    def __init__(self, rate_hz: float) -> None:
        self._rate_hz = rate_hz
        self.measured = self.noise = self.hidden = 0.0

    def add(self, samples: Array, true_samples: Array, baseline: Array) -> None:
        rate = self._rate_hz
        self.measured += float(np.sum(in_band(samples, rate) ** 2))
        self.noise += float(np.sum(in_band(samples - true_samples, rate) ** 2))
        self.hidden += float(np.sum(in_band(samples - baseline, rate) ** 2))

    @property
    def lines(self) -> list[str]:
        """What truth.toml says of them."""
        return [
            "# error of the true vehicle with its effects (the noise), and without them",
            f"oracle_rel_validate = {np.sqrt(self.noise / self.measured):.6g}",
            f"baseline_rel_validate = {np.sqrt(self.hidden / self.measured):.6g}",
        ]


def _channel_noise(noise_rms: float, rate_hz: float, rng: np.random.Generator) -> Array:
    """Standard deviations of white noise (8,), unequal, whose in-band mean power is noise_rms^2."""
    relative = rng.uniform(0.7, 1.3, len(CHANNELS))
    mean_power = float(np.mean(relative**2))
    return noise_rms / np.sqrt(_share(rate_hz) * mean_power) * relative


def _share(rate_hz: float) -> float:
    """How much of the power of white noise is in band."""
    return (BAND_HZ[1] - BAND_HZ[0]) / (rate_hz / 2.0)


def _draw_run(
    plan: PlannedRun, rate_hz: float, seconds: float, seed: int, rng: np.random.Generator
) -> Run:
    """Rounded as the truth file holds them: 0.1 mm and 1e-5 km/h, a hundredth of a degree or two
    of phase on the shortest pitch."""
    speed_kmph = round(plan.speed_kmph * (1.0 + rng.uniform(-0.05, 0.05)), 5)
    start = round(float(rng.uniform(33.0, 41.0)), 4)
    time = np.arange(round(seconds * rate_hz)) / rate_hz
    return Run(plan.track, speed_kmph / 3.6, start, time, _averaging_s(rate_hz), seed=seed)


def _averaging_s(rate_hz: float) -> float:
    return min(AVERAGING_S, 3.0 / rate_hz)


def _write_recording(
    file: Path, time: Array, samples: Array, names: Sequence[str] = CHANNELS
) -> None:
    rows = [
        f"{t:.9g}," + ",".join(f"{a:.5g}" for a in row)
        for t, row in zip(time, samples, strict=True)
    ]
    file.write_text("\n".join(["time_s," + ",".join(names), *rows]) + "\n")


def _campaign_toml(
    name: str,
    planned: list[PlannedRun],
    rate_hz: float,
    noise_rms: float,
    sensors: Sequence[Sensor] = (),
) -> str:
    noise = {KEYS.get(s.quantity, "noise_rms_m_s2"): s.noise_rms for s in sensors}
    lines = [
        "format = 1",
        f'title = "Simulated: {name}"',
        'vehicle = "vehicle.toml"',
        f"sample_rate_hz = {rate_hz}",
        f"band_hz = [{BAND_HZ[0]}, {BAND_HZ[1]}]",
        f"averaging_ms = {1000.0 * _averaging_s(rate_hz):.6g}",
        *(f"{key} = {rms:.3g}" for key, rms in (noise or {"noise_rms_m_s2": noise_rms}).items()),
    ]
    if sensors:
        lines += ["", "[channels]", *(sensor.in_campaign for sensor in sensors)]
    for run in planned:
        lines += [
            "",
            "[[run]]",
            f'id = "{run.id}"',
            f'file = "runs/{run.id}.csv"',
            f'role = "{run.role}"',
            f"speed_kmph = {run.speed_kmph}",
            f'track.kind = "{run.track.kind}"',
            *(f"track.{key} = {_toml(value)}" for key, value in run.track.keys.items()),
        ]
    return "\n".join(lines) + "\n"


def _vehicle_toml(name: str, vehicle: Vehicle) -> str:
    head = ["format = 1", f'name = "{name}"', "relative_uncertainty = 0.10"]
    return "\n".join(head + _tables(vehicle)) + "\n"


def _truth_toml(
    vehicle: Vehicle,
    physics: Sequence[Effect],
    runs: Mapping[str, Run],
    noise: Array,
    noise_rms: float,
    error: _Sums,
) -> str:
    names = [effect.id for effect in physics] or ["none"]
    lines = [
        "format = 1",
        "effects = [" + ", ".join(f'"{name}"' for name in names) + "]",
        'logger = "each sample is the mean acceleration over 6.6 ms centred on time_s, '
        'then white noise and a constant offset"',
        'position = "start_m is the x of the FRONT axle at time_s = 0; '
        'the vehicle has been on the track for 4 s"',
        f"noise_rms_in_band_m_s2 = {noise_rms:.6g}",
        *(error.lines if error.measured > 0.0 else ()),
        "",
        "[effect]",
    ]
    for effect in physics:
        lines += ["", f"[effect.{effect.id}]"]
        lines += [f"{key} = {_toml(value)}" for key, value in asdict(effect).items()]
    lines += _tables({f"vehicle_true.{key}": value for key, value in vehicle.items()})
    for name, run in runs.items():
        lines += ["", f"[run.{name}]", f"speed_kmph = {run.speed_m_s * 3.6:.9g}"]
        lines += [f"start_m = {run.start_m:.9g}", f"seed = {run.seed}"]
    lines += ["", "[noise]"]
    lines += [f"{channel} = {sd:.6g}" for channel, sd in zip(CHANNELS, noise, strict=True)]
    return "\n".join(lines) + "\n"


def _tables(values: Vehicle) -> list[str]:
    """Dotted keys as TOML tables, in the order given."""
    lines: list[str] = []
    open_table = ""
    for dotted, value in values.items():
        table, key = dotted.rsplit(".", 1)
        if table != open_table:
            lines += ["", f"[{table}]"]
            open_table = table
        lines.append(f"{key} = {_toml(value)}")
    return lines


def _toml(value: float | str) -> str:
    return f'"{value}"' if isinstance(value, str) else f"{float(value)!r}"
