"""Rates that lines above a table state, in the words of many loggers; what else such lines say is
asked about, and so is a rate at which no suspension is recorded."""

import pytest

from tests.formats.logged import drafted, table
from wheelhop.formats import draft_mapping, understand

POINT, COMMA, WHOLE = "count,az [g]", "count;az [g]", "count,az [mg]"


def counted(tmp_path, above, head=POINT):
    """A counter below one line, its numbers with decimal points, commas, or none."""
    if head == POINT:
        return drafted(tmp_path, table(lambda k: k, head, above=f"{above}\n"))
    rows = ((f"{k};{k % 7},25" if head == COMMA else f"{k},{k % 7}") for k in range(300))
    return drafted(tmp_path, "\n".join([above, head, *rows]) + "\n")


@pytest.mark.parametrize(
    ("above", "rate_hz"),
    [
        ("Sampling frequency (kHz): 2", 2000),
        ("Sample rate [kHz];0.1", 100),
        ("Samplingrate: 0,1 kHz", 100),
        ("sampling_rate_hz: 100", 100),
        ("Sample Rate (Hz),100", 100),
        ("Sampling interval (ms): 10", 100),
        ("Sample period,0.01,s", 100),
        ("Delta T = 0.01 s", 100),
        ("Sampling rate: 100 Hz; filter 40 Hz", 100),
        ("Scan rate: 100 scans/s", 100),
        ("Sample rate: 100 samples per second", 100),
        ("Sample rate: 100Hz per channel", 100),
        ("acquisition rate [S/s]=100", 100),
        ("Sample rate: 1,000 Hz", 1000),
        ("Sensor output data rate (ODR): 100 Hz", 100),
        ("sample rate of 100 Hz", 100),
    ],
)
def test_rates_are_read_in_the_words_and_units_of_loggers(above, rate_hz, tmp_path):
    found = counted(tmp_path, above)
    assert not isinstance(found, str), found
    assert found.rate_hz == pytest.approx(rate_hz)
    assert understand(tmp_path / "run.csv").guesses == ()


@pytest.mark.parametrize(
    "above",
    [
        *("Sample rate divider: 4", "Sample rate divisor = 10", "Sample rate code=12"),
        *("Sample rate (channel 1): 1000 Hz", "Sampling rate 1/100 s", "Sample rate: 100-200 Hz"),
        *("GPS sample rate: 10 Hz", "Max sample rate: 1000 Hz", "Video frame rate: 25 Hz"),
        *("Data rate: 115200", "Data rate: 9600", "Sensor data rate: 1 Mbps"),
        *("Sample rate = 6000 /min", "Sample rate: 6000 samples/min", "dt=0.01"),
        *("Sampling time: 10 s", "Log interval: 1 s", "Sample rate 500 ms"),  # below 5 Hz
        *("Sample rate: 100.1 kHz", "Sample rate: 4.9 Hz"),
    ],
)
def test_what_is_another_statement_or_no_rate_of_a_suspension_is_asked(above, tmp_path):
    assert "still to be answered: rate_hz" in counted(tmp_path, above)


def test_a_rate_that_is_asked_about_is_shown_with_its_line(tmp_path):
    counted(tmp_path, "Log interval: 1 s")
    assert "count only counts; line 1 says 1 Hz" in draft_mapping(tmp_path / "run.csv")


@pytest.mark.parametrize("above", ["Fs = 100", "Sample rate: 100", "Logging frequency ..... 100"])
def test_a_rate_without_a_unit_is_taken_for_granted_and_not_by_a_script(above, tmp_path):
    assert counted(tmp_path, above).rate_hz == 100.0
    said = understand(tmp_path / "run.csv").guesses
    assert said == ("100, which line 1 says, is in Hz",)


@pytest.mark.parametrize(("head", "rate_hz"), [(POINT, 12.8), (COMMA, 12_800.0), (WHOLE, None)])
def test_the_marks_of_a_rate_are_those_of_the_table_s_numbers(head, rate_hz, tmp_path):
    found = counted(tmp_path, "Sample rate: 12.800 Hz", head)
    if rate_hz is None:
        assert "still to be answered: rate_hz" in found
    else:
        assert found.rate_hz == rate_hz
