"""Where a run met a bump: records that are what the linear model makes of it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, campaign_of, linear_response, model_of
from wheelhop.campaign import TrackSpec
from wheelhop.fit import find_start
from wheelhop.fit.placement import _speeds
from wheelhop.vehicle import behind_m, wheels

STEP, N, NOMINAL = 0.01, 360, 4.0
TIME = 2.0 + STEP * np.arange(N)
MODEL = model_of(ATV, {})
SYSTEM = MODEL.system(CHANNELS, "road")
BEHIND = [behind_m(ATV, i) for i in wheels(ATV)]
BUMP = {"amplitude_mm": 60.0, "length_mm": 500.0, "side": "both"}


def bump(x, where=0.0):
    """20 mm high, half a metre long."""
    return 0.02 * np.exp(-(((x - where) / 0.15) ** 2))


def driven(place, profile=bump):
    """The record of wheels whose front axle is at these places, from three seconds earlier on."""
    early = np.arange(-300, N) * STEP + TIME[0]
    height = np.stack([profile(place(early) - behind) for behind in BEHIND], axis=1)
    return linear_response(SYSTEM, height, STEP)[-N:]


def campaign_with(record):
    run = truth.Run(truth.Track("half-sine-bump", BUMP), NOMINAL, 0.0, TIME)
    return campaign_of({"run": run}, {"run": record})


@pytest.fixture
def lay(monkeypatch):
    """Put a profile under all wheels, and nothing else."""

    def laid(profile):
        monkeypatch.setattr(
            "wheelhop.fit.placement._envelopes",
            lambda model, track, x: profile(x)[:, None] * np.ones(4),
        )

    return laid


@pytest.fixture(autouse=True)
def ground(lay):
    lay(bump)


def found_in(record, **given):
    campaign = campaign_with(record)
    run = replace(campaign.runs[0], **given)
    return find_start(campaign, run, MODEL, SYSTEM)


SPEEDS = _speeds(campaign_with(np.zeros((N, 8))).runs[0], NOMINAL / 8.0)


@pytest.mark.parametrize(
    ("speed", "met_s"), [(SPEEDS[3], 2.3), (SPEEDS[-4], 3.7), (SPEEDS[16], 5.4)]
)
def test_speed_and_start_are_found_wherever_in_the_record_the_bump_is(speed, met_s):
    """To two samples, and to two of the steps in which speeds are tried."""
    start = -speed * met_s
    found = found_in(driven(lambda t: start + speed * t))
    assert found["speed_m_s"] == pytest.approx(speed, abs=2.5 * (SPEEDS[1] - SPEEDS[0]))
    met = -found["start_m"] / found["speed_m_s"]
    assert met == pytest.approx(met_s, abs=0.02)


def test_a_line_that_does_not_belong_to_the_bump_moves_nothing():
    """Out of band, or the same at any time."""
    speed, start = SPEEDS[3], -SPEEDS[3] * 3.7
    record = driven(lambda t: start + speed * t)
    plain = found_in(record)
    disturbed = record + 5.0 + 3.0 * np.sin(2 * np.pi * 40.0 * TIME)[:, None]
    assert found_in(disturbed) == pytest.approx(plain)


def test_a_record_without_the_bump_stands_where_there_is_none():
    """The best that can be said of silence: nothing was met."""
    found = found_in(np.zeros((N, 8)))
    places = found["start_m"] + found["speed_m_s"] * TIME
    assert np.abs(bump(places[:, None] - np.array(BEHIND))).max() < 1e-4


def test_what_the_record_would_hold_besides_counts_against_a_place(lay):
    """A bump three times as high correlates better with any record; it was not met."""
    speed = SPEEDS[20]

    def two(x):
        return bump(x) + 3.0 * bump(x, -12.0)

    lay(two)
    found = found_in(driven(lambda t: speed * (t - 3.0), two))
    assert -found["start_m"] / found["speed_m_s"] == pytest.approx(3.0, abs=0.02)


@pytest.mark.parametrize("gain", [0.25, 0.4, 1.0, 2.5, 4.0])
def test_a_nominal_vehicle_that_answers_too_much_or_too_little_is_placed_as_well(gain):
    """A tenth of the record's amplitude is noise; more than twice as much as was measured once made
    flat ground the best place."""
    speed = SPEEDS[20]
    record = gain * driven(lambda t: speed * (t - 3.7))
    record += 0.1 * record.std(axis=0) * np.random.default_rng(5).normal(size=record.shape)
    found = found_in(record)
    assert found["speed_m_s"] == pytest.approx(speed, rel=0.02)
    assert -found["start_m"] / found["speed_m_s"] == pytest.approx(3.7, abs=0.03)


def test_what_a_place_would_excite_out_of_band_does_not_count_against_it(lay):
    """Ripples of 42 Hz about the bump that was met; one a tenth higher, elsewhere, has none."""
    speed = SPEEDS[20]

    def rippled(x):
        ripples = 0.003 * np.sin(2 * np.pi * 42.0 * x / speed) * np.exp(-((x / 0.5) ** 2))
        return bump(x) + ripples + 1.1 * bump(x, -12.0)

    lay(rippled)
    found = found_in(driven(lambda t: speed * (t - 3.0), rippled))
    assert -found["start_m"] / found["speed_m_s"] == pytest.approx(3.0, abs=0.02)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_on_a_road_without_an_end_places_are_sought_twice_as_far_as_it_was_driven(lay, side):
    speed = SPEEDS[20]
    where = side * 1.8 * speed * (TIME[-1] - TIME[0])

    def far(x):
        return bump(x, where)

    lay(far)
    start = where - speed * 3.7
    found = found_in(
        driven(lambda t: start + speed * t, far),
        track=TrackSpec("iso8608", {"unevenness_m3": 1e-6, "waviness": 2.0, "seed": 1.0}),
    )
    met = (where - found["start_m"]) / found["speed_m_s"]
    assert met == pytest.approx(3.7, abs=0.02)


def test_along_a_course_the_start_is_the_place_at_time_zero():
    """Uphill slower and slower, a tenth faster than it was planned."""
    begin, grade = 40.0, 0.1  # x = (planned time)² · grade
    course = SimpleNamespace(
        time=lambda x: np.sqrt(np.maximum(np.asarray(x) + begin, 0.0) / grade),
        place=lambda t: grade * np.maximum(t, 0.0) ** 2 - begin,
        speed_m_s=(3.0, 5.0),
    )
    faster, late = SPEEDS[-6] / NOMINAL, 16.3
    place = lambda t: course.place(late + faster * t)  # noqa: E731
    found = found_in(driven(place), course=course)
    assert found["speed_m_s"] / NOMINAL == pytest.approx(faster, abs=0.02)
    then = course.place(course.time(found["start_m"]) + found["speed_m_s"] / NOMINAL * TIME)
    assert np.abs(then - place(TIME)).max() < 0.1
