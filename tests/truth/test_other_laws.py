"""Other laws than the textbook's, held against what they say."""

from __future__ import annotations

import numpy as np
import pytest

from .effects import make_effect
from .model import CHANNELS, Drive, Run, simulate_run
from .other_body_laws import JackedPitch, LinkedRoll
from .other_laws import (
    BristleFriction,
    FoamStop,
    MeasuredDamper,
    RoundedAsymmetry,
    RubberedPlay,
    RubberMount,
    StickyBar,
    TanhFriction,
    WanderingEngine,
    WarmingGas,
    WornCorner,
)
from .other_road_laws import (
    GearChanges,
    OutOfRound,
    PatchyRoughness,
    PowerTyre,
    PressedEnvelope,
    SlippingWheels,
    SoftLanding,
)
from .presets import PRESETS
from .road_effects import SmallScaleRoughness, TyreEnvelope
from .tracks import Track, Wheel

ATV = PRESETS["atv"].vehicle
STEP_S = 2e-4


def a_drive(seed: int = 2, seconds: float = 300.0) -> Drive:
    time = np.arange(0.0, seconds, STEP_S)
    path = np.column_stack([5.0 * time, 5.0 * time])
    damping = np.array([630.0, 630.0, 590.0, 590.0])
    none, spring = np.zeros(4), np.full(4, 1e4)
    return Drive(ATV, time, path, 5.0, np.random.default_rng(seed), spring, damping, none, none)


def along(effect, velocity):
    """Force of each strut (n, 4) beyond the linear one, along a common velocity (n,)."""
    travel = np.cumsum(velocity) * STEP_S
    zero = np.zeros(4)
    return np.array(
        [
            effect.suspension(zero, np.full(4, x), np.full(4, v))
            for x, v in zip(travel, velocity, strict=True)
        ]
    )


def test_creeping_friction_is_a_damper_below_its_creep_and_a_constant_above():
    effect = TanhFriction(70.0, 0.0, 0.005)
    force = along(effect, np.array([1e-5, -1e-5, 0.1, -0.1]))
    np.testing.assert_allclose(force[:, 0], [0.14, -0.14, 70.0, -70.0], rtol=1e-4)
    assert not force[:, 2:].any()


def test_bristles_stick_break_away_and_slide():
    """Loaded slowly they hold more than they do once they slide fast; at rest they keep a force."""
    effect = BristleFriction(70.0, 0.0)
    effect.start(a_drive())
    slow, fast = np.full(5000, 0.002), np.full(2000, 0.3)
    force = along(effect, np.concatenate([slow, fast, np.zeros(2000)]))[:, 0]
    assert force[4999] == pytest.approx(70.0 * (1 + 0.3 * np.exp(-0.01)), rel=0.01)
    assert force[6999] == pytest.approx(70.0, rel=0.01)
    assert 60.0 < force[-1] < 71.0


def test_a_measured_damper_has_its_slopes_and_gives_way_sooner_in_compression():
    effect = MeasuredDamper(0.1, 0.4, 0.3)
    effect.start(a_drive())
    for velocity in (1e-4, 3.0, 3.1, -3.0, -3.1):
        effect.start(a_drive())
        settled = along(effect, np.full(200, velocity))[-1, 0] + 630.0 * velocity
        if abs(velocity) < 1.0:
            assert settled == pytest.approx(630.0 * velocity, rel=1e-3)
        else:
            knee = 0.07 if velocity > 0 else 0.13
            line = 630.0 * (0.4 * velocity + 0.6 * knee * np.sign(velocity))
            assert settled == pytest.approx(line, rel=1e-6)


def test_a_stop_of_foam_begins_softly():
    effect = FoamStop(0.02, 3e4, 0.01)
    x = np.array([0.02, 0.025, 0.03, 0.04])
    force = [effect.suspension(np.zeros(4), np.full(4, at), np.zeros(4))[0] for at in x]
    np.testing.assert_allclose(force, [0.0, 3e4 * 0.005**2 / 0.02, 150.0, 450.0], atol=1e-9)


