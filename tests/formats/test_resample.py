"""Channels with clocks of their own on one rate: what is exact, stated, and stays empty."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.formats.foreign import save
from wheelhop.formats import ExchangeError, Map, Pick, cells, parse_mapping, read, understand, write
from wheelhop.formats.resample import onto_rate
from wheelhop.formats.table import BETWEEN, Table
from wheelhop.logger.recording import Channel


def one(time_s, values, rate_hz, **more):
    """A channel with these stamps on another rate."""
    return onto_rate([alone(time_s, values, **more)], Map(resample_hz=rate_hz))


def alone(time_s, values, name="x", **more):
    channels = (Channel(name, "m"),)
    return Table("run.csv", "text", channels, np.asarray(values, float)[:, None], time_s, **more)


def walk(generator, rows):
    return np.concatenate([[0.0], np.cumsum(generator.standard_normal(rows - 1))])


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), rate_hz=st.floats(20.0, 300.0))
def test_a_straight_line_stays_one_whatever_the_steps(seed, rate_hz):
    generator = np.random.default_rng(seed)
    time_s = np.cumsum(generator.uniform(0.05, 0.1, 200))
    found = one(time_s, 3.0 * time_s - 1.0, rate_hz)
    rows_s = found.start_s + np.arange(len(found.values)) / rate_hz
    assert np.allclose(found.values[:, 0], 3.0 * rows_s - 1.0, atol=1e-9)
    assert found.between[0].rms < 1e-9


def test_samples_on_the_rows_come_through_to_the_bit_and_are_not_uncertain():
    values = walk(np.random.default_rng(1), 100)
    found = one(np.arange(100) / 50.0, values, 50.0)
    assert np.array_equal(found.values[:, 0], values)
    assert found.between[0].rms == 0.0


def test_the_error_of_a_sine_is_that_of_its_chords():
    """Midway over a step h the chord of sin(ωt) is off by (1 - cos(ωh/2)) sin: Taylor's h²."""
    h, omega = 0.01, 2 * np.pi * 2.0
    time_s = np.arange(4000) * h
    found = one(time_s, np.sin(omega * time_s), 1000.0)
    exact = (1 - np.cos(omega * h / 2)) / np.sqrt(2)
    assert found.between[0].rms == pytest.approx(exact, rel=0.02)
    rows_s = found.start_s + np.arange(len(found.values)) / 1000.0
    middle = (np.arange(len(rows_s)) % 10) == 5
    off = found.values[:, 0] - np.sin(omega * rows_s)
    assert np.sqrt(np.mean(off[middle] ** 2)) == pytest.approx(exact, rel=0.02)


def test_the_error_of_a_random_walk_is_that_of_a_brownian_bridge():
    """Midway over a step in which the walk's variance grows by 1 it is ¼."""
    found = one(np.arange(200_000) * 0.1, walk(np.random.default_rng(2), 200_000), 25.0)
    assert found.between[0].rms == pytest.approx(0.5, rel=0.02)


def test_noise_stays_noise_however_far_one_looks():
    """A sample and the mean of its neighbours differ by √1.5 of the noise."""
    values = np.random.default_rng(3).standard_normal(100_000)
    assert one(np.arange(100_000) * 0.1, values, 25.0).between[0].rms == pytest.approx(
        np.sqrt(1.5), rel=0.02
    )


def test_too_few_samples_are_as_uncertain_as_all_they_show():
    values = walk(np.random.default_rng(4), 12)
    assert one(np.arange(12) * 0.1, values, 25.0).between[0].rms == np.std(values)
    more = walk(np.random.default_rng(4), 15)
    assert one(np.arange(15) * 0.1, more, 25.0).between[0].rms < np.std(more)


@pytest.mark.parametrize(("apart", "empty"), [(3.9, False), (4.1, True)])
def test_over_more_than_four_usual_steps_rows_stay_empty(apart, empty):
    time_s = np.arange(100) * 0.1
    time_s[50:] += (apart - 1) * 0.1
    missing = int(np.isnan(one(time_s, time_s, 50.0).values).sum())
    assert missing == pytest.approx(apart * 5 - 1, abs=1) if empty else missing == 0


def test_long_steps_that_come_all_the_time_are_no_gaps():
    steps = np.where(np.arange(1000) % 7 == 0, 0.05, 0.005)  # one in seven, as a bus sends them
    assert not np.isnan(one(np.cumsum(steps), np.cumsum(steps), 100.0).values).any()
    steps = np.where(np.arange(1000) % 20 == 0, 0.05, 0.005)
    assert np.isnan(one(np.cumsum(steps), np.cumsum(steps), 200.0).values).any()


def test_rows_that_share_a_stamp_are_their_mean_and_it_is_said():
    time_s = np.repeat(np.arange(50) * 0.1, 2)
    found = one(time_s, np.tile([1.0, 3.0], 50), 10.0)
    assert np.all(found.values == 2.0)
    assert any("samples that share a stamp with another: 50" in line for line in found.remarks)


def test_a_clock_that_is_set_anew_makes_no_billion_empty_rows():
    time_s = np.concatenate([np.arange(100) * 0.01, 1e9 + np.arange(100) * 0.01])
    with pytest.raises(ExchangeError, match="is a clock set anew in between"):
        one(time_s, np.zeros(200), 100.0)


def test_stamps_that_fall_are_not_sorted():
    with pytest.raises(ExchangeError, match=r"row 3: time does not rise, from 0\.1 to 0\.05 s"):
        one(np.array([0.0, 0.1, 0.05, 0.2]), np.zeros(4), 10.0)


