"""Time of tables as loggers write it: at the right rate, or asked for."""

import numpy as np
import pytest

from tests.formats.foreign import G
from tests.formats.logged import ROWS, WAVE, drafted, table, units_of
from wheelhop.formats import Map, draft_mapping, read, understand

START = 1762640265216  # 2025-11-08T22:17:45.216Z, ms


def assert_right(found, rate_hz=100.0, rows=ROWS, missing=0):
    """All the rows, at their rate, and the samples that were written, in g."""
    assert not isinstance(found, str), found
    assert (found.rate_hz, len(found.values)) == (pytest.approx(rate_hz, rel=1e-6), rows)
    assert int(found.missing.sum()) == missing
    there = found.values[~found.missing, 0]
    assert there[:150] == pytest.approx(np.array([float(f"{w:.4f}") for w in WAVE[:150]]) * G)


@pytest.mark.parametrize(
    ("head", "stamp"),
    [
        ("Elapsed [ms],az [g]", lambda k: 1000 + 10 * k),
        ("elapsed_ms,az [g]", lambda k: 1000 + 10 * k),
        ("millis,az [g]", lambda k: 1000 + 10 * k),
        ("Time since start in ms,az [g]", lambda k: 1000 + 10 * k),
        ("timestampMs,az [g]", lambda k: 10 * k),
        ("micros,az [g]", lambda k: 10000 * k),
        ("time_us,az [g]", lambda k: 10000 * k),
        ("t_ns,az [g]", lambda k: 10**7 * k),
        ("Zeit / ms,az [g]", lambda k: 10 * k),
        ("Timestamp (microseconds),az [g]", lambda k: 10000 * k),
        ("seconds,az [g]", lambda k: f"{k / 100:.2f}"),
        ("Time (min),az [g]", lambda k: f"{k / 6000:.9f}"),
        ("Time,az\nms,g", lambda k: 10 * k),
        ("Time,az\n[ms],[g]", lambda k: 10 * k),
        ("Uptime MSec,az [g]", lambda k: 10 * k),
    ],
)
def test_the_unit_of_time_is_read_wherever_it_stands(head, stamp, tmp_path):
    assert_right(drafted(tmp_path, table(stamp, head)))


@pytest.mark.parametrize(
    ("head", "stamp"),
    [
        ("time,az [g]", lambda k: START + 10 * k),
        ("time,az [g]", lambda k: (START + 10 * k) * 1000),
        ("time,az [g]", lambda k: (START + 10 * k) * 10**6),
        ("time,az [g]", lambda k: f"{(START + 10 * k) / 1000:.3f}"),
        ("timestamp_ms,az [g]", lambda k: START + 10 * k),
        ("unix time [s],az [g]", lambda k: f"{(START + 10 * k) / 1000:.3f}"),
        ("time,az [g],seconds_elapsed", lambda k: (START + 10 * k) * 10**6),
    ],
)
def test_seconds_since_1970_are_told_by_their_size(head, stamp, tmp_path):
    text = table(stamp, head)
    if "elapsed" in head:
        first, *rows = text.splitlines()
        text = "\n".join([first, *(f"{row},{0.05 + k / 100:.6f}" for k, row in enumerate(rows))])
    found = drafted(tmp_path, text)
    assert_right(found)
    assert found.start_unix_s == pytest.approx(START / 1000, abs=1e-3)
    assert [channel.name for channel in found.channels] == ["az"]  # the other clock is none


def clock(k, form):
    """Row k of 100 Hz, 7 s before the hour."""
    hundredths = k - 700 + 360_000
    return form.format(
        h=9 + hundredths // 360_000, m=hundredths // 6000 % 60, s=hundredths // 100 % 60,
        f=hundredths % 100,
    )  # fmt: skip


