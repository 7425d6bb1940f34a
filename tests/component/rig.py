"""Component campaigns from a rig that shares no code with wheelhop: fine steps, laws of its own.

Every law is called once per step in time order with the extension x and its rate v; it returns the
force that replaces the linear k x + c v. Memories advance by the step, in formulations other than
the host's: friction as the stretch of a limited spring, a gap as the place of the node behind it,
a mount by the trapezoidal rule.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from tests.component import dampers, hysteresis

RATE_HZ = 256.0
FINE = 32  # steps per sample
STEP_S = 1.0 / (RATE_HZ * FINE)
BAND_HZ = (0.4, 60.0)

Law = Callable[[float, float], float]


@dataclass(frozen=True)
class Component:
    """A linear component and what is hidden in it; one law serves one run."""

    mass_kg: float = 0.0
    stiffness_N_m: float = 20000.0
    damping_N_s_m: float = 1500.0
    hidden: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)

    def law(self) -> Law:
        k, c = self.stiffness_N_m, self.damping_N_s_m
        return HIDDEN[self.hidden](k, c, **self.numbers) if self.hidden else linear(k, c)


def linear(k: float, c: float) -> Law:
    return lambda x, v: k * x + c * v


def cubic_spring(k: float, c: float, cubic_N_m3: float, quintic_N_m5: float = 0.0) -> Law:
    return lambda x, v: k * x + cubic_N_m3 * x**3 + quintic_N_m5 * x**5 + c * v


def air_spring(k: float, c: float, load_N: float, exponent: float = 1.3) -> Law:
    """The whole stiffness is gas: pressure times area over a column of height n F0 / k."""
    height = exponent * load_N / k
    return lambda x, v: load_N - load_N * (height / (height + x)) ** exponent + c * v


def bump_stop(k: float, c: float, clearance_m: float, stop_N_m: float) -> Law:
    return lambda x, v: k * x + c * v - stop_N_m * max(-x - clearance_m, 0.0)


def asymmetric_damper(k: float, c: float, asymmetry: float) -> Law:
    return lambda x, v: k * x + c * v * (1 + asymmetry if v > 0 else 1 - asymmetry)


def digressive_damper(k: float, c: float, knee_m_s: float, slope_ratio: float) -> Law:
    def force(x: float, v: float) -> float:
        slow = min(max(v, -knee_m_s), knee_m_s)
        return k * x + c * slow + slope_ratio * c * (v - slow)

    return force


def dry_friction(k: float, c: float, coulomb_N: float, joint_N_m: float) -> Law:
    limit, stretch, last = coulomb_N / joint_N_m, 0.0, None

    def force(x: float, v: float) -> float:
        nonlocal stretch, last
        stretch += 0.0 if last is None else x - last
        stretch, last = min(max(stretch, -limit), limit), x
        return k * x + c * v + joint_N_m * stretch

    return force


def backlash(k: float, c: float, gap_m: float) -> Law:
    """A massless node between gap and strut, y: k y + c y' = 0 while the gap is open, about its
    middle."""
    node = 0.0

    def force(x: float, v: float) -> float:
        nonlocal node
        free = node * np.exp(-k / c * STEP_S)
        node = min(max(free, x - gap_m / 2), x + gap_m / 2)
        if node == free:
            return 0.0
        own = k * node + c * v
        return max(own, 0.0) if node < x else min(own, 0.0)

    return force


def mount_bushing(k: float, c: float, mount_N_m: float, mount_N_s_m: float) -> Law:
    """Two Kelvin–Voigt elements in series: k (x − u) + c (v − u') = k_m u + c_m u'."""
    give, rate = 0.0, 0.0

    def force(x: float, v: float) -> float:
        nonlocal give, rate
        half = STEP_S / 2
        ahead = give + half * rate
        stiffness, damping = k + mount_N_m, c + mount_N_s_m
        rate = (k * x + c * v - stiffness * ahead) / (damping + stiffness * half)
        give = ahead + half * rate
        return mount_N_m * give + mount_N_s_m * rate

    return force


def quadratic_damper(k: float, c: float, quadratic_N_s2_m2: float) -> Law:
    return lambda x, v: k * x + c * v + quadratic_N_s2_m2 * v * abs(v)


def choking_damper(k: float, c: float, quadratic_N_s2_m2: float) -> Law:
    """In nobody's library: an orifice that the oil passes in compression alone."""
    return lambda x, v: k * x + c * v - quadratic_N_s2_m2 * min(v, 0.0) ** 2


def bypass_damper(k: float, c: float, share: float, travel_m: float) -> Law:
    """In nobody's library: ports shut as the piston travels."""
    return lambda x, v: k * x + c * v * (1.0 + share * (x / travel_m) ** 2)


HIDDEN = {
    law.__name__.replace("_", "-"): law
    for law in (
        *(cubic_spring, air_spring, bump_stop, asymmetric_damper, digressive_damper),
        *(dry_friction, backlash, mount_bushing, quadratic_damper),
        *(choking_damper, bypass_damper),
        *(hysteresis.lugre, hysteresis.bouc_wen, hysteresis.friction_with_play),
        *(hysteresis.mr_damper, hysteresis.payne_effect),
        *(dampers.compliant_damper, dampers.hardening, dampers.stribeck, dampers.seal),
    )
}


def forces(component: Component, x: np.ndarray) -> np.ndarray:
    """Force at every sample for a displacement given at every fine step."""
    law = component.law()
    v, a = np.gradient(x, STEP_S), np.gradient(np.gradient(x, STEP_S), STEP_S)
    total = [law(*pair) for pair in zip(x.tolist(), v.tolist(), strict=True)]
    return (np.array(total) + component.mass_kg * a)[::FINE]


def displacements(
    component: Component, force: np.ndarray, x: float = 0.0, v: float = 0.0
) -> np.ndarray:
    """Displacement at every sample for a force given at every fine step (velocity Verlet)."""
    law, mass, out = component.law(), component.mass_kg, np.empty(len(force))
    pull = force.tolist()
    acceleration = (pull[0] - law(x, v)) / mass
    for t in range(len(force)):
        out[t] = x
        x += STEP_S * v + 0.5 * STEP_S**2 * acceleration
        ahead = v + STEP_S * acceleration
        last, acceleration = acceleration, (pull[min(t + 1, len(pull) - 1)] - law(x, ahead)) / mass
        v += 0.5 * STEP_S * (last + acceleration)
    return out[::FINE]


def fine_time(duration_s: float) -> np.ndarray:
    return np.arange(round(duration_s * RATE_HZ - 1) * FINE + 1) * STEP_S


def multisine(
    time_s: np.ndarray, rms: float, band_hz: tuple[float, float], seed: int
) -> np.ndarray:
    """Equal amplitudes at random frequencies and phases, faded in over a second."""
    rng = np.random.default_rng(seed)
    frequency, phase = rng.uniform(*band_hz, 24), rng.uniform(0, 2 * np.pi, 24)
    waves = np.sin(2 * np.pi * np.outer(time_s, frequency) + phase).sum(axis=1)
    return rms * np.sqrt(2 / 24) * waves * np.minimum(time_s, 1.0)


def displacement_runs(
    component: Component, seed: int, seconds: float
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Displacement and force at the samples, by run id: sines and noise of three sizes."""
    time_s = fine_time(seconds)
    fade = np.minimum(time_s, 1.0) ** 2
    imposed = {
        f"sine-{frequency:g}hz-{amplitude:g}mm": 1e-3
        * amplitude
        * np.sin(2 * np.pi * frequency * time_s)
        * fade
        for frequency, amplitude in ((0.6, 20), (1.7, 8), (1.7, 20), (4.3, 8), (8.1, 3))
    }
    imposed |= {
        f"random-{rms:g}mm": multisine(time_s, 1e-3 * rms, (0.5, 12.0), seed + i)
        for i, rms in enumerate((3, 6, 9))
    }
    return {name: (x[::FINE], forces(component, x)) for name, x in imposed.items()}


def force_runs(
    component: Component, seed: int, seconds: float
) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """The same for an imposed force: noise of several sizes, and two free decays."""
    time_s = fine_time(seconds)
    found = {}
    for i, rms in enumerate((30, 80, 150, 150, 250)):
        force = multisine(time_s, rms, (0.5, 25.0), seed + i)
        found[f"random-{rms:g}N-{i}"] = (displacements(component, force), force[::FINE])
    for x, v in ((0.02, 0.0), (-0.012, 0.5)):
        force = np.zeros(len(time_s))
        found[f"decay-{1e3 * x:g}mm"] = (displacements(component, force, x, v), force[::FINE])
    return found


HELD_OUT = ("sine-1.7hz-20mm", "random-6mm", "random-150N-3", "decay--12mm")


def make_campaign(
    folder: Path,
    drive: str,
    component: Component,
    *,
    seed: int,
    noise: float,
    nominal: str = "",
    only: str = "",
    seconds: float = 5.0,
) -> Path:
    """Write a campaign of runs of so many seconds; `noise` is that of the measured output, over its
    rms in all runs; `only` those whose id holds a word."""
    runs = {"displacement": displacement_runs, "force": force_runs}[drive](component, seed, seconds)
    runs = {name: pair for name, pair in runs.items() if only in name}
    output = 1 if drive == "displacement" else 0
    rng = np.random.default_rng(seed + 1000)
    level = noise * float(np.sqrt(np.mean([np.var(pair[output]) for pair in runs.values()])))
    in_band = level * np.sqrt((BAND_HZ[1] - BAND_HZ[0]) / (RATE_HZ / 2))
    unit = "N" if drive == "displacement" else "m"
    (folder / "runs").mkdir(parents=True)
    lines = [
        "format = 1",
        'kind = "component"',
        f'title = "component, {drive} imposed"',
        f"sample_rate_hz = {RATE_HZ}",
        f"band_hz = [{BAND_HZ[0]}, {BAND_HZ[1]}]",
        f'drive = "{drive}"',
        f"noise_rms_{unit} = {in_band:.6g}",
        "[component]",
        nominal or _nominal(component, rng),
        "relative_uncertainty = 0.3",
    ]
    for name, pair in runs.items():
        columns = [np.arange(len(pair[0])) / RATE_HZ, *pair]
        columns[1 + output] = columns[1 + output] + rng.normal(0.0, level, len(pair[0])) + 3 * level
        np.savetxt(
            folder / "runs" / f"{name}.csv",
            np.stack(columns, axis=1),
            fmt=("%.6f", "%.9g", "%.9g"),
            delimiter=",",
            header="time_s,displacement_m,force_N",
            comments="",
        )
        role = "validate" if name in HELD_OUT else "fit"
        lines += ["[[run]]", f'id = "{name}"', f'file = "runs/{name}.csv"', f'role = "{role}"']
    (folder / "campaign.toml").write_text("\n".join(lines) + "\n")
    return folder


def _nominal(component: Component, rng: np.random.Generator) -> str:
    """Numbers a fifth off, as believed before any test; no mass where there is none."""
    values = {
        "mass_kg": component.mass_kg,
        "stiffness_N_m": component.stiffness_N_m,
        "damping_N_s_m": component.damping_N_s_m,
    }
    return "\n".join(f"{k} = {v * rng.uniform(0.8, 1.2):.6g}" for k, v in values.items())
