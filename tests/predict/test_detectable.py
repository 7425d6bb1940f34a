"""What channels and roads can show is known before a diagnosis, and the diagnosis bears it out.

`python -m benchmarks.limits --before` asks more effects at more strengths.
"""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

import wheelhop as wh
from tests import truth
from tests.diagnose.cases import diagnosed
from tests.simulate.setup import ATV, CHANNELS, campaign_of
from tests.simulate.test_recorder import RUN
from tests.vehicle.test_layout import part_of
from wheelhop.cli.main import main
from wheelhop.diagnose.diagnosis import Limit
from wheelhop.predict import detectable as module
from wheelhop.predict.additions import Addition, additions
from wheelhop.predict.detectable import Added
from wheelhop.report.can_show import _said

FINE = tuple(
    replace(sensor, noise_rms=5e-5) if sensor.quantity == "travel" else sensor
    for sensor in truth.SENSORS
)
ACCELEROMETERS = tuple(
    truth.Sensor(f"{end}{i}", "acceleration", f"{end}{i}", 0.1)
    for end in "AB"
    for i in (1, 2, 3, 4)
)


def driven(folder, sensors, hidden=None, *, surveyed=True, short=True):
    truth.make_campaign(
        folder,
        seed=101,
        effects=hidden or {},
        short=short,
        seconds=4.8,
        draft=True,
        sensors=sensors,
    )
    if not surveyed:
        truth.forget_tracks(folder)
    return folder


def strengths(limits):
    return {limit.effect: max(limit.amplitudes.values(), default=0.0) for limit in limits}


@pytest.fixture(scope="module")
def by_pots(tmp_path_factory):
    """Of a clean car on roads nobody surveyed."""
    return wh.detectable(driven(tmp_path_factory.mktemp("pots"), FINE, surveyed=False))


@pytest.mark.parametrize(
    ("factor", "verdict"),
    [pytest.param(0.1, "none", marks=pytest.mark.slow), (2.0, "anti-roll-bar")],
)
def test_twice_the_limit_is_seen_and_a_tenth_is_not(by_pots, tmp_path, factor, verdict):
    least = {limit.effect: limit.amplitudes for limit in by_pots.limits}["anti-roll-bar"]
    hidden = {f"stiffness_{end}_N_m": factor * least[f"{end}_N_m"] for end in ("front", "rear")}
    made = driven(tmp_path, FINE, {"anti-roll-bar": hidden}, surveyed=False)
    assert diagnosed(made).verdict == (verdict,)


@pytest.mark.slow
def test_friction_is_taken_for_a_damper_until_it_can_be_told_from_one(by_pots, tmp_path):
    """Noise of the pots smears the turn of the force: it is seen long before it is told."""
    told = {one.limit.effect: one for one in by_pots.told}["dry-friction"]
    seen = {limit.effect: limit for limit in by_pots.limits}["dry-friction"]
    assert told.rival == "digressive-damper"
    assert told.limit.amplitudes["front_N"] > 3.0 * seen.amplitudes["front_N"]
    hidden = {
        end: 2.0 * told.limit.amplitudes[name]
        for end, name in (("coulomb_front_N", "front_N"), ("coulomb_rear_N", "rear_N"))
    }
    made = driven(tmp_path, FINE, {"dry-friction": hidden}, surveyed=False)
    assert diagnosed(made).verdict == ("dry-friction",)


def test_what_does_nothing_on_these_roads_is_said(by_pots):
    assert {"tyre-lift-off", "wheel-imbalance"} <= set(by_pots.idle)
    assert not {"tyre-lift-off", "sensor-gain"} & {limit.effect for limit in by_pots.limits}


def test_a_channel_that_is_added_shows_what_it_would_have_been_foretold_to_show(tmp_path):
    """The eight accelerometers, and the same with two potentiometers of the noise assumed."""
    without = wh.detectable(driven(tmp_path / "without", ACCELEROMETERS))
    assert without.best.channels == "a potentiometer at each rear corner"
    pots = tuple(truth.Sensor(f"pot{i}", "travel", str(i), 1e-4) for i in (3, 4))
    added = wh.detectable(driven(tmp_path / "with", (*ACCELEROMETERS, *pots)))
    foretold, shown = strengths(without.best.limits), strengths(added.limits)
    assert foretold == pytest.approx(shown, rel=0.01)
    gain = strengths(without.limits)["driver-seat"] / foretold["driver-seat"]
    assert gain > 1.5
    assert without.best.less["driver-seat"] == pytest.approx(gain, rel=1e-6)


def test_on_unsurveyed_roads_a_channel_counts_as_if_it_were_there(tmp_path):
    """Of channels that err together what some show is no part of what all show."""
    few = tuple(s for s in FINE if s.quantity == "travel" or s.name == "B1")
    without = wh.detectable(driven(tmp_path / "without", few, surveyed=False))
    names = {
        "an accelerometer on the body above each front wheel": ("B2",),
        "an accelerometer on the body above each rear wheel": ("B3", "B4"),
        "a gyro of the pitch rate": ("pitch_rate",),
        "a gyro of the roll rate": ("roll_rate",),
    }[without.best.channels]
    more = tuple(s for s in FINE if s in few or s.name in names)
    added = wh.detectable(driven(tmp_path / "with", more, surveyed=False))
    assert strengths(without.best.limits) == pytest.approx(strengths(added.limits), rel=0.1)


