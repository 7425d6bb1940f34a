"""Time stamps become a grid: rounded, jittering or with gaps, or they do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.files.units import to_si
from wheelhop.formats import ExchangeError
from wheelhop.formats.grid import fit_grid, too_few
from wheelhop.formats.labels import name_and_unit

RATES = (1.0, 10.0, 50.0, 100.0, 128.0, 200.0, 256.0, 400.0, 1000.0, 1024.0, 51200.0, 99.97)


def place(row):
    return f"line {row + 2}"


@given(
    rate=st.sampled_from(RATES),
    start=st.floats(-100.0, 1e5),
    runs=st.lists(st.tuples(st.integers(2, 9), st.integers(2, 50)), max_size=9),
)
def test_gaps_are_whole_steps_and_the_rate_is_the_round_one(rate, start, runs):
    steps = [step for length, gap in runs for step in (*[1] * length, gap)]
    index = np.cumsum([0, *steps, 1])
    time_s = start + index / rate
    try:
        grid = fit_grid(time_s, place)
    except ExchangeError as asked:  # many steps of two units: stamps may have been rounded
        assert "say rate_hz" in str(asked)
        grid = fit_grid(time_s, place, rate)
    assert grid.index.tolist() == index.tolist()
    assert grid.rate_hz == pytest.approx(rate, rel=1e-6)
    assert grid.start_s == pytest.approx(start, abs=1e-2 / rate)
    values = np.arange(2.0 * len(index)).reshape(-1, 2)
    spread = grid.spread(values)
    assert (spread[index] == values).all()
    assert int(np.isnan(spread).all(axis=1).sum()) == int(index[-1]) + 1 - len(index)


@pytest.mark.parametrize(("rate", "digits"), [(128.0, 3), (400.0, 3), (100.0, 2), (1024.0, 6)])
def test_stamps_that_were_rounded_give_the_true_rate(rate, digits):
    time_s = np.round(np.arange(4000) / rate, digits)
    grid = fit_grid(time_s, place)
    assert grid.rate_hz == rate
    assert grid.rows == 4000


def test_jitter_is_taken_as_equal_steps_and_stated():
    rng = np.random.default_rng(3)
    time_s = np.arange(3000) / 100 + rng.uniform(-5e-4, 5e-4, 3000)
    grid = fit_grid(time_s, place)
    assert grid.rows == 3000 and grid.rate_hz == pytest.approx(100.0, rel=1e-5)
    (remark,) = grid.remarks()
    assert "up to 0.5" in remark and "ms off equal steps of 10 ms" in remark


def test_clean_stamps_start_at_the_first_one_to_the_last_bit():
    """As far as six digits go."""
    grid = fit_grid(np.round(12.34 + np.arange(3000) / 128.0, 6), place)
    assert grid.start_s == 12.34 and grid.remarks() == ()


def test_stamps_that_jitter_start_where_they_do_on_the_whole():
    time_s = np.arange(3000) / 100 + np.random.default_rng(3).uniform(-5e-4, 5e-4, 3000)
    time_s[0] = 5e-4
    assert fit_grid(time_s, place).start_s == pytest.approx(0.0, abs=5e-5)


def test_a_step_may_be_off_by_a_quarter():
    assert fit_grid(np.array([0.0, 1.0, 2.25]), place, 1.0).index.tolist() == [0, 1, 2]


def test_a_given_rate_may_lose_half_a_step_on_the_way():
    """At 99.9 Hz stamps of 100 Hz are half a step late after 500."""
    time_s = np.arange(600) / 100
    assert fit_grid(time_s[:400], place, 99.9).rows == 400
    with pytest.raises(ExchangeError, match=r"equal steps at 99\.9 Hz"):
        fit_grid(time_s, place, 99.9, 0.0)


def test_a_clock_that_is_a_little_slow_is_not_rounded_away():
    """By a tenth of a thousandth: rounded to milliseconds that is seen after 22 s."""
    time_s = np.round(np.arange(2200) / 99.99, 3)
    assert fit_grid(time_s, place).rate_hz == pytest.approx(99.99, abs=2e-3)


def test_single_samples_that_are_lost_do_not_stretch_the_period():
    """Every fourth, at 400 Hz and in milliseconds."""
    index = np.array([k for k in range(400) if k % 4 != 3])
    grid = fit_grid(np.round(index / 400, 3), place)
    assert grid.rate_hz == 400.0 and grid.index.tolist() == index.tolist()


def test_so_much_may_be_missing():
    """Up to a hundred thousand samples, or nine of ten."""
    grid = fit_grid(np.array([0.0, 1.0, 2.0, 100_003.0]), place, 1.0)
    assert grid.rows == 100_004
    assert not too_few(20_000, 200_000) and too_few(20_000, 200_001)


@pytest.mark.parametrize(("off_s", "said"), [(1.5e-5, 1), (0.6e-5, 0)])
def test_up_to_a_thousandth_of_a_step_is_not_worth_a_word(off_s, said):
    time_s = np.arange(100) / 100.0
    time_s[50] += off_s
    assert len(fit_grid(time_s, place, 100.0, 0.0).remarks()) == said


def test_what_is_missing_is_counted():
    index = np.delete(np.arange(100), [10, 11, 12, 50])
    grid = fit_grid(index / 100, place)
    assert grid.remarks() == ("samples missing in the time stamps: 4, in gaps: 2; left empty",)


@pytest.mark.parametrize(
    ("time_s", "rate", "line"),
    [
        ([0, 0.01, 0.02, 0.02], None, "line 5: time does not rise"),
        ([0, 0.01, 0.02, 0.0345], None, r"line 5: time jumps .* 1\.45 steps of 0\.01 s"),
        ([0, 0.01, 0.02, 0.03], 200.0 / 3, "line 3: time jumps"),
        ([0, 0.01, 0.02, 1e8], None, "line 5: 1e[+]10 samples are missing"),
        ([0, np.inf], None, "line 3: inf is no time"),
        ([0, 1e15], None, r"line 3: 1000000000000000\.0 is no time"),
        ([0, 1, 1.1, 2], 1.0, r"line 4: time jumps from 1 to 1\.1 s, 0\.1 steps"),
        ([0, 1, 2.25, 3.6], 1.0, r"line 5: time jumps from 2\.25 to 3\.6 s, 1\.35 steps"),
        ([0, 1, 2, 100_004], 1.0, r"line 5: 100001 samples are missing, .* \(2 to 100004 s\)"),
        ([3.0], None, "a single time stamp has no rate"),
        (
            np.arange(2000) * 0.01,
            99.9,
            "equal steps at 99.9 Hz; on the whole the stamps go at 100 Hz",
        ),
    ],
)
def test_stamps_on_no_grid_are_named(time_s, rate, line):
    with pytest.raises(ExchangeError, match=line):
        fit_grid(np.array(time_s, dtype=float), place, rate)


@pytest.mark.parametrize(
    ("unit", "si", "factor"),
    [
        ("g", "m/s²", 9.80665),
        ("mg", "m/s²", 9.80665e-3),
        ("m/s^2", "m/s²", 1.0),
        ("mm/s2", "m/s²", 1e-3),
        ("mV", "V", 1e-3),
        ("km/h", "m/s", 1 / 3.6),
        ("kN", "N", 1e3),
        ("G", "m/s²", 9.80665),  # AiM, MoTeC, RaceCapture
        ("m/s/s", "m/s²", 1.0),
        ("lbs", "N", 4.4482216152605),
        ("in/s", "m/s", 0.0254),
        ("MPH", "m/s", 0.44704),
        ("Km/h", "m/s", 1 / 3.6),
        ("Inch", "m", 0.0254),
        ("furlong", "furlong", 1.0),
        ("code", "code", 1.0),
        ("", "", 1.0),
    ],
)
def test_units_become_si_and_unknown_ones_stay(unit, si, factor):
    assert to_si(unit) == (si, pytest.approx(factor))


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("Acc FL [g]", "Acc FL", "g"),
        ("Acc FL (m/s^2)", "Acc FL", "m/s^2"),
        ("Acc (left)", "Acc (left)", ""),
        ("Weg / mm", "Weg", "mm"),
        ("front / rear", "front / rear", ""),
        ("Acc []", "Acc", ""),
        ("acc_m_s2", "acc", "m/s²"),
        ("time_s", "time", "s"),
        ("A1", "A1", ""),
        ("_g", "_g", ""),
    ],
)
def test_units_behind_names(label, name, unit):
    assert name_and_unit(label) == (name, unit)
