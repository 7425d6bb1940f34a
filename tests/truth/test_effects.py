"""The force laws of the independent simulator against closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.truth import Run, Track, integrate, make_effect, make_effects, simulate_run
from tests.truth.closed_form import ATV, Push, matrices, relative, travel_vectors
from tests.truth.model import Drive
from tests.truth.vehicle import suspension_static_load

HERRINGBONE = Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0, "angle_deg": 20.0})
TWIST = Track("chassis-twist", {"amplitude_mm": 40.0, "pitch_mm": 2000.0})
TIME = np.arange(200) / 100.0

SEAT = {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": 0.3, "y_m": -0.2}
ROCKING = {"roll_inertia_kg_m2": 5.0, "freq_hz": 4.0, "zeta": 0.2}
FRAME = {"freq_hz": 9.0, "zeta": 0.05}
MOUNT = {"stiffness_N_m": 5e4, "damping_N_s_m": 300.0}
BAR = {"stiffness_front_N_m": 3000.0, "stiffness_rear_N_m": 1000.0}
CORNER = {"corner": 3.0, "stiffness_change": 0.3, "damping_change": -0.2}


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("driver-seat", SEAT),
        ("driver-rocking", ROCKING),
        ("frame-twist", FRAME),
        ("mount-bushing", MOUNT),
        ("anti-roll-bar", BAR),
        ("corner-asymmetry", CORNER),
    ],
)
def test_linear_effects_respond_like_their_dynamic_stiffness(
    name: str, parameters: dict[str, float]
) -> None:
    """The body is shaken harmonically near B1; accelerations against a matrix written here."""
    frequency, (x, y) = 6.0, (0.7, 0.4)
    run = Run(Track("flat"), 1.0, 0.0, TIME, averaging_s=0.0)
    effects = [make_effect(name, dict(parameters)), Push(x, y, 1000.0, frequency)]
    found = simulate_run(ATV, run, effects)[1]

    omega = 2.0 * np.pi * frequency
    outputs = np.zeros((8, 8))
    outputs[:4, :3], outputs[4:, 3:7] = -travel_vectors(ATV)[:, :3], np.eye(4)
    outputs[:4, 7] = [1.0, -1.0, -1.0, 1.0]
    push = np.array([1.0, -x, y, 0.0, 0.0, 0.0, 0.0, 0.0])
    q = np.linalg.solve(dynamic_stiffness(name, parameters, omega), 1000.0 * push)
    wave = np.exp(1j * omega * run.time_s)
    assert relative(found, np.real(np.outer(wave, -(omega**2) * outputs @ q))) < 2e-3


def dynamic_stiffness(name: str, parameters: dict[str, float], omega: float) -> np.ndarray:
    """K + i w C - w^2 M with the effect (8, 8); the eighth coordinate is the frame's twist."""
    mass, damping, stiffness = matrices(ATV)
    whole = np.zeros((8, 8), dtype=complex)
    whole[:7, :7] = stiffness + 1j * omega * damping - omega**2 * mass
    whole[7, 7] = 1.0
    travel = np.hstack([travel_vectors(ATV), np.zeros((4, 1))])
    axles = ("front", "front", "rear", "rear")
    strut = np.array(
        [
            ATV[f"suspension.{axle}.stiffness_N_m"]
            + 1j * omega * ATV[f"suspension.{axle}.damping_N_s_m"]
            for axle in axles
        ]
    )

    def replace_struts(new_travel: np.ndarray, new_strut: np.ndarray) -> None:
        whole[:] += (new_travel.T * new_strut) @ new_travel - (travel.T * strut) @ travel

    match name:
        case "driver-seat" | "driver-rocking":
            place = np.zeros(8)
            if name == "driver-seat":
                inertia, place[:3] = parameters["mass_kg"], [1.0, -0.3, -0.2]
            else:
                inertia, place[2] = parameters["roll_inertia_kg_m2"], 1.0
            own = 2.0 * np.pi * parameters["freq_hz"]
            spring = inertia * (own**2 + 2j * parameters["zeta"] * own * omega)
            carried = -(omega**2) * inertia * spring / (spring - omega**2 * inertia)
            whole += (carried + omega**2 * inertia) * np.outer(place, place)
        case "frame-twist":
            modal_mass = ATV["body.roll_inertia_kg_m2"] / (ATV["geometry.track_width_m"] / 2) ** 2
            own = 2.0 * np.pi * parameters["freq_hz"]
            whole[7, 7] = modal_mass * (own**2 + 2j * parameters["zeta"] * own * omega - omega**2)
            twisted = travel.copy()
            twisted[:, 7] = [-1.0, 1.0, 1.0, -1.0]
            replace_struts(twisted, strut)
        case "mount-bushing":
            mount = parameters["stiffness_N_m"] + 1j * omega * parameters["damping_N_s_m"]
            replace_struts(travel, mount * strut / (mount + strut))
        case "anti-roll-bar":
            for axle, left in (("front", 0), ("rear", 2)):
                roll = travel[left] - travel[left + 1]
                whole += parameters[f"stiffness_{axle}_N_m"] * np.outer(roll, roll)
        case "corner-asymmetry":
            changed = strut.copy()
            changed[2] = 1.3 * strut[2].real + 0.8j * strut[2].imag
            replace_struts(travel, changed)
    return whole