@pytest.mark.parametrize(
    "form",
    [
        "{m:02}:{s:02}.{f:02}",
        "{m}:{s:02}.{f:02}0",
        "{h:02}:{m:02}:{s:02}.{f:02}",
        "{h}:{m:02}:{s:02}.{f:02}0 AM",
        "{h:02}:{m:02}:{s:02}:{f:02}0",
        "2025-06-14 {h:02}:{m:02}:{s:02}.{f:02}",
        "2025-06-14T{h:02}:{m:02}:{s:02}.{f:02}Z",
        "2025/06/14 {h:02}:{m:02}:{s:02}.{f:02}0",
        "14.06.2025 {h:02}:{m:02}:{s:02}.{f:02}",
        "6/14/2025 {h}:{m:02}:{s:02}.{f:02} AM",
        "14-Jun-2025 {h:02}:{m:02}:{s:02}.{f:02}",
    ],
)
def test_dates_and_times_of_day(form, tmp_path):
    """Across a full hour, too: minutes and seconds alone begin again there."""
    assert_right(drafted(tmp_path, table(lambda k: clock(k, form), rows=1000)), rows=1000)


def test_a_clock_goes_on_after_midnight_and_the_history_says_so(tmp_path):
    def stamp(k):
        hundredths = (k - 100) % 8_640_000
        minutes, seconds = hundredths // 6000, hundredths % 6000 / 100
        return f"{minutes // 60:02}:{minutes % 60:02}:{seconds:05.2f}"

    found = drafted(tmp_path, table(stamp))
    assert_right(found)
    assert "the clock passes midnight at line 102: counted on" in found.history


@pytest.mark.parametrize("head", ["UTC,az [g]", "Time,az [g]"])
def test_a_time_of_day_in_one_number(head, tmp_path):
    """59.99 is followed by 100.00; as seconds, 40 s would be missing."""

    def stamp(k):
        hundredths = 5900 + k
        return f"1021{hundredths // 6000:02}{hundredths % 6000 / 100:05.2f}".replace(
            "1021", "10", 1
        )

    text = table(stamp, head)
    assert_right(drafted(tmp_path, text))
    assert 'time_unit = "hhmmss"' in draft_mapping(tmp_path / "run.csv")


def test_days_of_a_spreadsheet(tmp_path):
    found = drafted(tmp_path, table(lambda k: f"{45822.5 + k / 8_640_000:.9f}", "Date,az [g]"))
    assert_right(found)


@pytest.mark.parametrize(
    ("rate", "digits"), [(400, 3), (300, 3), (666.6666, 3), (1600, 4), (240, 3), (90, 2)]
)
def test_stamps_that_were_rounded_are_on_equal_steps(rate, digits, tmp_path):
    """Even where their steps alternate between one and two of the last digit."""
    found = drafted(tmp_path, table(lambda k: f"{k / rate:.{digits}f}", "Time [s],az [g]"))
    assert not isinstance(found, str), found
    assert (found.rate_hz, len(found.values)) == (pytest.approx(rate, rel=3e-3), ROWS)
    assert not found.missing.any()


@pytest.mark.parametrize(
    ("head", "stamp", "asked"),
    [
        ("time [s],az [g]", lambda k: f"{k / 128:.2f}", "rate_hz"),  # several rows share a stamp
        ("Time,az [g]", lambda k: f"10:21:{k // 100:02}", "rate_hz"),
        ("time,az [g]", lambda k: 10 * k, "time_unit"),  # ms?
        ("time,az [g]", lambda k: f"{k / 2:.1f}", "time_unit"),  # ms at 2 kHz?
        ("time,az [g]", lambda k: k, "time_unit"),
        ("time [s],az [g]", lambda k: 10 * k, "time_unit"),  # 0.1 Hz
        ("time [us],az [g]", lambda k: k, "time_unit"),  # 1 MHz
        ("time,az [g]", lambda k: 20250614102100 + k, "time_unit"),
        ("Time,az [g]", lambda k: f"{3845485065.25 + k / 100:.2f}", "time_unit"),  # since 1904
        ("Time (0.1 ms),az [g]", lambda k: 100 * k, "time_unit"),
        ("time [10 us],az [g]", lambda k: 1000 * k, "time_unit"),
        ("time [ticks],az [g]", lambda k: k, "time_unit"),
        ("Distance,az [g]", lambda k: f"{k / 10:.1f}", "time_unit"),
        ("pos,az [g]", lambda k: k, "time_unit"),
        ("count,az [g]", lambda k: k, "rate_hz"),
        ("Sample,az [g]", lambda k: k % 256, "rate_hz"),
        ("Distance [m],az [g]", lambda k: f"{k / 10:.1f}", "rate_hz"),
        ("ay [g],az [g]", lambda k: f"{WAVE[k]:.4f}", "rate_hz"),
        ("Time,az [g]", lambda k: f"00:{k % 60:02}", "time_unit"),
    ],
)  # fmt: skip
def test_what_is_not_known_is_asked_for(head, stamp, asked, tmp_path):
    found = drafted(tmp_path, table(stamp, head))
    assert isinstance(found, str), found
    assert f"still to be answered: {asked} = …" in found