def test_an_idling_engine_differs_from_run_to_run_and_wanders():
    effect = make_effect(
        "engine-vibration",
        {"force_N": 100.0, "freq_hz": 10.0, "run_spread_hz": 0.5, "wander_hz": 0.16, "x_m": 0.0},
    )
    assert isinstance(effect, WanderingEngine)
    frequencies = [effect.frequency_hz(a_drive(seed, 30.0)) for seed in range(30)]
    means = np.array([f.mean() for f in frequencies])
    assert means.std() == pytest.approx(0.5, rel=0.3)
    wander = np.sqrt(np.mean([f.var() for f in frequencies]))
    assert wander == pytest.approx(0.16, rel=0.1)
    drive = a_drive(3, 20.0)
    effect.start(drive)
    crossings = np.count_nonzero(np.diff(np.sign(drive.forces["engine"]))) / 2
    turns = effect.frequency_hz(a_drive(3, 20.0)).mean() * 20.0
    assert crossings == pytest.approx(turns, abs=1.0)


def test_a_wheel_rolls_on_less_than_its_radius():
    slow, fast = (a_drive(2, 2.0) for _ in range(2))
    make_effect("wheel-imbalance", {"imbalance_kg_m": 0.03}).start(slow)
    make_effect("wheel-imbalance", {"imbalance_kg_m": 0.03, "rolling": 0.9}).start(fast)
    ratio = np.abs(fast.forces["A1"]).max() / np.abs(slow.forces["A1"]).max()
    assert ratio == pytest.approx(0.9**-2, rel=1e-3)


def test_gas_is_polytropic_when_pushed_fast_and_isothermal_when_held():
    effect = WarmingGas(1.4, 0.5)
    effect.start(a_drive())
    x, still = np.full(4, 0.02), np.zeros(4)
    height = 1.4 * effect._load / 1e4
    pushed = effect.suspension(1e4 * x, x, still)
    np.testing.assert_allclose(
        pushed, effect._load * ((1 - x / height) ** -1.4 - 1), rtol=STEP_S / 0.5
    )
    for _ in range(round(5.0 / STEP_S)):
        held = effect.suspension(1e4 * x, x, still)
    np.testing.assert_allclose(held, effect._load * (1 / (1 - x / height) - 1), rtol=1e-4)


def test_a_rounded_asymmetry_has_its_slopes_and_no_corner():
    effect = RoundedAsymmetry(0.35, 0.03)
    for velocity, slope in ((5.0, 0.65), (-5.0, 1.35), (1e-4, 1.0)):
        force = []
        for v in (velocity, 1.01 * velocity):
            effect.start(a_drive())
            force.append(along(effect, np.full(200, v))[-1, 0] + 630.0 * v)
        assert np.diff(force)[0] / (0.01 * velocity) == pytest.approx(630.0 * slope, rel=3e-3)


def test_rubber_is_stiffer_the_less_it_moves():
    effect = RubberMount(1e5, 200.0, 0.5, 3e-4)
    np.testing.assert_allclose(
        effect.stiffness(np.array([0.0, 3e-4, -3e-4])) / 1e5, [1.5, 1.25, 1.25]
    )
    effect.start(a_drive())
    x = np.full(4, 0.02)
    for _ in range(5000):
        extra = effect.suspension(1e4 * x, x, np.zeros(4))
    give = effect._give
    np.testing.assert_allclose(effect.stiffness(give) * give, 1e4 * (x - give), rtol=1e-6)
    np.testing.assert_allclose(extra, 1e4 * (x - give), rtol=1e-6)


def test_a_bar_that_rubs_holds_until_it_gives():
    effect = StickyBar(2000.0, 0.0, rubbing_N=15.0)
    effect.start(a_drive())
    roll = np.array([1.0, -1.0, 0.0, 0.0])
    for travel, force in ((5e-5, 7.5), (1e-3, 15.0), (9e-4, 0.0)):
        extra = effect.suspension(np.zeros(4), travel * roll, np.zeros(4))
        np.testing.assert_allclose(extra, force * roll, atol=1e-9)