NEARLY_ABSENT = [
    ("speed-fluctuation", {"fraction": 1e-7}),
    ("left-right-drift", {"rate": 1e-7}),
    ("progressive-tyre", {"growth_per_m": 1e-3}),
    ("wheel-imbalance", {"imbalance_kg_m": 0.0}),
    ("progressive-spring", {"cubic_front_N_m3": 1.0, "cubic_rear_N_m3": 1.0}),
    ("asymmetric-damper", {"asymmetry": 1e-5}),
    ("digressive-damper", {"knee_m_s": 0.01, "slope_ratio": 0.9999}),
    ("bump-stop", {"clearance_m": 1.0, "stiffness_N_m": 1e5}),
    ("dry-friction", {"coulomb_front_N": 1e-3, "coulomb_rear_N": 1e-3}),
    ("backlash", {"gap_m": 1e-9}),
    ("mount-bushing", {"stiffness_N_m": 1e9, "damping_N_s_m": 1e5}),
    ("corner-asymmetry", {"corner": 3.0}),
    ("driver-seat", {"mass_kg": 70.0, "freq_hz": 150.0, "zeta": 0.5, "x_m": 0.3, "y_m": -0.2}),
    ("driver-rocking", {"roll_inertia_kg_m2": 5.0, "freq_hz": 150.0, "zeta": 0.5}),
    ("frame-twist", {"freq_hz": 150.0, "zeta": 0.5}),
    ("engine-vibration", {"force_N": 0.0, "freq_hz": 20.0, "x_m": 0.0}),
    ("sensor-gain", {"channel": "B1", "gain_error": 0.0}),
    ("sensor-clipping", {"limit_m_s2": 1e3}),
    ("sensor-skew", {"skew_s": 0.0}),
]


@pytest.fixture(scope="module")
def twisting() -> Run:
    """Little enough motion that no tyre lifts and no strut runs out of static load."""
    return Run(TWIST, 4.0, 40.0, TIME[:100])


@pytest.fixture(scope="module")
def baseline(twisting: Run) -> np.ndarray:
    return simulate_run(ATV, twisting)[1]


@pytest.mark.parametrize(("name", "parameters"), NEARLY_ABSENT, ids=[n for n, _ in NEARLY_ABSENT])
def test_an_effect_at_its_vanishing_limit_leaves_the_baseline(
    name: str, parameters: dict[str, float | str], twisting: Run, baseline: np.ndarray
) -> None:
    """A seat, frame or mount too stiff to move, a stop never reached, a gain of one…

    A locked seat gives back the whole car only if the driver's mass, first moment and inertia were
    all taken from the body.
    """
    changed = simulate_run(ATV, twisting, [make_effect(name, parameters)])[1]
    assert relative(changed, baseline) < 1e-3


