"""Machines of other laws than the library's (`tests/truth`), by the names they should be called."""

from __future__ import annotations

from collections.abc import Mapping

from tests.diagnose.cases import LIBRARY
from wheelhop.effects import Effect

Hidden = Mapping[str, float | str]

MACHINES: dict[str, Hidden] = {
    "dry-friction": {"tanh_front_N": 0.0, "tanh_rear_N": 70.0, "creep_m_s": 0.005},
    "sensor-mount": {"channel": "B2", "freq_hz": 24.5, "zeta": 0.05, "struck_m_s": 0.1},
    "sensor-gain": {"channel": "B2", "gain_error": 0.08, "drift": 0.01},
    "engine-vibration": {
        "force_N": 120.0,
        "freq_hz": 11.0,
        "run_spread_hz": 0.5,
        "wander_hz": 0.16,
        "x_m": -0.45,
    },
}
"""Told from their rivals to the noise."""

FURTHER: dict[str, Hidden] = {
    "speed-fluctuation": {"dip": 0.04},
    "tyre-envelope": {"front_m": 0.06, "rear_m": 0.08, "pressed": 1.0},
    "small-scale-roughness": {"unevenness_m3": 3e-8, "patch_m": 9.0},
    "tyre-lift-off": {"bend_N": 60.0},
    "wheel-imbalance": {"imbalance_kg_m": 0.2, "corner": 3.0, "runout_m": 5e-4},
    "progressive-spring": {"polytropic_exponent": 1.35, "cooling_s": 3.0},
    "bump-stop": {"clearance_m": 0.02, "stiffness_N_m": 3e4, "onset_m": 0.01},
    "asymmetric-damper": {"asymmetry": 0.35, "round_m_s": 0.03},
    "digressive-damper": {"knee_m_s": 0.15, "slope_ratio": 0.4, "lead": 0.3},
    "mount-bushing": {"stiffness_N_m": 1e5, "damping_N_s_m": 200.0, "payne": 0.5},
    "anti-roll-bar": {
        "stiffness_front_N_m": 2000.0,
        "stiffness_rear_N_m": 1000.0,
        "rubbing_N": 15.0,
    },
    "corner-asymmetry": {
        "corner": 3.0,
        "stiffness_change": 0.2,
        "damping_change": -0.2,
        "rubbing_N": 15.0,
    },
    "driver-seat": {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1, "upper": 0.4},
    "progressive-tyre": {"power": 1.25},
    "driver-rocking": {"roll_inertia_kg_m2": 6.0, "freq_hz": 2.4, "zeta": 0.25, "upper": 0.3},
    "cornering-roll": {"peak_m_s2": 2.0, "direct": 0.3},
    "left-right-drift": {"slip_m": 0.06},
    "frame-twist": {"freq_hz": 11.0, "zeta": 0.04, "bending_hz": 24.0},
    "sensor-clipping": {"channel": "A2", "limit_m_s2": 12.0, "offset_m_s2": 0.8},
}
"""Called by their names first; what their laws leave may be said to be unknown."""


def rivals(name: str) -> dict[str, Effect]:
    """The effects of the same place, which are the ones that resemble it."""
    return {k: e for k, e in LIBRARY.items() if e.place == LIBRARY[name].place}