COUNTED = "# Config: data_rate = 2000.0 Hz, filter = 488 Hz\n"


@pytest.mark.parametrize(
    ("above", "rate"),
    [
        (COUNTED, 2000.0),
        ("Sampling freqeuncy: 500 Hz\n", 500.0),
        ("Abtastrate;1,5 kHz\n", 1500.0),
        ('"Sample Rate","100.000","Hz"\n', 100.0),
        ("Sample interval: 10 ms\n", 100.0),
        ("Sampling rate: 200 Hz\nScan rate = 200 Hz\n", 200.0),
    ],
)
def test_a_counter_is_a_counter_at_the_rate_that_the_header_states(above, rate, tmp_path):
    """And its gaps are kept."""
    text = table(lambda k: k + 1, "count,az [g]", above=above, without=range(200, 230))
    found = drafted(tmp_path, text)
    assert_right(found, rate, missing=30)
    assert found.start_s == 0.0


def test_a_counter_that_begins_again_is_counted_on(tmp_path):
    text = table(lambda k: k % 256, "seq,az [g]", above=COUNTED, without=range(256, 266))
    found = drafted(tmp_path, text)
    assert_right(found, 2000.0, missing=10)
    assert "the counter begins again at line 259: counted on" in found.history


def test_two_rates_in_the_header_or_one_that_the_stamps_belie_are_asked_about(tmp_path):
    text = table(lambda k: k, "count,az [g]", above="Scan rate: 100 Hz\nOutput rate: 50 Hz\n")
    assert "still to be answered: rate_hz" in drafted(tmp_path, text)
    text = table(lambda k: f"{k / 50:.2f}", "Time [s],az [g]", above="Sample rate: 100 Hz\n")
    assert "still to be answered: rate_hz" in drafted(tmp_path, text)
    assert "line 1 says 100 Hz, the stamps go at 50 Hz" in draft_mapping(tmp_path / "run.csv")


def test_two_clocks_of_different_rates_are_asked_about(tmp_path):
    text = table(lambda k: f"{k / 100:.2f},{12 * k}", "Time [s],Clock [ms],az [g]")
    assert "still to be answered: rate_hz" in drafted(tmp_path, text)


def test_a_mapping_may_leave_the_unit_of_time_to_the_file_and_not_more(tmp_path):
    path = tmp_path / "run.csv"
    path.write_text(table(lambda k: 10 * k, "Elapsed [ms],az [g]"))
    assert read(path, Map(time="Elapsed [ms]")).rate_hz == 100.0
    belied = read(path, Map(time="Elapsed [ms]", time_unit="us"))
    assert belied.rate_hz == 1e5
    assert "Elapsed [ms]: the file says ms, the mapping us" in belied.history
    path.write_text(table(lambda k: 10 * k, "Elapsed,az [g]"))
    with pytest.raises(
        ValueError, match=r"line 2: the unit of Elapsed is not said, .*: say time_unit"
    ):
        read(path, Map(time="Elapsed"))


def test_a_spectrum_is_told_to_be_one(tmp_path):
    text = table(lambda k: f"{k / 2:.1f}", "Frequency [Hz],PSD [g]")
    assert "Frequency [Hz] rises evenly, in Hz: this is a spectrum, no" in drafted(tmp_path, text)


def test_channels_with_times_of_their_own_are_refused(tmp_path):
    """Even at one rate: they were not sampled together."""
    head = "Time [s],A1 [g],Time [s],B1 [g]"
    for rate, since in ((50, 0.0), (100, 0.003)):
        text = table(lambda k, r=rate, s=since: f"{k / 100:.2f},1,{s + k / r:.3f}", head)
        assert "Time [s] (column 1) and Time [s] (column 3) differ" in drafted(tmp_path, text)
    same = table(lambda k: f"{k / 100:.2f},1,{k / 100:.2f}", head)
    assert [channel.name for channel in drafted(tmp_path, same).channels] == ["A1", "B1"]


