"""The same vehicle in MuJoCo, with every effect both simulators know: same accelerations in band.

`tests.truth` shares no code with wheelhop: its own tracks, wheel envelope, integrator and laws.
"""

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, TIME, campaign_of, model_of, relative, simulated
from wheelhop.simulate import RunSimulator

REACHED = 0.002
"""1e-4 for what is linear or smooth, 7e-4 with friction: a fifth of the faintest sensor noise."""

RUNS = {
    "washboard": truth.Run(
        truth.Track("washboard", {"amplitude_mm": 25.0, "pitch_mm": 600.0}), 3.4, 36.2, TIME, seed=3
    ),
    "herringbone": truth.Run(
        truth.Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0, "angle_deg": 20.0}),
        5.1,
        33.7,
        TIME,
        seed=4,
    ),
    "twist": truth.Run(
        truth.Track(
            "chassis-twist",
            {"amplitude_mm": 150.0, "pitch_mm": 2000.0, "lateral_offset_mm": 100.0},
        ),
        4.2,
        40.3,
        TIME,
        seed=5,
    ),
}

STIFFNESS = {end: ATV[f"suspension.{end}.stiffness_N_m"] for end in ("front", "rear")}
DAMPING = {end: ATV[f"suspension.{end}.damping_N_s_m"] for end in ("front", "rear")}
AHEAD = ATV["geometry.cg_to_front_axle_m"] / ATV["geometry.wheelbase_m"]
LOAD = {
    "front": 0.5 * 9.81 * ATV["body.mass_kg"] * (1 - AHEAD),
    "rear": 0.5 * 9.81 * ATV["body.mass_kg"] * AHEAD,
}
HALF_TRACK = ATV["geometry.track_width_m"] / 2

# Our effect, its form and parameters; the same physics in the truth's terms.
CASES = {
    "nothing": ("", "", {}, {}),
    "dry-friction that creeps": (
        "dry-friction",
        "creeping",
        {"front_N": 70.0, "rear_N": 40.0, "creep_m_s": 0.008},
        {"tanh_front_N": 70.0, "tanh_rear_N": 40.0, "creep_m_s": 0.008},
    ),
    "dry-friction": (
        "dry-friction",
        "",
        {"front_N": 75.0, "rear_N": 55.0, "presliding_N_m": 1.5e6},
        {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0},
    ),
    "progressive-spring cubic": (
        "progressive-spring",
        "cubic",
        {"front_N_m3": 4e6, "rear_N_m3": 2e6},
        {"cubic_front_N_m3": 4e6, "cubic_rear_N_m3": 2e6},
    ),
    "progressive-spring air": (
        "progressive-spring",
        "air",
        {f"{end}_1_m": STIFFNESS[end] / (1.3 * LOAD[end]) for end in STIFFNESS},
        {"polytropic_exponent": 1.3},
    ),
    "asymmetric-damper": (
        "asymmetric-damper",
        "",
        {f"{end}_N_s_m": 0.35 * DAMPING[end] for end in DAMPING},
        {"asymmetry": 0.35},
    ),
    "digressive-damper": (
        "digressive-damper",
        "",
        {"front_loss": 0.6, "rear_loss": 0.6, "knee_m_s": 0.15},
        {"knee_m_s": 0.15, "slope_ratio": 0.4},
    ),
    "bump-stop": (
        "bump-stop",
        "compression",
        {"stiffness_N_m": 3e4, "clearance_m": 0.02},
        {"clearance_m": 0.02, "stiffness_N_m": 3e4},
    ),
    "bump-stop both": (
        "bump-stop",
        "both",
        {"stiffness_N_m": 3e4, "clearance_m": 0.016, "rebound_ratio": 1.25},
        {"clearance_m": 0.016, "stiffness_N_m": 3e4, "rebound_clearance_m": 0.02},
    ),
    "backlash": ("backlash", "", {"gap_m": 0.004}, {"gap_m": 0.004}),
    "mount-bushing": (
        "mount-bushing",
        "",
        {"front_m_N": 2e-5, "rear_m_N": 2e-5, "relaxation_s": 0.006},
        {"stiffness_N_m": 5e4, "damping_N_s_m": 300.0},
    ),
    "anti-roll-bar": (
        "anti-roll-bar",
        "",
        {"front_N_m": 3000.0, "rear_N_m": 1000.0},
        {"stiffness_front_N_m": 3000.0, "stiffness_rear_N_m": 1000.0},
    ),
    "tyre-lift-off": ("tyre-lift-off", "", {"lifts": 1.0}, {}),
    "driver-seat": (
        "driver-seat",
        "",
        {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1},
        {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1},
    ),
    "frame-twist": (
        "frame-twist",
        "",
        {
            "participation_1_kg": HALF_TRACK**2 / ATV["body.roll_inertia_kg_m2"],
            "freq_hz": 11.0,
            "zeta": 0.04,
        },
        {"freq_hz": 11.0, "zeta": 0.04},
    ),
    "driver-rocking": (
        "driver-rocking",
        "",
        {"inertia_kg_m2": 5.0, "freq_hz": 2.5, "zeta": 0.25},
        {"roll_inertia_kg_m2": 5.0, "freq_hz": 2.5, "zeta": 0.25},
    ),
    "sensor-skew": ("sensor-skew", "", {"delay_s": 5e-4}, {"skew_s": 5e-4}),
    "sensor-clipping": (
        "sensor-clipping",
        "A2",
        {"clips": 1.0, "limit_m_s2": 8.0},
        {"channel": "A2", "limit_m_s2": 8.0},
    ),
    "sensor-mount": (
        "sensor-mount",
        "A2",
        {"loose": 1.0, "freq_hz": 18.0, "zeta": 0.05},
        {"channel": "A2", "freq_hz": 18.0, "zeta": 0.05},
    ),
    "sensor-mount that rings": (
        "sensor-mount",
        "B2",
        {"loose": 1.0, "freq_hz": 24.5, "zeta": 0.05},
        {"channel": "B2", "freq_hz": 24.5, "zeta": 0.05},
    ),
    "sensor-gain": (
        "sensor-gain",
        "B2",
        {"error": 0.07},
        {"channel": "B2", "gain_error": 0.07},
    ),
    "sensor-polarity inverted": ("sensor-polarity", "A3", {"wrong": 1.0}, {"channel": "A3"}),
    "sensor-polarity swapped": (
        "sensor-polarity",
        "A1/B4",
        {"wrong": 1.0},
        {"channel": "B4", "swapped_with": "A1"},
    ),
}


