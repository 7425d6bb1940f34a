"""Every law of the suspension hidden in a component, and what a diagnosis should call it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from tests.component.rig import Component
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import Diagnosis, diagnose
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_nominal

LIBRARY = load_effects()
DAMPER = Component()
"""On a rig that imposes displacement: nothing of it moves but what is measured."""

OSCILLATOR = Component(mass_kg=5.0, damping_N_s_m=120.0)
"""On a rig that imposes a force: 10 Hz, a tenth of critical damping."""


@dataclass(frozen=True)
class Case:
    """A law of `rig.HIDDEN` with its numbers for either drive; the effect it is, in which form, and
    the effect's parameters that are known from them."""

    hidden: str
    numbers: Mapping[str, Mapping[str, float]]
    effect: str
    form: str = ""
    parameters: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    def component(self, drive: str) -> Component:
        base = DAMPER if drive == "displacement" else OSCILLATOR
        return replace(base, hidden=self.hidden, numbers=self.numbers[drive])


def either(**numbers: float) -> dict[str, dict[str, float]]:
    """The same numbers whatever the rig imposes."""
    return {"displacement": numbers, "force": numbers}


AIR_N = 900.0
CASES = {
    "cubic": Case(
        "cubic-spring",
        either(cubic_N_m3=3e7),
        "progressive-spring",
        "cubic",
        either(strut_N_m3=3e7),
    ),
    "air": Case(
        "air-spring",
        either(load_N=AIR_N),
        "progressive-spring",
        "air",
        either(strut_N=AIR_N, strut_1_m=20000.0 / (1.3 * AIR_N)),
    ),
    "bump-stop": Case(
        "bump-stop",
        either(clearance_m=0.010, stop_N_m=40000.0),
        "bump-stop",
        "compression",
        either(stiffness_N_m=40000.0, clearance_m=0.010),
    ),
    "asymmetric-damper": Case(
        "asymmetric-damper",
        either(asymmetry=0.35),
        "asymmetric-damper",
        "",
        {"displacement": {"strut_N_s_m": 525.0}, "force": {"strut_N_s_m": 42.0}},
    ),
    "digressive-damper": Case(
        "digressive-damper",
        {
            "displacement": {"knee_m_s": 0.1, "slope_ratio": 0.4},
            "force": {"knee_m_s": 0.2, "slope_ratio": 0.4},
        },
        "digressive-damper",
        "",
        {
            "displacement": {"strut_loss": 0.6, "knee_m_s": 0.1},
            "force": {"strut_loss": 0.6, "knee_m_s": 0.2},
        },
    ),
    "dry-friction": Case(
        "dry-friction",
        {
            "displacement": {"coulomb_N": 40.0, "joint_N_m": 8e5},
            "force": {"coulomb_N": 15.0, "joint_N_m": 4e5},
        },
        "dry-friction",
        "",
        {
            "displacement": {"strut_N": 40.0, "presliding_N_m": 8e5},
            "force": {"strut_N": 15.0, "presliding_N_m": 4e5},
        },
    ),
    "backlash": Case(
        "backlash",
        {"displacement": {"gap_m": 0.002}, "force": {"gap_m": 0.001}},
        "backlash",
        "",
        {"displacement": {"gap_m": 0.002, "middle_m": 0.0}, "force": {"gap_m": 0.001}},
    ),
    "mount-bushing": Case(
        "mount-bushing",
        either(mount_N_m=60000.0, mount_N_s_m=150.0),
        "mount-bushing",
        "",
        either(strut_m_N=1 / 60000.0, relaxation_s=0.0025),
    ),
}

RIG_ONLY = {
    "sticking": Case(
        "lugre",
        either(coulomb_N=60.0, joint_N_m=2e5, sticking=1.6, stribeck_m_s=0.02),
        "dry-friction",
        "sticking",
        either(strut_N=60.0, presliding_N_m=2e5, sticking=1.6, stribeck_m_s=0.02),
    ),
    "smooth": Case(
        "bouc-wen",
        either(force_N=80.0, yield_m=0.003, shape=0.7),
        "dry-friction",
        "smooth",
        either(strut_N=80.0, yield_m=0.003, roundness=0.7),
    ),
    "falling": Case(
        "stribeck",
        either(coulomb_N=60.0, sticking=1.6, stribeck_m_s=0.03, creep_m_s=0.001),
        "dry-friction",
        "falling",
        either(strut_N=60.0, creep_m_s=0.001, sticking=1.6, stribeck_m_s=0.03),
    ),
    "friction-with-play": Case(
        "friction-with-play",
        either(coulomb_N=60.0, joint_N_m=1e5, gap_m=0.003),
        "friction-with-play",
        "",
        either(strut_N=60.0, presliding_N_m=1e5, gap_m=0.003),
    ),
    "mr-damper": Case(
        "mr-damper",
        either(yield_N=100.0, yield_m=0.001, creep_m_s=0.03),
        "mr-damper",
        "",
        either(strut_N=100.0, yield_m=0.001, creep_m_s=0.03),
    ),
    "quadratic-damper": Case(
        "quadratic-damper",
        either(quadratic_N_s2_m2=1500.0),
        "quadratic-damper",
        "",
        either(strut_N_s2_m2=1500.0),
    ),
    "valves": Case(
        "compliant-damper",
        either(lag_s=0.005, asymmetry=0.2, opening_N=60.0, bleed=0.15),
        "compliant-damper",
        "valve",
        either(strut_s=0.005, strut_asymmetry=0.2, strut_opening_N=60.0, bleed=0.15),
    ),
    "blow-off": Case(
        "compliant-damper",
        either(lag_s=0.005, asymmetry=-0.2, opening_N=40.0, bleed=0.2, loss=0.6, blow_off_N=200.0),
        "compliant-damper",
        "blow-off",
        either(
            strut_s=0.005,
            strut_asymmetry=-0.2,
            strut_opening_N=40.0,
            bleed=0.2,
            loss=0.6,
            blow_off_N=200.0,
        ),
    ),
    "hardening": Case(
        "hardening",
        either(alpha_N_m=8000.0, beta_1_m=125.0, gamma=0.8, delta=-1.1),
        "smooth-hysteresis",
        "",
        either(strut_N=40.0, way_m=0.005, softening=-0.1875),
    ),
    "payne-effect": Case(
        "payne-effect",
        either(force_N=100.0, half_way_m=0.002),
        "payne-effect",
        "",
        either(strut_N=100.0, half_way_m=0.002),
    ),
}
"""Laws that only a rig tells from their likes, where displacement is imposed."""


def diagnosed(folder: Path) -> Diagnosis:
    """The diagnosis of a campaign folder; one thread, as tests run beside each other."""
    campaign = read_campaign(folder)
    return diagnose(campaign, read_nominal(campaign), LIBRARY, jobs=1)