SEEN = ("driver-seat", "dry-friction", "bump-stop")
BEFORE = (1.0, 1.0, 1.0)


def limits(strengths_N):
    pairs = zip(SEEN, strengths_N, strict=True)
    return tuple(Limit(effect, "", {"front_N": N}, True, 0.0) for effect, N in pairs)


@pytest.mark.parametrize(
    ("of_one", "of_many", "best", "times"), [(40.0, 2.7, "one", 10.0), (40.0, 3.5, "many", 3.5)]
)
def test_what_shows_one_effect_ten_times_better_is_not_worth_more_for_a_hundred_times(
    of_one, of_many, best, times
):
    """Two channels are offered: one for the seat alone, one for the seat and friction."""
    offered = [Addition(word, (CHANNELS[0],)) for word in ("one", "many")]
    shown = {2: (1 / of_one, 1.0, 1.0), 3: (1 / of_many, 1 / of_many, 1.0)}
    equations = SimpleNamespace(
        seen=lambda kept: SimpleNamespace(strengths=lambda campaign: shown[kept[-1]]),
        limits=limits,
    )
    campaign = SimpleNamespace(channels=CHANNELS[:2])
    found = module._best(equations, campaign, offered, BEFORE)
    assert found.channels == best
    assert found.less["driver-seat"] == pytest.approx(times)


@pytest.mark.parametrize(("less", "named"), [(1.6, True), (1.3, False)])
def test_a_sensor_is_worth_a_word_from_half_as_much_again_on(less, named):
    gains = dict.fromkeys(SEEN, 1.0) | {"dry-friction": less}
    added = Added("a gyro", limits((1.0, 1.0 / less, 1.0)), gains)
    said = _said(added, limits(BEFORE))
    assert ("a gyro: it would show dry-friction" in said) == named
    assert ("No further channel would add much" in said) != named
    assert "driver-seat" not in said


@pytest.mark.slow
def test_a_few_pieces_stand_for_all_runs(tmp_path, monkeypatch):
    campaign = driven(tmp_path, ACCELEROMETERS, short=False)
    few = strengths(wh.detectable(campaign).limits)
    monkeypatch.setattr(module, "MOST_RUNS", 100)
    monkeypatch.setattr(module, "LONGEST_S", 100.0)
    every = strengths(wh.detectable(campaign).limits)
    for effect, least in every.items():
        assert 0.5 * least <= few[effect] <= 2.1 * least, effect


def test_a_refusal_comes_at_once_and_says_what_would_cure_it(tmp_path, capsys):
    """Gyros and accelerometers on the body alone, on a road that nobody surveyed."""
    folder = driven(tmp_path / "campaign", FINE[4:], surveyed=False)
    document = tmp_path / "check.json"
    assert main(["check", str(folder), "--json", str(document)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "cannot be compared or diagnosed" in said
    assert "potentiometers at the struts 1, 2, 3 and 4" in said
    assert "describe the track" in json.loads(document.read_text())["detectable"]["refused"]


def test_two_axles_measured_beside_four_pots_leave_the_pots_to_drive(tmp_path):
    """A student car as they are: nothing has to be left out for it to be compared."""
    hubs = tuple(truth.Sensor(f"A{i}", "acceleration", f"A{i}", 0.1) for i in (1, 2))
    found = wh.detectable(driven(tmp_path, (*FINE, *hubs), surveyed=False))
    assert found.refused == ""
    assert {"dry-friction", "anti-roll-bar"} <= {limit.effect for limit in found.limits}


def test_check_says_it_and_its_json_holds_it(tmp_path, capsys):
    folder = driven(tmp_path / "campaign", ACCELEROMETERS)
    document = tmp_path / "check.json"
    assert main(["check", str(folder), "--json", str(document)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "would show, from so much on" in said
    assert "Most would be added by a potentiometer at each rear corner" in said
    found = json.loads(document.read_text())["detectable"]
    friction = next(one for one in found["limits"] if one["effect"] == "dry-friction")
    assert 0.0 < friction["amplitudes"]["front_N"] < friction["told_from"]["front_N"] < 5.0
    assert friction["rival"] == "digressive-damper"
    assert found["best"]["less"]["driver-seat"] > 1.5


@pytest.mark.parametrize(
    ("model", "points"),
    [
        ("quarter-car", {"S1", "A1", "B1"}),
        ("half-car", {"S1", "S3", "A1", "A3", "B1", "B3", "pitch"}),
        ("half-car-roll", {"S1", "S2", "A1", "A2", "B1", "B2", "roll"}),
    ],
)
def test_nothing_is_offered_that_a_smaller_car_does_not_have(model, points):
    """Nor could it be measured: a half car of two axles does not roll."""
    found = additions(replace(campaign_of(RUN), channels=()), part_of(ATV, model))
    assert {channel.point for one in found for channel in one.channels} == points