def driven(run_id, effects):
    return truth.simulate_run(ATV, RUNS[run_id], truth.make_effects(effects))[1]


@pytest.mark.parametrize("run_id", RUNS)
@pytest.mark.parametrize("case", CASES)
def test_accelerations_agree(case, run_id):
    effect, choice, theta, their_theta = CASES[case]
    run = {run_id: RUNS[run_id]}
    measured = driven(run_id, {effect: their_theta} if effect else {})
    model = model_of(ATV, run, effect, theta, choice=choice)
    ours = simulated(campaign_of(run), model)[run_id]
    assert relative(ours, measured) < REACHED


@pytest.mark.parametrize("case", [case for case in CASES if CASES[case][0]])
def test_the_runs_show_what_is_compared(case):
    """On at least one run each effect changes ten times more than the two simulators differ by."""
    effect, choice, theta, _ = CASES[case]
    present = simulated(campaign_of(RUNS), model_of(ATV, RUNS, effect, theta, choice=choice))
    absent = simulated(campaign_of(RUNS), model_of(ATV, RUNS))
    assert max(relative(absent[name], present[name]) for name in RUNS) > 10 * REACHED


def test_an_engine_shakes_the_body_whatever_the_road():
    """Its phase is drawn per run: sin(2πft + φ) is cos·sin φ + sin·cos φ, t counted from the middle
    of what sensors' windows reach."""
    run_id, force_N, frequency = "twist", 80.0, 22.0
    force = force_N / ATV["body.mass_kg"]
    end = RunSimulator(campaign_of(RUNS), campaign_of(RUNS).runs[-1], 4.0).setting.end_s
    phase = 2 * np.pi * frequency * (TIME[0] + end) / 2 + np.random.default_rng(
        RUNS[run_id].seed
    ).uniform(0.0, 2 * np.pi)
    place = {"x_m": ATV["engine.x_m"], "y_m": ATV["engine.y_m"]}
    measured = driven(
        run_id, {"engine-vibration": {"force_N": force_N, "freq_hz": frequency, **place}}
    )
    run = {run_id: RUNS[run_id]}
    own = {"cos_m_s2": force * np.sin(phase), "sin_m_s2": force * np.cos(phase)}
    model = model_of(ATV, run, "engine-vibration", {"freq_hz": frequency}, own=own)
    assert relative(simulated(campaign_of(run), model)[run_id], measured) < REACHED
    still = simulated(campaign_of(run), model_of(ATV, run))[run_id]
    assert relative(still, measured) > 0.05


def test_one_corner_unlike_its_mirror_image():
    """The rear left spring 30 % stiffer: an axle 15 % stiffer in the mean, and 0.3/2.3 of that
    more on the left."""
    run = {"twist": RUNS["twist"]}
    theirs = {"corner": 3.0, "stiffness_change": 0.3, "damping_change": -0.2}
    measured = driven("twist", {"corner-asymmetry": theirs})
    means = dict(ATV)
    means["suspension.rear.stiffness_N_m"] *= 1.15
    means["suspension.rear.damping_N_s_m"] *= 0.9
    theta = {"spring_excess": 0.3 / 2.3, "damper_excess": -0.2 / 1.8}
    unlike = model_of(means, run, "corner-asymmetry", theta, choice="rear")
    assert relative(simulated(campaign_of(run), unlike)["twist"], measured) < REACHED
    alike = simulated(campaign_of(run), model_of(means, run))["twist"]
    assert relative(alike, measured) > 10 * REACHED