def test_a_worn_corner_rubs_alone():
    effect = WornCorner(3.0, 0.2, -0.2, rubbing_N=15.0)
    force = effect.suspension(np.zeros(4), np.zeros(4), np.full(4, 1.0))
    np.testing.assert_allclose(force, [0.0, 0.0, 15.0, 0.0])


def test_gear_changes_cost_way_and_none_at_time_zero():
    drive = a_drive(4, 40.0)
    GearChanges(0.04).steer(drive)
    speed = np.diff(drive.path[:, 0]) / STEP_S
    assert speed.max() == pytest.approx(5.0, rel=1e-3)
    assert speed.min() == pytest.approx(4.8, rel=1e-3)
    assert speed.mean() == pytest.approx(4.9, rel=2e-3)
    assert drive.path[0, 0] == pytest.approx(0.0, abs=1e-6)


def test_a_contact_pressed_in_the_middle_passes_more_of_a_short_wave():
    """Of a wave of k L = 2 a parabola leaves 3 (sin h - h cos h) / h^3 with h = k L / 2, an even
    mean sin h / h; the wheel's own rounding comes before both."""
    track = Track("washboard", {"amplitude_mm": 0.5, "pitch_mm": 1000.0})
    wheel = Wheel(track, 0, 0.5, 0.02, np.linspace(5.0, 7.0, 2001))
    half = np.pi * 0.4
    passed = {}
    for law in (PressedEnvelope(0.4, 0.4, pressed=True), TyreEnvelope(0.4, 0.4)):
        passed[type(law)] = np.ptp(law.roll(wheel)) / np.ptp(wheel.rigid())
    expected = 3 * (np.sin(half) - half * np.cos(half)) / half**3 / (np.sin(half) / half)
    assert passed[PressedEnvelope] / passed[TyreEnvelope] == pytest.approx(expected, rel=3e-3)


def test_patches_come_and_go():
    flat, x = Track("flat", {}), np.linspace(2.0, 1400.0, 200001)
    even = SmallScaleRoughness(3e-8).pave(flat, a_drive()).unevenness(x, 0.5)
    patchy = PatchyRoughness(3e-8, patch_m=9.0).pave(flat, a_drive()).unevenness(x, 0.5)
    ratio = patchy / np.where(even == 0.0, 1.0, even)
    assert ratio.min() == pytest.approx(0.3, abs=1e-3)
    assert ratio.max() == pytest.approx(1.7, abs=1e-3)


def test_a_wheel_lands_softly():
    """No force at rest, none to pull, the linear one when pressed hard."""
    effect = SoftLanding(60.0)
    effect.start(a_drive())
    load = effect._load
    total = np.array([effect.tyre(at - load, load, load) + load for at in (load, -10 * load)])
    np.testing.assert_allclose(total[0], load, rtol=1e-12)
    assert np.all(total[1] < 2.0) and np.all(total[1] > -2.0)
    firm = effect.tyre(9.0 * load, load, load)
    np.testing.assert_allclose(firm, 9.0 * load, atol=2.0)


def test_a_wheel_out_of_round_rises_once_a_turn():
    effect = OutOfRound(0.2, 3.0, runout_m=5e-4)
    effect.start(a_drive(2, 2.0))
    flat, radius = Track("flat", {}), ATV["wheel.rear.radius_m"]
    x = np.linspace(0.0, 2 * np.pi * radius, 1001)
    path = effect.roll(Wheel(flat, 2, 0.5, radius, x))
    assert np.ptp(path) == pytest.approx(1e-3, rel=1e-4)
    assert path[0] == pytest.approx(path[-1], abs=1e-9)
    assert effect.roll(Wheel(flat, 0, 0.5, radius, x)) is None