def test_forces_obey_their_laws() -> None:
    run = Run(HERRINGBONE, 19.0 / 3.6, 35.0, TIME)
    weight = 9.81 * (ATV["body.mass_kg"] + 2.0 * (15.0 + 12.5))
    lifting = integrate(ATV, run, make_effects({"tyre-lift-off": {}})).tyre_force
    assert lifting.min(axis=0) @ np.ones(4) == pytest.approx(-weight)  # all four reach zero load

    steady = Run(TWIST, 4.0, 40.0, TIME)
    bar = {"stiffness_front_N_m": 5000.0, "stiffness_rear_N_m": 5000.0}
    washboard = Track("washboard", {"amplitude_mm": 5.0, "pitch_mm": 800.0})
    bar_effect = make_effects({"anti-roll-bar": bar})
    pitching = replace(steady, track=washboard)
    level = simulate_run(ATV, pitching, bar_effect)[1]
    assert relative(level, simulate_run(ATV, pitching)[1]) < 1e-9
    stiffer = simulate_run(ATV, steady, bar_effect)[1]
    assert relative(stiffer, simulate_run(ATV, steady)[1]) > 0.05


def a_drive() -> Drive:
    time = np.linspace(-4.0, 996.0, 100001)
    path = np.column_stack([40.0 + 5.0 * time, 40.0 + 5.0 * time])
    none = np.zeros(4)
    return Drive(ATV, time, path, 5.0, np.random.default_rng(2), none, none, none, none)


def test_speed_stays_within_its_fraction_and_starts_where_told() -> None:
    drive = a_drive()
    make_effect("speed-fluctuation", {"fraction": 0.04}).steer(drive)
    deviation = np.gradient(drive.path, drive.time, axis=0) / 5.0 - 1.0
    assert 0.03 < np.abs(deviation).max() < 0.0401
    assert 0.40 * 0.04 < deviation.std() < 0.49 * 0.04
    assert drive.path[400] == pytest.approx([40.0, 40.0])


def test_right_wheels_drift_from_the_left() -> None:
    drive = a_drive()
    make_effect("left-right-drift", {"rate": 0.002}).steer(drive)
    assert drive.path[-1, 1] - drive.path[-1, 0] == pytest.approx(0.002 * 5.0 * 996.0)
    assert drive.path[400, 1] == pytest.approx(40.0)


def test_air_spring_stiffens_in_compression_and_softens_in_rebound() -> None:
    law = make_effect("progressive-spring", {"polytropic_exponent": 1.3})
    assert make_effect("progressive-spring", {"cubic_front_N_m3": 1.0, "cubic_rear_N_m3": 1.0})
    down = integrate(ATV, Run(Track("flat"), 1.0, 0.0, TIME), [law, Push(0.8, 0.0, -400.0)])
    up = integrate(ATV, Run(Track("flat"), 1.0, 0.0, TIME), [law, Push(0.8, 0.0, 400.0)])
    load = 9.81 * ATV["body.mass_kg"] * (1.42 - 0.80) / 1.42 / 2.0
    for motion, extra in ((down, 200.0), (up, -200.0)):
        travel = motion.position[-1, 4] - motion.position[-1, 0]
        height = 1.3 * load / ATV["suspension.front.stiffness_N_m"]
        assert load * (1.0 - travel / height) ** -1.3 == pytest.approx(load + extra, rel=1e-3)


K, C = np.full(4, 1e4), np.full(4, 500.0)


