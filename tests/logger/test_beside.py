"""Inputs beside the eight: what a reader makes of records of pulses, marks and a temperature."""

import numpy as np
import pytest

from tests.logger.session import SESSION, session
from wheelhop.cli.main import main
from wheelhop.logger.beside import RECORD, joined, with_beside
from wheelhop.logger.block import BESIDE, CRC_AT, crc, pack_block
from wheelhop.logger.correct import correct_clock
from wheelhop.logger.read import read_log
from wheelhop.logger.settings import Settings

SETTINGS = Settings(100, 8, ((0, "B1"),))
STEP_S = 156.25e-6
EVERY = 10


def payload(first, rows):
    """A block's, of records (pulses, since, temperature, marks)."""
    records = np.array([(*row, 0) for row in rows], RECORD)
    return (first.to_bytes(4, "little") + bytes([EVERY, len(rows)]) + records.tobytes()).ljust(
        486, b"\0"
    )


def seen(pulse_times, count, **more):
    """What the firmware says in `count` records of pulses at these times."""
    rows = []
    for k in range(1, count + 1):
        end = k * EVERY * 64 - 1
        before = [int(t / STEP_S) for t in pulse_times if int(t / STEP_S) <= end]
        since = min(end - before[-1], 65535) if before else 65535
        rows.append(
            (len(before) % 65536, since, more.get("code", 0), more.get("marks", lambda k: 0)(k))
        )
    return joined([payload(EVERY, rows)], SETTINGS, {"pulses_per_km": more.get("per_km", "1000")})


def test_speed_is_exact_between_pulses_however_they_fall_into_records():
    times = np.cumsum(np.full(40, 0.137))  # 7.3 a second, at no round time
    beside = seen(times, 50)
    inside = beside.time_s[(beside.time_s > 0.3) & (beside.time_s < 4.8)]
    assert beside.speed_m_s(inside) == pytest.approx(1 / 0.137, rel=2e-3)


def test_a_wheel_that_stops_is_not_said_to_go_on():
    beside = seen([0.1, 0.2, 0.3, 0.4, 3.4, 3.5, 3.6], 60)
    speed = beside.speed_m_s(np.array([0.25, 2.0, 3.45, 3.9, 5.5]))
    assert speed[[0, 2]] == pytest.approx(10.0, rel=3e-3)
    assert speed[1] == 0.0 and speed[4] == 0.0 and 3.0 < speed[3] < 3.6  # one more would have come


def test_counts_go_round_and_a_gap_of_records_invents_nothing():
    rows = [(65530, 10, 0, 254), (65535, 10, 0, 255), (4, 10, 0, 0)]
    beside = joined([payload(10, rows[:1]), payload(50, rows[1:])], SETTINGS, {})
    assert list(beside.scan) == [10, 50, 60]
    assert list(np.diff(beside.pulses)) == [5, 5] and list(np.diff(beside.marks)) == [1, 1]


def test_temperature_is_a_tmp36s_and_nothing_where_none_is_connected():
    assert seen([], 5, code=233).temperature_c(np.zeros(1)) == pytest.approx([25.09], abs=0.01)
    for code in (0, 30, 544, 1023):  # beyond -40 and 125 °C
        assert np.isnan(seen([], 5, code=code).temperature_c(np.zeros(1))).all()
    assert seen([], 5, code=0).found == () and seen([], 5, code=32).found == ("temperature",)


def test_a_log_has_them_as_channels_and_its_scans_are_as_without():
    rows = [(k, 3, 233, k > 4) for k in range(60)]
    log = read_log(with_records(np.full((600, 8), 4000), rows))
    assert (log.written, log.due, log.damage) == (600, 600, ())
    assert log.beside is not None and log.beside.marks_s == pytest.approx([0.6], abs=0.01)
    assert log.notes["marks_s"] == "0.6"
    recording = with_beside(log.recording(), log.beside, log.recording().time_s)
    assert [c.name for c in recording.channels[8:]] == ["pulses", "temperature"]
    assert [c.unit for c in recording.channels[8:]] == ["Hz", "°C"]
    assert recording["pulses"][200] == pytest.approx(10.0) and (recording["B1"] == 500).all()
    slow = log.recording()
    own_s = slow.time_s
    slow = correct_clock(slow.after("", notes={**slow.notes, "clock_ppm": "20000"}))
    assert with_beside(slow, log.beside, own_s)["pulses"][200] == pytest.approx(10 / 1.02)


def one_further(block):
    """The same block, a place further on in the file."""
    body = block[:12] + (int.from_bytes(block[12:16], "little") + 1).to_bytes(4, "little")
    body += block[16:CRC_AT]
    return body + crc(body).to_bytes(2, "little")


def with_records(sums, rows, **header):
    """A log with these sums and a block of records, as the Mega writes it."""
    data = session(sums, **header)
    plain = [data[at : at + 512] for at in range(0, len(data), 512)]
    first = int.from_bytes(plain[3][16:20], "little")
    extra = pack_block(BESIDE, SESSION, 3, first_scan=first, payload=payload(10, rows))
    return b"".join([*plain[:3], extra, *map(one_further, plain[3:])])


def test_a_campaign_takes_the_speed_and_stretches_have_the_marks(tmp_path, capsys):
    rng = np.random.default_rng(3)
    driving = np.concatenate([np.zeros(400), np.ones(1400), np.zeros(400)])[:, None]
    sums = 4248 + rng.normal(0, 1, (2200, 8)) + driving * rng.normal(0, 400, (2200, 8))
    rows = [(4 * k, 3, 233, (k > 10) + (k > 50)) for k in range(60)]
    log = tmp_path / "HOP00012.HOP"
    header = {"beside": "mark pulses temperature", "pulses_per_km": 4000, "calibration": ""}
    log.write_bytes(with_records(np.clip(sums, 0, 8184).astype(int), rows, **header))
    assert main(["campaign", "stretches", str(log), "--nominal"]) == 0
    printed = capsys.readouterr().out
    assert "marks: 1 at 1.2 s, 2 at 5.2 s" in printed
    (row,) = [line.split() for line in printed.splitlines() if line.split()[:1] == ["1"]]
    assert row[-1] == "2" and float(row[1]) > 1.2
    folder = tmp_path / "mine"
    place = ["--place", "speed=speed"]
    assert main(["campaign", "new", str(folder), str(log), "--nominal", *place]) == 0
    add = ["campaign", "add", str(folder), str(log), "--nominal", "--id", "a", "--track", "unknown"]
    assert main([*add, "--from", "3.8", "--to", "5.9"]) == 0
    text = (folder / "campaign.toml").read_text()
    assert "speed_kmph = 36.0" in text and 'quantity = "speed"' in text  # 40 Hz of 0.25 m