def a_run(effect_id, **parameters):
    """One second over a washboard."""
    track = Track("washboard", {"amplitude_mm": 10.0, "pitch_mm": 500.0})
    run = Run(track, 4.0, 33.0, np.arange(100) / 100.0, seed=5)
    return simulate_run(ATV, run, [make_effect(effect_id, parameters)] if effect_id else [])[1]


def test_a_driver_of_two_masses_is_one_mass_if_the_upper_one_is_stiff():
    seat = {"mass_kg": 68.0, "freq_hz": 3.2, "zeta": 0.28, "x_m": -0.1}
    one = a_run("driver-seat", **seat)
    stiff = a_run("driver-seat", **seat, upper=0.4, upper_hz=200.0, upper_zeta=1.0)
    human = a_run("driver-seat", **seat, upper=0.4)
    assert np.abs(stiff - one).max() < 2e-3 * np.abs(one).max()
    assert np.abs(human - one).max() > 2e-3 * np.abs(one).max()


def test_bending_moves_the_four_corners_alike():
    """Against a frame that only twists: on a washboard, which does not, neither does the warp."""
    twist = {"freq_hz": 11.0, "zeta": 0.04}
    bends = a_run("frame-twist", **twist, bending_hz=24.0)[:, :4]
    more = bends - a_run("frame-twist", **twist)[:, :4]
    warp = np.array([1.0, -1.0, -1.0, 1.0])
    assert np.abs(more).max() > 0.1
    assert np.abs(bends @ warp).max() < 1e-6 * np.abs(bends).max()


def test_a_sensor_that_warms_has_a_gain_of_its_own_in_every_run():
    true, wrong = a_run(""), a_run("sensor-gain", channel="B2", gain_error=0.08, drift=0.01)
    ratio = wrong[:, 1] / true[:, 1]
    assert np.ptp(ratio) < 1e-9
    expected = 1.08 * (1 + 0.01 * np.random.default_rng(5).normal())
    assert ratio[0] == pytest.approx(expected, rel=1e-9)


def test_an_amplifier_cuts_about_its_offset_before_the_mean_is_taken():
    true, a2 = a_run(""), CHANNELS.index("A2")
    cut = a_run("sensor-clipping", channel="A2", limit_m_s2=6.0, offset_m_s2=1.0)
    assert true[:, a2].max() > 8.0 and true[:, a2].min() < -8.0
    assert cut[:, a2].max() == pytest.approx(5.0, rel=1e-6)
    assert cut[:, a2].min() == pytest.approx(-7.0, rel=1e-6)
    inside = (true[:, a2] < 2.0) & (true[:, a2] > -4.0)
    assert np.abs(cut - true)[inside, a2].max() < 0.1
    assert np.array_equal(np.delete(cut, a2, 1), np.delete(true, a2, 1))


def test_a_tyre_of_a_power_law_has_its_rate_at_rest_and_its_load_at_any_deflection():
    effect, stiffness = PowerTyre(1.25), 4e4
    drive = a_drive(2, 1.0)
    drive.tyre_stiffness = np.full(4, stiffness)
    effect.start(drive)
    at_rest = 1.25 * effect._load / stiffness

    def force(d):
        return effect.tyre(stiffness * d, d, np.zeros(4))

    step = np.full(4, 1e-7)
    np.testing.assert_allclose((force(step) - force(-step)) / 2e-7, stiffness, rtol=1e-6)
    np.testing.assert_allclose(force(at_rest) + effect._load, 2**1.25 * effect._load)
    np.testing.assert_allclose(force(-1.1 * at_rest), -effect._load)


