"""Scans behind late triggers are at their times (SPEC.md, "Scans"), in rows at equal steps."""

from argparse import Namespace

import numpy as np
import pytest

from tests.logger.session import session
from wheelhop.cli import decode
from wheelhop.formats import read
from wheelhop.logger import read_log
from wheelhop.logger.late import at_equal_steps

CONVERSION_S = 156.25e-6
FREQUENCY_HZ = 12.0
SLOPE = 2 * np.pi * FREQUENCY_HZ * 400  # codes a second


def signal(time_s):
    return 512 + 400 * np.sin(2 * np.pi * FREQUENCY_HZ * time_s)


def recorded(scans, late, rate=100, **options):
    """A session in which `late` maps scans to the triggers that were late before them."""
    conversions = 800 // rate
    before = np.zeros(scans)
    for scan, count in late.items():
        before[scan:] += count
    numbers = np.arange(scans)
    time_s = numbers / rate + ((8 * conversions - 1) / 2 + before) * CONVERSION_S
    sums = np.repeat(np.rint(conversions * signal(time_s))[:, None], 8, axis=1).astype(int)
    events = [scan for scan, count in late.items() for _ in range(count)]
    return session(sums, late=events, rate_hz=rate, conversions=conversions, **options)


def off(recording):
    """How far rows are from the signal at their times, in codes; NaN where they are missing."""
    return np.abs(recording.values - signal(recording.time_s)[:, None]).max(axis=1)


@pytest.mark.parametrize("rate", [100, 200, 400])
@pytest.mark.parametrize("late", [{700: 3}, {50: 5, 800: 7}, {k: 1 for k in range(40, 900, 7)}])
def test_rows_are_the_signal_at_their_times(rate, late):
    data = recorded(1000, late, rate)
    recording = read_log(data).recording()
    # Where in a block it happened is not known: half of what it counts.
    most = max(sum(late.get(k + j, 0) for j in range(37)) for k in range(1000))
    limit = 1.0 + SLOPE * CONVERSION_S * most / 2 * 1.3
    assert np.nanmax(off(recording)[5:-5]) < limit
    assert recording.missing.sum() == 0
    last_s = (999 / rate) + sum(late.values()) * CONVERSION_S
    assert recording.time_s[-1] == pytest.approx(recording.start_s + last_s, abs=1 / rate)
    by_number = read_log(data).recording(by_number=True)
    assert off(by_number)[-50:].max() > 1.2 * limit


def test_a_healthy_session_is_not_touched():
    log = read_log(recorded(300, {}))
    assert np.array_equal(log.recording().values, log.recording(by_number=True).values)


@pytest.mark.parametrize("part", [0.1, 0.3, 0.6, 0.75])
@pytest.mark.parametrize("steps", [1 / 64, 0.5, 0.9, 3.25])
def test_a_fraction_of_a_step_is_a_delay_in_band(part, steps):
    rows = np.arange(400)
    shift = np.where(rows < 200, 0.0, steps)
    turn = np.pi * part
    moved = at_equal_steps(np.sin(turn * (rows + shift))[:, None], shift)[:, 0]
    wanted = np.sin(turn * np.arange(len(moved)))
    inside = np.r_[70:130, 270:330]
    assert np.abs(moved - wanted)[inside].max() < 2e-3
    gone = np.flatnonzero(np.isnan(moved))
    if steps < 0.5:
        assert len(gone) == 0
        assert np.abs(moved - wanted)[70:330].max() < 3 * turn * steps
    else:
        assert 199 + steps - 1 <= len(gone) + 199 <= 200 + steps
        assert set(gone) <= set(range(200, 200 + int(np.ceil(steps))))


def test_gaps_stay_gaps():
    data = recorded(600, {100: 6, 350: 12}, lost=[300, 301, 420])
    recording = read_log(data).recording()
    assert 3 <= recording.missing.sum() <= 5
    gone_s = recording.time_s[recording.missing] - recording.start_s
    assert ((np.abs(gone_s - 3.01) < 0.03) | (np.abs(gone_s - 4.2) < 0.03)).all()
    there = ~recording.missing
    there[:5] = there[-5:] = False
    assert off(recording)[there].max() < 1 + SLOPE * CONVERSION_S * 6 * 1.2


def test_parts_of_a_log_go_on_where_the_one_before_ends(tmp_path, monkeypatch):
    monkeypatch.setattr(decode, "PART_SCANS", 300)
    file = tmp_path / "HOP00012.HOP"
    file.write_bytes(recorded(1000, {k: 1 for k in range(20, 1000, 3)}, clock_ppm=""))
    asked = Namespace(
        files=[file], out=None, format=None, calibration=None, header_from=None, scans=None,
        raw=False, sensor_hz=None, force=False,
    )  # fmt: skip
    assert decode.run(asked) == 0
    parts = [read(tmp_path / f"HOP00012-{k:03d}.csv") for k in range(1, 5)]
    time_s = np.concatenate([part.time_s for part in parts])
    assert np.diff(time_s).min() > 0 and np.diff(time_s).max() < 0.02
    assert len(time_s) == pytest.approx(1000 + 327 / 64, abs=4)


def test_a_count_at_its_end_says_that_times_are_unknown():
    log = read_log(session(np.full((100, 8), 4000), late=[50] * 70000))
    assert log.late == 65535
    assert any("times at the end are unknown" in step for step in log.recording().history)
