"""Campaigns with one hidden effect at clear strength, and what a diagnosis of them should say."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from tests import truth
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import Baseline, Diagnosis, diagnose, fit_baseline
from wheelhop.effects import Effect, load_effects
from wheelhop.vehicle import read_vehicle

LIBRARY = load_effects()


@dataclass(frozen=True)
class Case:
    """What is hidden, in the simulator's words, and the verdict's parameters it stands for, in runs
    of so many seconds."""

    hidden: Mapping[str, Mapping[str, float | str]]
    parameters: Mapping[str, float | str] = field(default_factory=dict)
    seed: int = 101
    seconds: float = 4.8

    @property
    def verdict(self) -> tuple[str, ...]:
        return tuple(self.hidden) or ("none",)


FRICTION = {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}
ROCKING = {"freq_hz": 2.4, "zeta": 0.25}
MOUNT = {"freq_hz": 24.0, "zeta": 0.08}
SEAT = {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1}
ENGINE = {"force_N": 60.0, "freq_hz": 22.0, "x_m": -0.45}
CASES = {
    "clean": Case({}),
    "speed-fluctuation": Case({"speed-fluctuation": {"fraction": 0.04}}),
    "left-right-drift": Case(  # it grows with the way
        {"left-right-drift": {"rate": 0.004}}, {"relative_rate": 0.004}, seconds=10.24
    ),
    "tyre-envelope": Case(
        {"tyre-envelope": {"front_m": 0.06, "rear_m": 0.08}},
        {"form": "path", "front_m": 0.06, "rear_m": 0.08},
    ),
    "progressive-tyre": Case(
        {"progressive-tyre": {"growth_per_m": 4.0}},
        {"form": "quadratic", "front_1_m": 4.0, "rear_1_m": 4.0},
    ),
    "small-scale-roughness": Case(
        {"small-scale-roughness": {"unevenness_m3": 3e-8}}, {"waviness": 2.0}
    ),
    "tyre-lift-off": Case({"tyre-lift-off": {}}, {"lifts": 1.0}),
    "wheel-imbalance": Case(
        {"wheel-imbalance": {"imbalance_kg_m": 0.2, "corner": 3.0}},
        {"form": "rear_left", "rear_left_kg_m": 0.2, "rear_m": 0.279},
    ),
    "progressive-spring air": Case(
        {"progressive-spring": {"polytropic_exponent": 1.3}}, {"form": "air"}
    ),
    "progressive-spring cubic": Case(
        {"progressive-spring": {"cubic_front_N_m3": 4e6, "cubic_rear_N_m3": 2.5e6}},
        {"form": "cubic", "front_N_m3": 4e6, "rear_N_m3": 2.5e6},
    ),
    "bump-stop": Case(
        {"bump-stop": {"clearance_m": 0.02, "stiffness_N_m": 3e4}},
        {"form": "compression", "stiffness_N_m": 3e4, "clearance_m": 0.02},
    ),
    "asymmetric-damper": Case({"asymmetric-damper": {"asymmetry": 0.35}}),
    "digressive-damper": Case(
        {"digressive-damper": {"knee_m_s": 0.15, "slope_ratio": 0.4}},
        {"front_loss": 0.6, "rear_loss": 0.6, "knee_m_s": 0.15},
    ),
    "dry-friction": Case({"dry-friction": FRICTION}, {"front_N": 75.0, "rear_N": 55.0}),
    "mount-bushing": Case(
        {"mount-bushing": {"stiffness_N_m": 1e5, "damping_N_s_m": 200.0}},
        {"front_m_N": 1e-5, "rear_m_N": 1e-5, "relaxation_s": 0.002},
    ),
    "anti-roll-bar": Case(
        {"anti-roll-bar": {"stiffness_front_N_m": 2000.0, "stiffness_rear_N_m": 1000.0}},
        {"front_N_m": 2000.0, "rear_N_m": 1000.0},
    ),
    "corner-asymmetry": Case(
        {"corner-asymmetry": {"corner": 3.0, "stiffness_change": 0.2, "damping_change": -0.2}},
        {"form": "rear", "spring_excess": 0.2 / 2.2, "damper_excess": -0.2 / 1.8},
    ),
    "driver-seat": Case({"driver-seat": SEAT}, SEAT),
    "engine-vibration": Case({"engine-vibration": ENGINE}, {"force_N": 60.0, "freq_hz": 22.0}),
    "frame-twist": Case(
        {"frame-twist": {"freq_hz": 11.0, "zeta": 0.04}}, {"freq_hz": 11.0, "zeta": 0.04}
    ),
    "driver-rocking": Case(
        {"driver-rocking": {"roll_inertia_kg_m2": 6.0, **ROCKING}},
        {"inertia_kg_m2": 6.0, **ROCKING},
    ),
    "longitudinal-pitch": Case({"longitudinal-pitch": {"peak_m_s2": 3.0}}),
    "cornering-roll": Case({"cornering-roll": {"peak_m_s2": 2.0}}),
    "sensor-gain": Case(
        {"sensor-gain": {"channel": "B2", "gain_error": 0.08}}, {"form": "B2", "error": 0.08}
    ),
    "sensor-polarity": Case({"sensor-polarity": {"channel": "B3"}}, {"form": "B3"}),
    "sensor-polarity swapped": Case(
        {"sensor-polarity": {"channel": "A1", "swapped_with": "A2"}}, {"form": "A1/A2"}
    ),
    "sensor-skew": Case({"sensor-skew": {"skew_s": 4e-4}}, {"delay_s": 4e-4}),
    "sensor-clipping": Case(
        {"sensor-clipping": {"channel": "A2", "limit_m_s2": 12.0}},
        {"form": "A2", "limit_m_s2": 12.0},
    ),
    "sensor-mount": Case({"sensor-mount": {"channel": "B3", **MOUNT}}, {"form": "B3", **MOUNT}),
}


def short_campaign(case: Case, folder: Path, **more: object) -> Path:
    """Eight short runs of a case, quickly made."""
    settings = {"short": True, "draft": True, "seconds": case.seconds, **more}
    return truth.make_campaign(folder, seed=case.seed, effects=case.hidden, **settings)


def diagnosed(folder: Path, effects: Mapping[str, Effect] = LIBRARY) -> Diagnosis:
    """The diagnosis of a campaign folder; one thread, as tests run beside each other."""
    campaign = read_campaign(folder)
    return diagnose(campaign, read_vehicle(campaign.vehicle_file), effects, jobs=1)


def baseline_of(folder: Path) -> Baseline:
    """The fitted baseline of a campaign folder, in silence, on one thread."""
    campaign = read_campaign(folder)
    vehicle = read_vehicle(campaign.vehicle_file)
    return fit_baseline(campaign, vehicle, jobs=1, progress=lambda text: None)


def oracle_of(truth_file: Path) -> float:
    """Error on the validate runs that the noise alone leaves."""
    return float(tomllib.loads(truth_file.read_text())["oracle_rel_validate"])


def found_in(diagnosis: Diagnosis, effect: str) -> dict[str, float | str]:
    """The effect's parameters on the last rung, and in which of its forms it was taken."""
    prefix, last = f"{effect}.", diagnosis.ladder[-1]
    found = {k[len(prefix) :]: v for k, (v, _) in last.parameters.items() if k.startswith(prefix)}
    ranked = next(r for r in diagnosis.ranking if r.effect == effect)
    return {**ranked.parameters, **found}