def test_a_side_that_slips_falls_behind_and_its_car_does_not():
    drive = a_drive(4, 60.0)
    before = drive.path.copy()
    SlippingWheels(0.06, every_s=1.0).steer(drive)
    lead = drive.path[:, 1] - drive.path[:, 0]
    np.testing.assert_allclose(drive.path.mean(axis=1), before.mean(axis=1), atol=1e-9)
    assert lead[0] == pytest.approx(0.0, abs=1e-12)
    # Sixty slips of 0.35 times 60 mm on the average.
    assert lead[-1] == pytest.approx(60 * 0.35 * 0.06, rel=0.3)
    assert np.abs(np.diff(lead)).max() / STEP_S < 2 * 0.06 / 0.2


def test_play_in_rubber_closes_softly_and_carries_nothing_within_the_gap():
    """Pushed slowly it is strut and rubber in series; pulled it holds back the load, through the
    gap, and then pulls."""
    rubber, spring, gap = 1e5, 1e4, 0.006
    effect, drive = RubberedPlay(gap, rubber), a_drive(2, 0.01)
    effect.start(drive)
    together = spring * rubber / (spring + rubber)

    def held(x):
        x, still = np.full(4, x), np.zeros(4)
        for _ in range(4000):
            force = effect.suspension(spring * x, x, still)
        return force[0]

    load = effect._load[0]
    assert held(0.01) == pytest.approx(together * 0.01, rel=1e-6)
    opens = load / together
    assert held(-opens - 0.5 * gap) == pytest.approx(-load, rel=1e-6)
    assert held(-opens - gap - 0.01) == pytest.approx(-load - together * 0.01, rel=1e-6)


def test_a_driver_of_two_links_is_one_if_the_neck_is_stiff():
    sway = {"roll_inertia_kg_m2": 6.0, "freq_hz": 2.4, "zeta": 0.25}
    track = Track("one-sided-washboard", {"amplitude_mm": 10.0, "pitch_mm": 500.0})
    run = Run(track, 1.5, 33.0, np.arange(100) / 100.0, seed=5)
    one, stiff, human = (
        simulate_run(ATV, run, [make_effect("driver-rocking", {**sway, **more})])[1]
        for more in ({}, {"upper": 0.3, "upper_hz": 200.0, "upper_zeta": 1.0}, {"upper": 0.3})
    )
    assert np.abs(stiff - one).max() < 2e-3 * np.abs(one).max()
    assert np.abs(human - one).max() > 2e-3 * np.abs(one).max()


@pytest.mark.parametrize("anti", [0.0, 0.3])
def test_links_carry_their_share_of_braking(anti):
    drive, whole = a_drive(3, 20.0), a_drive(3, 20.0)
    JackedPitch(3.0, anti=anti).start(drive)
    JackedPitch(3.0, anti=0.0).start(whole)
    np.testing.assert_allclose(
        drive.forces["nose down"], (1 - anti) * whole.forces["nose down"], atol=1e-9
    )
    lever = ATV["body.mass_kg"] * ATV["geometry.cg_height_m"]
    largest = np.abs(whole.forces["nose down"]).max() / lever
    assert 1.2 <= largest <= 3.0
    lifted = -0.1 * anti * whole.forces["nose down"] / ATV["geometry.wheelbase_m"]
    np.testing.assert_allclose(drive.forces["lifted"], lifted, atol=1e-9)


def test_a_roll_axis_above_the_road_leaves_the_wheels_the_whole_moment():
    """What the links push on the wheels and what rolls the body are the load transfer together."""
    drive, whole = a_drive(3, 20.0), a_drive(3, 20.0)
    LinkedRoll(2.0, direct=0.3).start(drive)
    LinkedRoll(2.0, direct=0.0).start(whole)
    half = ATV["geometry.track_width_m"] / 2
    of_wheels = sum(
        side * half * drive.forces[f"A{i}"] for i, side in enumerate((1, -1, 1, -1), start=1)
    )
    np.testing.assert_allclose(
        drive.forces["right side down"] + of_wheels, whole.forces["right side down"], atol=1e-9
    )
    assert np.abs(of_wheels).max() == pytest.approx(
        0.3 * np.abs(whole.forces["right side down"]).max()
    )