def test_uneven_steps_are_told_and_not_cut(tmp_path):
    text = table(lambda k: f"{k / 100 + 0.004 * WAVE[(k * k) % ROWS]:.6f}", "Time [s],az [g]")
    assert "still to be answered: resample_hz" in drafted(tmp_path, text)
    asked = understand(tmp_path / "run.csv").questions
    assert [question.key for question in asked] == ["resample_hz"]
    assert "time goes on in uneven steps, 0.0" in asked[0].words


def test_a_column_of_row_numbers_is_no_channel(tmp_path):
    found = drafted(tmp_path, table(lambda k: f"{k},{k / 100:.2f}", ",Time [s],az [g]"))
    assert_right(found)
    assert len(found.channels) == 1


def racecapture(rows=400):
    """A log of RaceCapture's own layout: rates of 100, 10 and 1 a second, and a lap's time."""
    head = (
        '"Interval"|"ms"|0|0|1,"AccelZ"|"G"|-3.0|3.0|100,"Speed"|"MPH"|0.0|150.0|10,'
        '"Battery"|"Volts"|0.0|20.0|1,"LapTime"|"Min"|0.0|0.0|10'
    )
    lines = [
        f"{1000 + 10 * k},{WAVE[k % ROWS]:.4f},{30 + k / 100 if k % 10 == 0 else ''},"
        f"{12.5 if k % 100 == 0 else ''},{k % 150 / 6000 + 1 if k % 10 == 0 else ''}"
        for k in range(rows)
    ]
    return "\n".join([head, *lines]) + "\n"


def test_racecapture_says_units_and_rates_in_its_first_line(tmp_path):
    found = drafted(tmp_path, racecapture(), "run.log")
    assert not isinstance(found, str), found
    assert found.rate_hz == 100.0 and len(found.values) == 400
    assert {channel.name: channel.unit for channel in found.channels} == {
        "AccelZ": "m/s²",
        "Speed": "m/s",
        "Battery": "V",
        "LapTime": "Min",
    }
    assert found.values[:ROWS, 0] == pytest.approx(np.round(WAVE, 4) * G)
    assert int((~np.isnan(found.values[:, 1])).sum()) == 40
    whole = understand(tmp_path / "run.log", {"resample_hz": "100"})
    taken = read(tmp_path / "run.log", whole.mapping())
    exact = (30 + np.arange(391) / 100) * 0.44704
    assert taken.values[:391, 1] == pytest.approx(exact)
    assert np.isnan(taken.values[391:, 1]).all()  # behind its last sample


def test_a_clock_that_begins_again_belies_no_other(tmp_path):
    """The time of a lap goes at the same rate, and that of a sector at none."""
    text = table(lambda k: f"{k / 100:.2f},{k % 100 / 30:.3f}", "Time [s],Lap time [s],az [g]")
    assert_right(drafted(tmp_path, text))
    text = table(lambda k: f"{k / 100:.2f},{k / 30:.3f}", "Time [s],Lap time [s],az [g]")
    assert "still to be answered: rate_hz" in drafted(tmp_path, text)


def test_rows_that_share_a_stamp_now_and_then_are_asked_about(tmp_path):
    text = table(lambda k: f"{(k - (k > 200)) / 100:.2f}", "Time [s],az [g]")
    assert "still to be answered: resample_hz" in drafted(tmp_path, text)
    asked = understand(tmp_path / "run.csv").questions[0].words
    assert "time stamps are rounded to 0.01 s, too coarse to tell the rate" in asked
    text = table(lambda k: f"{(k - (k > 200)) * 0.0123:.4f}", "Time [s],az [g]")
    assert "still to be answered: resample_hz" in drafted(tmp_path, text)
    asked = understand(tmp_path / "run.csv").questions[0].words
    assert "line 203: time does not rise, from 2.46 to 2.46 s" in asked


def test_a_column_without_a_name_that_counts_since_1970_is_time_by_guess(tmp_path):
    text = table(lambda k: START + 10 * k, head="", rows=ROWS)
    assert drafted(tmp_path, text).rate_hz == 100.0
    assert understand(tmp_path / "run.csv").guesses == ("column 1 is ms since 1970",)