@pytest.mark.parametrize(
    ("name", "parameters", "x", "v", "expected"),
    [
        ("bump-stop", {"clearance_m": 0.02, "stiffness_N_m": 1e5}, 0.03, 0.0, 1000.0),
        ("bump-stop", {"clearance_m": 0.02, "stiffness_N_m": 1e5}, -0.03, 0.0, 0.0),
        ("asymmetric-damper", {"asymmetry": 0.3}, 0.0, 1.0, -150.0),  # 350 N in compression
        ("asymmetric-damper", {"asymmetry": 0.3}, 0.0, -1.0, -150.0),  # -650 N in rebound
        ("digressive-damper", {"knee_m_s": 0.2, "slope_ratio": 0.4}, 0.0, 0.1, 0.0),
        ("digressive-damper", {"knee_m_s": 0.2, "slope_ratio": 0.4}, 0.0, -1.2, 300.0),
        ("progressive-spring", {"cubic_front_N_m3": 1e6, "cubic_rear_N_m3": 1e6}, 0.1, 0.0, 1000.0),
    ],
)
def test_suspension_laws_add_the_force_they_say(
    name: str, parameters: dict[str, float | str], x: float, v: float, expected: float
) -> None:
    effect = make_effect(name, parameters)
    effect.start(replace(a_drive(), suspension_stiffness=K, suspension_damping=C))
    added = effect.suspension(np.zeros(4), np.full(4, x), np.full(4, v))
    np.testing.assert_allclose(added, expected, atol=1e-9)


def test_backlash_hangs_free_until_the_gap_is_used_up() -> None:
    effect = make_effect("backlash", {"gap_m": 0.01})
    effect.start(replace(a_drive(), suspension_stiffness=K, suspension_damping=C))
    load = suspension_static_load(ATV)
    for x, total in (
        (np.full(4, 0.01), load + 100.0),  # pressed
        (-load / 1e4 - 0.005, 0.0 * load),  # hanging half-way in the gap, after the strut relaxed
        (-load / 1e4 - 0.03, np.full(4, -200.0)),  # pulled, 20 mm beyond the gap
    ):
        for _ in range(200):  # 2 s at rest
            force = effect.suspension(K * x, x, np.zeros(4))
        np.testing.assert_allclose(load + force, total, atol=1e-3)


def test_tyre_stiffens_and_an_unbalanced_wheel_pulls_its_axle() -> None:
    drive = replace(a_drive(), tyre_stiffness=np.full(4, 4e4))
    tyre = make_effect("progressive-tyre", {"growth_per_m": 20.0})
    tyre.start(drive)
    for x, expected in ((0.01, 440.0), (-0.01, -360.0), (-0.08, -1000.0)):  # slope 0 at -0.05
        force = tyre.tyre(np.full(4, 4e4 * x), np.full(4, x), np.zeros(4))
        np.testing.assert_allclose(force, expected)
    make_effect("wheel-imbalance", {"imbalance_kg_m": 0.03, "corner": 3.0}).start(drive)
    assert drive.forces["A3"].std() * np.sqrt(2.0) == pytest.approx(0.03 * (5.0 / 0.279) ** 2, 0.01)


def test_sensor_faults() -> None:
    run = Run(HERRINGBONE, 5.0, 35.0, TIME[:50])
    true = simulate_run(ATV, run)[1]

    def faulty(name: str, **parameters: float | str) -> np.ndarray:
        return simulate_run(ATV, run, [make_effect(name, parameters)])[1]

    signs = np.array([1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(faulty("sensor-polarity", channel="B2"), true * signs)
    swapped = faulty("sensor-polarity", channel="B1", swapped_with="A1")
    np.testing.assert_allclose(swapped, true[:, [4, 1, 2, 3, 0, 5, 6, 7]])
    gain = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.1])
    np.testing.assert_allclose(faulty("sensor-gain", channel="A4", gain_error=0.1), true * gain)
    clipped = faulty("sensor-clipping", limit_m_s2=5.0)
    np.testing.assert_allclose(clipped, np.clip(true, -5.0, 5.0))
    late = faulty("sensor-skew", skew_s=0.001)
    moved = simulate_run(ATV, replace(run, time_s=run.time_s + 0.007))[1]
    np.testing.assert_allclose(late[:, 0], true[:, 0])
    np.testing.assert_allclose(late[:, 7], moved[:, 7], atol=0.02)


def test_wrong_names_are_told() -> None:
    with pytest.raises(ValueError, match="no effect 'rust'"):
        make_effect("rust", {})
    with pytest.raises(ValueError, match="coulomb_front_N"):
        make_effect("dry-friction", {"force_N": 3.0})
