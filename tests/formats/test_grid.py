"""Time stamps become a grid: rounded, jittering or with gaps, or they do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.files.units import to_si
from wheelhop.formats import ExchangeError
from wheelhop.formats.grid import fit_grid
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
    grid = fit_grid(start + index / rate, place)
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
        ("acc_m_s2", "acc", "m/s²"),
        ("time_s", "time", "s"),
        ("A1", "A1", ""),
        ("_g", "_g", ""),
    ],
)
def test_units_behind_names(label, name, unit):
    assert name_and_unit(label) == (name, unit)
