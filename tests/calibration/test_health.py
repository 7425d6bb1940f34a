"""Each fault of a channel or a recorder in its simplest form, and its harmless twin."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy import signal

from wheelhop.calibration.health.examine import examine
from wheelhop.calibration.health.spectrum import relative_power
from wheelhop.logger.recording import ACCELERATION, CODE, Channel, Recording

RATE = 100.0
TIME = np.arange(3000) / RATE
NAMES = ("B1", "B2", "A1", "A2")


def road(seed=0, scale=3.0):
    """Four channels of coloured noise, partly common."""
    draw = np.random.default_rng(seed)
    white = draw.normal(size=(len(TIME) + 20, 5))
    smooth = np.apply_along_axis(lambda x: np.convolve(x, np.hanning(12), "valid"), 0, white)
    return scale * (smooth[: len(TIME), :4] + smooth[: len(TIME), 4:]) / 2


def recording(values, unit=ACCELERATION, **more):
    return Recording(values, RATE, tuple(Channel(name, unit) for name in NAMES), **more)


def found(values, unit=ACCELERATION, **more):
    findings = examine(recording(values, unit, **more)).findings
    return [(f.kind, *f.channels) for f in findings]


def with_column(column, index=1):
    values = road()
    values[:, index] = column
    return values


def test_a_good_recording_has_no_findings():
    assert found(road()) == []
    assert found(np.round(8 * (531 + 2 * road())) / 8, CODE) == []


@pytest.mark.parametrize("seed", range(10))
def test_a_logger_at_rest_has_no_findings(seed):
    draw = np.random.default_rng(seed)
    quiet = np.array([530.9, 528.2, 540.0, 511.5]) + 0.3 * draw.normal(size=(3000, 4))
    assert found(np.round(8 * quiet) / 8, CODE) == []
    assert found(np.full((3000, 4), 531.0), CODE) == []


def test_clipped_peaks_are_told_from_the_peaks_of_a_sine():
    column = road()[:, 1]
    limit = 0.4 * np.abs(column).max()
    assert ("clipping", "B2") in found(with_column(np.clip(column, -limit, limit)))
    sines = np.stack([5 * np.sin(2 * np.pi * 7 * TIME + k) for k in range(4)], axis=1)
    assert found(sines) == [] == found(np.round(8 * (531 + 20 * sines)) / 8, CODE)


def test_crests_met_in_step_with_the_samples_are_not_cut_off():
    """Ten samples a wave and a little noise: each crest is met at the same place. Cut off where
    three samples in a row are, it is told again."""
    turn = 2 * np.pi * 10.0 * TIME
    noise = np.random.default_rng(2).normal(size=len(TIME))
    column = 60 * np.cos(turn) + 20 * np.cos(2 * turn + 0.5) + 0.12 * noise
    assert ("clipping", "B2") not in found(with_column(column))
    assert ("clipping", "B2") in found(with_column(np.clip(column, -100.0, 40.0)))


def test_the_converters_end_is_certain():
    codes = 512 + 20 * road()
    codes[100:103, 2] = 1023.0
    health = examine(recording(codes, CODE))
    assert [(f.kind, f.channels, f.sure) for f in health.findings] == [
        ("clipping", ("A1",), "certain")
    ]
    assert health.findings[0].start_s == pytest.approx(1.0)
    assert health.findings[0].stop_s == pytest.approx(1.03)


def test_a_stuck_channel_is_told_when():
    column = road()[:, 1]
    column[500:900] = column[500]
    (finding,) = examine(recording(with_column(column))).findings
    assert (finding.kind, finding.channels) == ("stuck", ("B2",))
    assert (finding.start_s, finding.stop_s) == pytest.approx((5.0, 9.0))


def test_a_channel_with_only_noise_is_dead():
    noise = 0.1 * np.random.default_rng(3).normal(size=len(TIME))
    assert found(with_column(noise)) == [("dead", "B2")]


def test_a_floating_input_rests_where_no_sensor_does():
    codes = 531 + 10 * road()
    codes[:, 3] -= 400
    assert found(codes, CODE) == [("level", "A2")]


@pytest.mark.parametrize("mains_hz", [50.0, 60.0])
@pytest.mark.parametrize("rate_hz", [100.0, 200.0, 400.0])
def test_hum_is_found_where_the_rate_folds_it(mains_hz, rate_hz):
    values = road()
    time = np.arange(len(values)) / rate_hz
    values[:, 1] += 3.0 * np.sin(2 * np.pi * 0.998 * mains_hz * time)
    findings = examine(replace(recording(values), rate_hz=rate_hz)).findings
    assert [(f.kind, f.channels) for f in findings] == [("hum", ("B2",))]


def test_a_drifting_offset_is_found_and_a_slow_sine_is_not():
    assert found(with_column(road()[:, 1] + TIME)) == [("drift", "B2")]
    assert found(with_column(road()[:, 1] + np.sin(2 * np.pi * 0.5 * TIME))) == []


def test_a_sensor_shaking_on_its_mount_is_found():
    frequency = np.fft.rfftfreq(len(TIME), 1 / RATE) / 25.0
    mount = (1 + 0.06j * frequency) / (1 + 0.06j * frequency - frequency**2)
    draw = np.random.default_rng(5)
    values = draw.normal(size=(len(TIME), 4)) + draw.normal(size=(len(TIME), 1))
    points = ("A1", "A2", "A3", "A4")
    before = Recording(values, RATE, tuple(Channel(p, ACCELERATION) for p in points))
    shaken = values.copy()
    shaken[:, 2] = np.fft.irfft(np.fft.rfft(values[:, 2]) * mount, len(TIME))
    assert examine(before).healthy
    (finding,) = examine(replace(before, values=shaken)).findings
    assert (finding.kind, finding.channels) == ("mount", ("A3",)) and "25 Hz" in finding.what


def test_with_gravity_in_the_recording_the_level_tells_polarity():
    upright = 9.81 + 0.2 * road()
    upright[:, 2] *= -1
    assert found(upright) == [("polarity", "A1")]
    assert found(9.81 + 0.2 * road()) == [] == found(-9.81 + 0.2 * road())


def test_gaps_are_listed_the_longest_first():
    values = road()
    for k in range(12):
        values[100 * k : 100 * k + k + 1] = np.nan
    findings = examine(recording(values)).findings
    assert [f.kind for f in findings] == ["gap"] * 6
    assert findings[0].what.startswith("12 samples") and findings[0].start_s == pytest.approx(11.0)
    assert "7 shorter gaps with 28 samples" in findings[5].what


@pytest.mark.parametrize(
    ("notes", "kinds"),
    [
        ({"supply_mv": "3290"}, []),
        ({"supply_mv": "0", "late": "0", "reset": "power"}, []),
        ({"supply_mv": "2700"}, ["supply"]),
        ({"supply_mv": "3300", "end_supply_mv": "3100"}, ["supply"]),
        ({"supply_mv": "3300", "end_supply_mv": "3290"}, []),
        ({"supply_mv": "3300", "low_supply_mv": "3000", "end_supply_mv": "3300"}, ["supply"]),
        ({"supply_mv": "3300", "low_supply_mv": "3250", "end_supply_mv": "3300"}, []),
        ({"reset": "brown-out"}, ["brown-out"]),
        ({"late": "3"}, ["late"]),
        ({"supply_mv": "nonsense"}, []),
    ],
)
def test_the_recorders_own_notes_are_heeded(notes, kinds):
    assert [f[0] for f in found(road(), notes=notes)] == kinds


def test_a_sag_is_told_with_its_figures():
    notes = {"supply_mv": "3300", "low_supply_mv": "2950", "low_supply_s": "12.16"}
    (finding,) = examine(recording(road(), notes=notes)).findings
    assert finding.what == "the sensors' supply fell from 3300 to 2950 mV (-11 %) at 12.16 s"


@settings(max_examples=60, deadline=None)
@given(
    arrays(
        np.float64,
        st.tuples(st.integers(0, 700), st.integers(0, 4)),
        elements=st.sampled_from([0.0, 1.0, -1.0, 1023.0, 9.81, 1e-9, 1e9, float("nan")]),
    ),
    st.sampled_from([CODE, ACCELERATION, "V"]),
)
def test_no_recording_is_too_odd_to_examine(values, unit):
    channels = tuple(Channel(name, unit) for name in NAMES[: values.shape[1]])
    for finding in examine(Recording(values, RATE, channels)).findings:
        assert finding.what and finding.remedy and "\n" not in finding.what
        assert finding.strength > 0 and finding.stop_s >= finding.start_s


def test_spectra_are_welchs_but_for_their_unit():
    values = np.random.default_rng(3).normal(size=(1037, 3)).cumsum(axis=0)
    welch = signal.welch(values, nperseg=100, axis=0, detrend="constant")[1][1:-1]
    ratio = relative_power(values, 100)[1:-1] / welch
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-9)
