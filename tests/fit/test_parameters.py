"""What is free in a model, and what is believed of it before anything is fitted."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests import truth
from tests.simulate.setup import ATV, EFFECTS, TIME, campaign_of, model_of
from wheelhop.campaign import Channel, TrackSpec
from wheelhop.effects import RunSetting, Shape, Switch
from wheelhop.fit import (
    Free,
    effect_parameters,
    initial_model,
    run_parameters,
    vehicle_parameters,
)
from wheelhop.fit.belief import Belief
from wheelhop.fit.bench import run_up
from wheelhop.vehicle import Vehicle

RUNS = {"run": truth.Run(truth.Track("flat", {}), 4.0, 0.0, TIME)}
KNOWN_TO = {key: 0.1 * abs(value) for key, value in ATV.items()}
VEHICLE = Vehicle("as stated", ATV, KNOWN_TO)


def setting(on_road, on_rig=False):
    return RunSetting("run", 4.0, -4.0, 0.0, 5.0, on_road, on_rig)


def test_numbers_are_free_as_far_as_they_are_uncertain():
    """What is known exactly is not; a mass stays positive, a place need not."""
    sure = "body.mass_kg"
    vehicle = replace(VEHICLE, uncertainty={**KNOWN_TO, sure: 0.0})
    free = {f.name: f for f in vehicle_parameters(campaign_of(RUNS), vehicle)}
    assert sure not in free and "suspension.front.stiffness_N_m" in free
    for name, one in free.items():
        assert one.mean == ATV[name]
        assert one.sigma == one.scale == KNOWN_TO[name]
        assert one.lower == (-np.inf if name.endswith("x_m") else pytest.approx(ATV[name] / 50.0))
        assert one.upper == np.inf and not one.is_shape
    idle = ("geometry.cg_height_m", "driver.", "engine.")
    assert free.keys() == {key for key in ATV if not key.startswith(idle)} - {sure}


def test_who_stands_on_a_mount_is_free_to_be_told():
    """He moves by himself then; and his place need not be positive."""
    driver = {"driver.mass_kg": 80.0, "driver.x_m": -0.2, "driver.y_m": 0.01}
    mount = {"driver.stiffness_N_m": 3e4, "driver.damping_N_s_m": 900.0}
    for values, names in ((driver, set()), (driver | mount, {*driver, *mount})):
        everything = {k: v for k, v in ATV.items() if not k.startswith("driver.")} | values
        vehicle = Vehicle("manned", everything, {key: 0.1 for key in everything})
        free = {f.name: f for f in vehicle_parameters(campaign_of(RUNS), vehicle)}
        assert {name for name in free if name.startswith("driver.")} == names
        assert all(free[name].lower == -np.inf for name in names if name.endswith(("x_m", "y_m")))


def test_differences_are_small_but_where_a_table_of_the_ground_changes():
    """So small that what a bend adds, their square, is below eight digits."""
    assert Free("body.mass_kg", 300.0, 30.0, 30.0).step ** 2 < 1e-8
    assert 0.01 < Free("wheel.front.radius_m", 0.25, 0.01, 0.01).step < 0.03


def test_of_tracks_that_nobody_knows_wheels_learn_nothing():
    campaign = campaign_of(RUNS)
    unknown = replace(campaign.runs[0], track=TrackSpec("unknown", {}))
    nowhere, mixed = ((unknown,), (unknown, *campaign.runs))
    found = [
        {f.name.split(".")[0] for f in vehicle_parameters(replace(campaign, runs=runs), VEHICLE)}
        for runs in (nowhere, mixed)
    ]
    assert "wheel" not in found[0] and "wheel" in found[1]


def test_a_sensor_somewhere_on_the_body_is_within_its_wheels():
    """It begins at the centre of mass; its gain and corner are as its calibration says."""
    channel = Channel("C", "body", gain_uncertainty=0.02, corner_uncertainty=0.1)
    campaign = replace(campaign_of(RUNS, channels=(channel,)), channels=(channel,))
    free = {
        f.name: f for f in vehicle_parameters(campaign, VEHICLE) if f.name.startswith("channel")
    }
    length, width = ATV["geometry.wheelbase_m"], ATV["geometry.track_width_m"]
    assert {name: f.sigma for name, f in free.items()} == pytest.approx(
        {
            "channel.C.x_m": length / 4,
            "channel.C.y_m": width / 4,
            "channel.C.gain": 0.02,
            "channel.C.corner": 0.1,
        }
    )
    assert all(f.mean == 0.0 and f.scale == f.sigma for f in free.values())
    assert all(-1.0 < free[f"channel.C.{what}"].lower < 0.0 for what in ("gain", "corner"))
    begun = initial_model(campaign, VEHICLE).values
    assert {name: begun[name] for name in free} == dict.fromkeys(free, 0.0)
    bare = Channel("C", "B1")
    sure = replace(campaign, channels=(bare,))
    assert not any(f.name.startswith("channel") for f in vehicle_parameters(sure, VEHICLE))


def test_a_driver_holds_the_speed_within_a_tenth_nine_times_of_ten():
    """Where on the track a run begins nobody knows; one that stands leaves nothing free."""
    (run,) = campaign_of(RUNS).runs
    speed, start = run_parameters(run, setting(on_road=True), model_of(ATV, {}))
    assert (speed.name, start.name) == ("speed_m_s", "start_m")
    assert speed.mean == 4.0 and 1.5 < 0.1 * speed.mean / speed.sigma < 2.0
    assert speed.lower == 0.0 and start.mean == 0.0 and start.sigma == np.inf
    # They are varied by a thousandth of the speed and by a centimetre.
    assert speed.scale == pytest.approx(0.004) and start.scale == 0.01
    slow = replace(run, speed_m_s=0.5)
    assert len(run_parameters(slow, setting(on_road=True), model_of(ATV, {}))) == 2
    standing = replace(run, speed_m_s=0.0)
    assert run_parameters(standing, setting(on_road=True), model_of(ATV, {})) == []
    assert run_parameters(run, setting(False, on_rig=True), model_of(ATV, {})) == []


def test_what_an_effect_leaves_free_in_a_run_is_free_there():
    """Where it acts: on measured axles there is no speed to change."""
    (run,) = campaign_of(RUNS).runs
    model = model_of(ATV, {}).with_effect(EFFECTS["speed-fluctuation"], ())
    found = {f.name for f in run_parameters(run, setting(on_road=True), model)}
    assert any(name.startswith("speed-fluctuation.") for name in found)
    found = {f.name for f in run_parameters(run, setting(on_road=False), model)}
    assert not any(name.startswith("speed-fluctuation.") for name in found)


def test_measured_axles_leave_the_body_free_to_move_when_the_record_begins():
    """By centimetres, and as fast as such motion is at 1.6 Hz: ten times as much per second."""
    (run,) = campaign_of(RUNS).runs
    free = run_parameters(run, setting(on_road=False), model_of(ATV, {}))
    ways = {f.name: f.sigma for f in free if not f.name.endswith("_rate")}
    rates = {f.name.removesuffix("_rate"): f.sigma for f in free if f.name.endswith("_rate")}
    assert set(ways) == {"initial_heave", "initial_pitch", "initial_roll"} == set(rates)
    assert all(0.01 <= size < 0.03 and rates[name] == 10.0 * size for name, size in ways.items())
    assert all(f.mean == 0.0 and f.scale == f.sigma for f in free)


def test_of_an_amplitude_nothing_is_believed_of_a_shape_its_scale():
    """A switch is thrown by nobody, heights of a density are found elsewhere."""
    effect = EFFECTS["digressive-damper"]
    parameters = effect.parameters_for(ATV, ())
    free = {f.name: f for f in effect_parameters(parameters, model_of(ATV, {}), effect)}
    assert len(free) == len([p for p in parameters if not isinstance(p, Switch)]) > 0
    for p in parameters:
        one = free[f"{effect.id}.{p.name}"]
        assert one.sigma == (p.scale if isinstance(p, Shape) else np.inf) and one.scale == p.scale
        assert one.is_shape is isinstance(p, Shape) and (one.lower, one.upper) == (p.lower, p.upper)
    begun = replace(parameters[-1], starts=(0.7,), believed=None)
    assert isinstance(begun, Shape)
    for believed, mean in ((None, 0.9), (0.2, 0.2)):
        model = model_of(ATV, {}, effect.id, {begun.name: 0.9})
        (one,) = effect_parameters([replace(begun, believed=believed)], model, effect)
        assert one.mean == mean  # near where it begins, if nothing else is believed
    rough = EFFECTS["small-scale-roughness"]
    assert effect_parameters(rough.parameters_for(ATV, ()), model_of(ATV, {}), rough) == []


NUMBERS = (Free("a", 3.0, 0.5, 2.0), Free("b", -1.0, np.inf, 0.1))


@given(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0))
def test_a_belief_is_as_far_away_as_standard_deviations_say(a, b):
    """Nothing is believed of b; what is not stated is where it is believed to be."""
    assert (NUMBERS[0].lower, NUMBERS[0].upper) == NUMBERS[0].span_s == (-np.inf, np.inf)
    belief = Belief.of(NUMBERS)
    values = {"a": a, "b": b}
    assert belief.distance(values) == pytest.approx(((a - 3.0) / 0.5) ** 2)
    assert belief.distance({"b": b}) == 0.0
    # Half the negative gradient, per scale: −(a − 3) scale / sigma².
    assert belief.pull(values) == pytest.approx([-(a - 3.0) * 2.0 / 0.5**2, 0.0])


def test_the_volume_of_a_belief_is_finite_though_nothing_is_believed():
    """As of two scales; a fit's posterior has the determinant it has."""
    assert Belief.of(NUMBERS).log_precision == pytest.approx(np.log((2.0 / 0.5) ** 2 / 4.0))
    precision = np.array([[5.0, 1.0], [1.0, 2.0]])
    after = Belief.after(NUMBERS, {"a": 4.0, "b": 0.0}, precision)
    assert after.log_precision == pytest.approx(np.log(9.0))
    step = np.array([1.0, -3.0])  # of each one's scale
    away = {"a": 4.0 + 2.0 * step[0], "b": 0.1 * step[1]}
    assert after.distance(away) == pytest.approx(step @ precision @ step)
    assert after.pull(away) == pytest.approx(-precision @ step)


