"""What window, sensor and clock have done is undone in band, and nowhere is anything invented."""

import numpy as np
import pytest

from wheelhop.logger import (
    Channel,
    LoggerError,
    Recording,
    correct_clock,
    correct_sensor,
    correct_window,
)

CONVERSION_S = 156.25e-6
PLACES = [*range(8), *range(7, -1, -1)]  # input of each conversion of a pass
NAMES = "B1 B2 B3 B4 A1 A2 A3 A4"
RATES = [(100, 8), (200, 4), (400, 2)]
SCANS = 1000


def measured(signal, rate=100, conversions=8, names=NAMES, **notes):
    """What a logger records of signal(t): each input is converted at its places of a scan."""
    used = [k for k, name in enumerate(names.split()) if name != "-"]
    places = np.arange(conversions // 2 * 16)
    mean = places.mean()
    rows = np.arange(SCANS) / rate
    columns = []
    for k in used:
        own = (places[np.array(PLACES)[places % 16] == k] - mean) * CONVERSION_S
        assert len(own) == conversions
        columns.append(signal(rows[:, None] + mean * CONVERSION_S + own).mean(axis=1))
    return Recording(
        np.column_stack(columns),
        float(rate),
        tuple(Channel(names.split()[k], "code") for k in used),
        start_s=mean * CONVERSION_S,
        averaging_s=1 / rate,
        notes={"rate_hz": str(rate), "conversions": str(conversions), "channels": names} | notes,
    )


def inside(recording, margin=70):
    return slice(margin, len(recording.values) - margin)


@pytest.mark.parametrize(("rate", "conversions"), RATES)
@pytest.mark.parametrize("part", [0.02, 0.3, 0.6, 0.75])
def test_the_window_is_undone_for_each_input(rate, conversions, part):
    frequency = part * rate / 2
    recording = measured(lambda t: np.sin(2 * np.pi * frequency * t + 1), rate, conversions)
    corrected = correct_window(recording)
    wanted = np.sin(2 * np.pi * frequency * recording.time_s + 1)[:, None]
    middle = inside(recording)
    assert np.abs(corrected.values - wanted)[middle].max() < 2e-3
    assert corrected.averaging_s == 0


def test_inputs_are_told_apart_by_their_number_and_not_by_their_column():
    recording = measured(lambda t: np.sin(2 * np.pi * 30 * t), names="- - - B4 - - - A4")
    wanted = np.sin(2 * np.pi * 30 * recording.time_s)[:, None]
    corrected = correct_window(recording)
    assert np.abs(corrected.values - wanted)[inside(recording)].max() < 2e-3


@pytest.mark.parametrize(("rate", "conversions"), RATES)
@pytest.mark.parametrize("part", [0.02, 0.3, 0.6, 0.75])
def test_window_and_sensor_are_undone_together(rate, conversions, part):
    frequency = part * rate / 2
    response = 1 / (1 + 1j * frequency / 50)

    def filtered(t):
        return np.imag(response * np.exp(2j * np.pi * frequency * t))

    recording = measured(filtered, rate, conversions)
    corrected = correct_sensor(correct_window(recording))
    wanted = np.sin(2 * np.pi * frequency * recording.time_s)[:, None]
    assert np.abs(corrected.values - wanted)[inside(recording, 130)].max() < 5e-3


def test_a_channel_whose_filter_is_unknown_stays_as_it_is():
    recording = measured(np.sin, names="B1 B2 - - - - - -")
    corrected = correct_sensor(recording, [40.0, None])
    assert np.array_equal(corrected.values[:, 1], recording.values[:, 1])
    assert not np.array_equal(corrected.values[:, 0], recording.values[:, 0])
    assert "40, unknown Hz" in corrected.history[-1]
    assert correct_sensor(recording, [None, None]) is recording


def test_a_constant_stays_what_it_is_up_to_both_ends():
    recording = measured(lambda t: np.full_like(t, 531.25))
    corrected = correct_sensor(correct_window(recording))
    assert np.allclose(corrected.values, 531.25, rtol=0, atol=1e-9)


def test_gaps_stay_gaps_and_runs_are_corrected_on_their_own():
    whole = measured(lambda t: 500 + 100 * np.sin(2 * np.pi * 7 * t))
    values = whole.values.copy()
    gaps = [*range(300, 304), 600, 602]
    values[gaps] = np.nan
    broken = Recording(
        values, whole.rate_hz, whole.channels, averaging_s=whole.averaging_s, notes=whole.notes
    )
    corrected = correct_sensor(correct_window(broken))
    assert np.flatnonzero(corrected.missing).tolist() == gaps
    left = Recording(
        values[:300], whole.rate_hz, whole.channels, averaging_s=0.01, notes=whole.notes
    )
    alone = correct_sensor(correct_window(left)).values
    assert np.allclose(corrected.values[:300], alone, rtol=0, atol=1e-9)
    # The lonely sample 601 has no neighbours to tell how it was filtered.
    assert np.array_equal(corrected.values[601], values[601])


def test_what_lies_above_the_band_is_not_blown_up():
    noise = np.random.default_rng(1).normal(size=(SCANS, 8))
    for rate, conversions in RATES:
        quiet = measured(np.zeros_like, rate, conversions)
        noisy = Recording(
            noise, float(rate), quiet.channels, averaging_s=1 / rate, notes=quiet.notes
        )
        corrected = correct_sensor(correct_window(noisy))
        power = np.abs(np.fft.rfft(corrected.values, axis=0)) ** 2
        before = np.abs(np.fft.rfft(noise, axis=0)) ** 2
        top = slice(int(0.97 * len(power)), None)
        assert power[top].sum() < 1.3 * before[top].sum()
        assert corrected.values.std() < 4 * noise.std()


def test_time_becomes_true_time():
    recording = measured(np.sin, clock_ppm="-1250")
    corrected = correct_clock(recording)
    assert corrected.time_s == pytest.approx(recording.time_s * (1 - 1250e-6))
    assert "-1250 ppm" in corrected.history[-1]
    with pytest.raises(LoggerError, match="never measured"):
        correct_clock(measured(np.sin))


def test_nothing_is_undone_twice():
    once = correct_window(measured(np.sin))
    with pytest.raises(LoggerError, match="nothing to undo"):
        correct_window(once)
    with pytest.raises(LoggerError, match="once is enough"):
        correct_sensor(correct_sensor(measured(np.sin)))
    with pytest.raises(LoggerError, match="corrected already"):
        correct_clock(correct_clock(measured(np.sin, clock_ppm="30")))
    assert len(once.history) == 1 and "undone up to 40 Hz" in once.history[0]