@pytest.mark.parametrize("rate_hz, refused", [(74.0, True), (76.0, False)])
def test_no_samples_are_lost_to_a_lower_rate(rate_hz, refused):
    """Beyond what clocks jitter by, a quarter of a step."""
    try:
        one(np.arange(100) / 100.0, np.zeros(100), rate_hz)
    except ExchangeError as error:
        assert refused and "x has 100 samples a second: resample_hz = 74 would lose some" in str(
            error
        )
    else:
        assert not refused


def test_groups_with_clocks_of_their_own_are_one_recording_by_their_starts():
    slow = alone(np.arange(30) * 0.1, np.arange(30) * 0.1, "slow", start_unix_s=100.5, group="a")
    fast = alone(np.arange(300) * 0.01, np.arange(300) * 0.01, start_unix_s=100.0, group="b")
    found = onto_rate([fast, slow], Map(resample_hz=100.0))
    assert found.start_s == 0.0 and len(found.values) == 341
    rows_s = np.arange(341) / 100.0
    assert np.allclose(found.values[:300, 0], rows_s[:300])
    assert np.isnan(found.values[:50, 1]).all()  # it began half a second later
    assert np.allclose(found.values[50:, 1], rows_s[50:] - 0.5, atol=1e-9)
    unknown = alone(np.arange(30) * 0.1, np.arange(30.0), "slow", group="a")
    with pytest.raises(ExchangeError, match="does not say how far apart its groups began"):
        onto_rate([fast, unknown], Map(resample_hz=100.0))
    same = [alone(t.time_s, t.values[:, 0], same_clock=True, group=t.group) for t in (slow, fast)]
    found = onto_rate(same, Map(resample_hz=100.0))
    assert [c.name for c in found.channels] == ["a/x", "b/x"]


def test_a_column_that_is_not_picked_sets_no_rate():
    fast = alone(np.arange(300) * 0.01, np.zeros(300), "fast", same_clock=True, group="b")
    slow = alone(np.arange(30) * 0.1, np.zeros(30), "slow", same_clock=True, group="a")
    found = onto_rate([fast, slow], Map(resample_hz=10.0, picks=(Pick("slow"),)))
    assert [c.name for c in found.channels] == ["slow"]
    with pytest.raises(ExchangeError, match='no column "sluw"; it has fast, slow'):
        onto_rate([fast, slow], Map(resample_hz=10.0, picks=(Pick("sluw"),)))


def test_import_takes_an_uneven_file_to_one_rate_and_states_the_error(tmp_path):
    generator = np.random.default_rng(5)
    time_s = np.cumsum(generator.uniform(0.008, 0.012, 2000)).round(6)
    wave = np.sin(2 * np.pi * time_s)
    rows = "\n".join(
        f"{t:.6f},{1e3 * x:.5f},{1e3 * x:.5f}" if k % 10 == 0 else f"{t:.6f},{1e3 * x:.5f},"
        for k, (t, x) in enumerate(zip(time_s, wave, strict=True))
    )
    path = save(tmp_path, "run.csv", f"Time [s],travel [mm],late [mm]\n{rows}\n")
    asked = understand(path)
    assert [question.key for question in asked.questions] == ["resample_hz"]
    answered = understand(path, {"resample_hz": "100"})
    assert not answered.questions
    found = read(path, parse_mapping(answered.text(), path))
    assert found.rate_hz == 100.0
    for k, channel in enumerate(found.channels):
        assert channel.unit == "m"
        off = found.values[:, k] - np.sin(2 * np.pi * found.time_s)
        stated = float(found.notes[BETWEEN + channel.name])
        assert np.sqrt(np.nanmean(off**2)) < stated < 2.5 * np.sqrt(np.nanmean(off**2))
    assert any(
        line.startswith("late: ") and "samples a second, between which it is uncertain by" in line
        for line in found.history
    )


def test_a_resampled_channel_keeps_its_error_through_a_file(tmp_path):
    rows = "\n".join(f"{0.01 * k + 0.004 * (k % 3):.4f},{k % 7}" for k in range(400))
    path = save(tmp_path, "run.csv", f"Time [s],travel [mm]\n{rows}\n")
    found = read(path, parse_mapping(understand(path, {"resample_hz": "100"}).text(), path))
    write(found, tmp_path / "own.csv")
    assert read(tmp_path / "own.csv").notes == found.notes


def test_an_answer_that_is_no_rate_is_a_line(tmp_path):
    path = save(tmp_path, "run.csv", "Time [s],x [m]\n0,1\n0.1,2\n0.2,3\n")
    for wrong in ("fast", "0", "-1", "nan"):
        with pytest.raises(ExchangeError, match="is no number of samples a second"):
            understand(path, {"resample_hz": wrong})


def test_the_ends_of_a_large_file_are_not_held_to_be_next_to_each_other(tmp_path, monkeypatch):
    """Time stops for half a step in between, which only reading sees."""
    stamps = [0.01 * k + 0.005 * (k > 2000) for k in range(4000)]
    rows = "\n".join(f"{t:.3f},{k % 7},{'x' * 60}" for k, t in enumerate(stamps))
    path = save(tmp_path, "run.csv", f"# a\n# b\nTime [s],z [m],note\n{rows}\n")
    monkeypatch.setattr(cells, "BEGIN_BYTES", 20_000)
    monkeypatch.setattr(cells, "END_BYTES", 10_000)
    assert cells.read_ends(path).passed_over > 1000
    assert not understand(path).questions