IN_PROPORTION = (Free("a", 3.0, 0.6, 2.0, in_proportion=True), NUMBERS[1])


@given(st.floats(0.1, 100.0))
def test_twice_as_much_is_as_likely_as_half(a):
    """Of what is believed in proportion, 20 % here; the pull is half the negative gradient."""
    belief = Belief.of(IN_PROPORTION)
    away = belief.distance({"a": a})
    assert (
        away
        == pytest.approx(belief.distance({"a": 9.0 / a}))
        == pytest.approx((np.log(a / 3.0) / 0.2) ** 2)
    )
    step = 1e-5 * a
    slope = (belief.distance({"a": a + step}) - belief.distance({"a": a - step})) / (2.0 * step)
    assert belief.pull({"a": a})[0] == pytest.approx(-0.5 * slope * 2.0, rel=1e-4, abs=1e-4)
    # One over the variance, per scale: 20 % of what it is there.
    assert belief.precision_at({"a": a})[0, 0] == pytest.approx((2.0 / (0.2 * a)) ** 2)
    grown = belief.log_precision_at({"a": a}) - belief.log_precision_at({"a": 3.0})
    assert grown == pytest.approx(2.0 * np.log(3.0 / a))


def test_a_vehicle_is_believed_in_proportion_but_for_places():
    """A place may be negative, and a calibration says by how much a scale is off."""
    campaign = campaign_of(RUNS, channels=(Channel("B1", "body", gain_uncertainty=0.02),))
    for free in vehicle_parameters(campaign, VEHICLE):
        of_the_vehicle = free.name in ATV and not free.name.endswith((".x_m", ".y_m"))
        assert free.in_proportion is of_the_vehicle, free.name