@pytest.mark.parametrize(
    ("name", "guessed"), [("z_g", True), ("acc_m_s2", False), ("az [g]", False)]
)
def test_a_unit_of_one_letter_behind_a_name_is_a_guess(name, guessed, tmp_path):
    drafted(tmp_path, table(lambda k: f"{k / 100:.2f}", f"Time [s],{name}"))
    said = understand(tmp_path / "run.csv").guesses
    assert said == ((f"{name} is in g, by the end of its name",) if guessed else ())


@pytest.mark.parametrize(
    "head",
    [
        *("Shaft speed in/sec", "Revs per sec", "Travel per seconds", "Temperature T"),
        *("Elapsed distance", "Clock angle", "Time x10ms", "Time_0.1s", "Time (ticks)"),
    ],
)
def test_what_is_no_time_or_in_another_unit_is_not_taken_for_seconds(head, tmp_path):
    text = table(lambda k: f"{k / 100:.2f}", f"{head},az [g]")
    assert "still to be answered: time_unit" in drafted(tmp_path, text)


@pytest.mark.parametrize(
    ("head", "apart"),
    [
        *(("Time A1 [s],A1 [g],Time B1 [s],B1 [g]", s) for s in (0.0, 0.004, 0.5)),
        *(("time,A1 [g],time.1,B1 [g]", s) for s in (0.0, 0.5)),
    ],
)
def test_channels_with_clocks_of_other_names_are_not_put_in_step(head, apart, tmp_path):
    text = table(lambda k: f"{k / 100:.2f},{WAVE[k]:.4f},{k / 100 + apart:.3f}", head)
    found = drafted(tmp_path, text)
    if apart:
        assert "differ, each before its own channels" in found
    else:
        assert [channel.name for channel in found.channels] == ["A1", "B1"]


@pytest.mark.parametrize("step", [2, 10])
def test_a_counter_that_rises_by_other_steps_than_one_is_asked_about(step, tmp_path):
    """At 100 counts a second, every second one there, rows come at 50 Hz."""
    text = table(lambda k: step * k, "count,az [g]", above="Sample rate: 100 Hz\n")
    assert "still to be answered: time_unit" in drafted(tmp_path, text)
    answers = {"time_unit": "sample", "rate_hz": "100"}
    found = read(tmp_path / "run.csv", understand(tmp_path / "run.csv", answers).mapping())
    assert found.rate_hz == 100.0 and np.flatnonzero(~found.missing).tolist()[:2] == [0, step]


def test_a_counter_stays_one_above_a_row_of_sums(tmp_path):
    text = table(lambda k: k, "count,az [g]", above=COUNTED) + ",12.3\n"
    assert "count: has no time" in drafted(tmp_path, text)


def test_a_day_that_may_be_a_month_is_no_start(tmp_path):
    for day, start in (("05/06/2025", None), ("14/06/2025", 1749895261.0)):
        text = table(lambda k, d=day: f"{d} 10:01:{1 + k / 100:05.2f}Z")
        assert drafted(tmp_path, text).start_unix_s == start


@pytest.mark.parametrize(("head", "unit"), [("T [°C]", "°C"), ("T", ""), ("t1 [mm]", "m")])
def test_what_rises_beside_a_clock_is_a_channel(head, unit, tmp_path):
    """A temperature that is called as time is."""
    text = table(lambda k: f"{k / 100:.2f},{20 + (k // 7) * 0.1 + (k % 7) ** 2 * 1e-3:.3f}",
                 f"Time [s],{head},az [g]")  # fmt: skip
    assert units_of(drafted(tmp_path, text)) == {head.partition(" ")[0]: unit, "az": "m/s²"}


def test_seconds_of_gps_are_not_since_1970(tmp_path):
    """GPS counts since 1980: read as Unix time, the start would be ten years early."""
    text = table(lambda k: f"{1446675483 + k / 100:.2f}", "GPS Time,az [g]")
    found = drafted(tmp_path, text)
    assert_right(found)
    assert found.start_unix_s is None
    assert "GPS Time may count since 1980, as GPS does: its start is not known" in found.history