@pytest.mark.parametrize(("stated", "sigma"), [(0.0, 50.0), (30.0, 50.0)])
def test_what_may_be_nothing_is_not_believed_in_proportion(stated, sigma):
    """A tyre may have no damping at all."""
    key = "wheel.front.tyre_damping_N_s_m"
    vehicle = Vehicle("as stated", {**ATV, key: stated}, {**KNOWN_TO, key: sigma})
    (free,) = [f for f in vehicle_parameters(campaign_of(RUNS), vehicle) if f.name == key]
    assert not free.in_proportion
    assert Belief.of([free]).distance({key: stated + sigma}) == pytest.approx(1.0)


def test_a_dozen_guesses_agree_on_the_scale_that_they_share():
    """Records do not show it: a fit with it alone free ends where the beliefs of all numbers say.
    Each is stated 10 % off, one standard deviation; they are right in the mean, and as far off as
    the precision says. Normal in the numbers themselves the mean would be −2 %, 0.7 deviations."""
    rng, off = np.random.default_rng(0), []
    for _ in range(400):
        stated = 1.0 + 0.1 * np.clip(rng.normal(size=12), -2.0, 2.0)
        belief = Belief.of([Free(f"{m}", m, 0.1 * m, 0.1 * m, in_proportion=True) for m in stated])
        scale = 1.0
        for _ in range(5):  # Newton
            values = {f.name: scale for f in belief.free}
            per_scale = 1.0 / np.array([f.scale for f in belief.free])
            precision = per_scale @ belief.precision_at(values) @ per_scale
            scale += per_scale @ belief.pull(values) / precision
        off.append((scale - 1.0) * np.sqrt(precision))
    assert np.mean(off) == pytest.approx(0.0, abs=0.2)
    assert np.std(off) == pytest.approx(1.0, abs=0.15)


@pytest.mark.parametrize(
    ("decays_per_s", "seconds"),
    [
        ((2.0,), 3.5),
        ((2.0, 4.0), 3.5),
        ((4.0, 2.0), 3.5),
        ((100.0,), 1.5),
        ((0.1,), 6.0),
        ((0.0,), 6.0),
    ],
)
def test_a_run_up_lasts_until_a_thousandth_is_left(decays_per_s, seconds):
    """Seven of the slowest time constants, but neither a moment nor a minute."""
    systems = {
        str(i): SimpleNamespace(
            poles=lambda decay=decay: np.array([-decay + 9j, -decay - 9j, -50.0])
        )
        for i, decay in enumerate(decays_per_s)
    }
    assert run_up(systems) == pytest.approx(seconds)
