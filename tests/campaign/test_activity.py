"""Drives are found between rests, and never across a gap."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from wheelhop.campaign.activity import stretches
from wheelhop.logger.recording import Channel, Recording

RATE_HZ = 100.0


def recording_of(*pieces: tuple[float, float], seed: int = 0) -> Recording:
    """Noise of (seconds, rms) after one another; two channels with different offsets."""
    rng = np.random.default_rng(seed)
    rows = [rng.normal(0, rms, (round(seconds * RATE_HZ), 2)) for seconds, rms in pieces]
    channels = (Channel("A1", "m/s²"), Channel("B1", "m/s²"))
    offsets = np.array([9.8, -0.3])
    return Recording(np.concatenate(rows) + offsets, RATE_HZ, channels)


def spans(recording: Recording) -> list[tuple[float, float]]:
    return [(p.first / RATE_HZ, p.last / RATE_HZ) for p in stretches(recording)]


def test_each_drive_between_two_rests_is_found_with_its_level():
    recording = recording_of((10, 0.05), (30, 4.0), (8, 0.05), (12, 2.0), (10, 0.05))
    first, second = stretches(recording)
    assert (first.first, first.last) == pytest.approx((1000, 4000), abs=100)
    assert (second.first, second.last) == pytest.approx((4800, 6000), abs=100)
    assert (first.rms, second.rms) == pytest.approx((4.0, 2.0), rel=0.05)


def test_a_moment_of_calm_does_not_end_a_drive_but_a_missing_sample_does():
    calm = recording_of((10, 0.05), (20, 3.0), (1, 0.05), (20, 3.0), (10, 0.05))
    assert len(stretches(calm)) == 1
    calm.values[3000] = np.nan
    before, after = spans(calm)
    assert before[1] <= 30.0 <= after[0]


def test_getting_in_is_not_a_drive():
    assert len(stretches(recording_of((20, 0.05), (2, 3.0), (20, 0.05), (30, 3.0), (9, 0.05)))) == 1


def test_a_recording_without_rest_is_one_drive():
    assert spans(recording_of((60, 2.0))) == [(0.0, 60.0)]


@given(
    st.lists(st.tuples(st.integers(1, 30), st.sampled_from([0.0, 0.03, 1.0, 8.0])), max_size=6),
    st.lists(st.integers(0, 3000), max_size=4),
)
def test_stretches_are_ordered_apart_and_whole(pieces, gaps):
    recording = recording_of((1, 1.0), *pieces)
    for gap in gaps:
        recording.values[gap % len(recording.values)] = np.nan
    found = stretches(recording)
    for piece in found:
        assert 0 <= piece.first < piece.last <= len(recording.values)
        assert np.isfinite(recording.values[piece.first : piece.last]).all()
    assert all(a.last <= b.first for a, b in itertools.pairwise(found))


NOISE = 0.02  # m/s² of a channel, white
PLACES = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
GAIN = np.array([0.6, 0.7, 0.6, 0.7, 1.0, 1.1, 1.0, 1.1])  # of the channels, moved together
IDLE = np.array([1.0, 1.0, 1.0, 1.0, 0.3, 0.3, 0.3, 0.3])


def on_waves(rng, n, amplitude_m, frequency_hz):
    """All points follow a wave of the ground, and an overtone of it: acceleration (n, 8)."""
    phase = 2 * np.pi * (frequency_hz * np.arange(n) / RATE_HZ + rng.uniform())
    height = amplitude_m * (2 * np.pi * frequency_hz) ** 2
    return (height * (np.sin(phase) + 0.4 * np.sin(2 * phase)))[:, None] * GAIN


def on_rough_ground(rng, n, velocity_m_s):
    """All points follow ground whose slope is white (ISO 8608, waviness 2)."""
    velocity = rng.normal(0.0, velocity_m_s, n + 1)
    return np.diff(velocity)[:, None] * RATE_HZ * GAIN


TRACKS = {
    "washboard": lambda rng, n: on_waves(rng, n, 15e-3, 5.2),
    "fast washboard": lambda rng, n: on_waves(rng, n, 15e-3, 13.9),
    "slow chassis twist": lambda rng, n: on_waves(rng, n, 0.6e-3, 1.1),  # 0.02 m/s² rms
    "rough ground": lambda rng, n: on_rough_ground(rng, n, 0.03),
}


def session(rng, rests, drives, idle=0.0):
    """Rests of so many seconds with (track, seconds) between; the engine idles throughout.

    The recording, and rows at which the drives begin and end.
    """
    pieces, spans, row = [], [], 0
    for i, rest in enumerate(rests):
        pieces.append(np.zeros((round(rest * RATE_HZ), 8)))
        row += len(pieces[-1])
        if i < len(drives):
            kind, seconds = drives[i]
            pieces.append(TRACKS[kind](rng, round(seconds * RATE_HZ)))
            spans.append((row, row + len(pieces[-1])))
            row += len(pieces[-1])
    time_s = np.arange(row) / RATE_HZ
    engine = idle * np.sqrt(2) * np.sin(2 * np.pi * 24.3 * time_s)[:, None] * IDLE
    values = np.concatenate(pieces) + engine + rng.normal(0.0, NOISE, (row, 8))
    return Recording(values, RATE_HZ, tuple(Channel(p, "m/s²", p) for p in PLACES)), spans


def assert_found(found, spans, rate_hz=RATE_HZ):
    """Every drive and no other, of each all but 1.5 s at either end, and no more than 0.5 s of what
    is beside it."""
    assert len(found) == len(spans), ([(p.first, p.last) for p in found], spans)
    for piece, (first, last) in zip(found, spans, strict=True):
        assert -0.5 <= (piece.first - first) / rate_hz <= 1.5
        assert -0.5 <= (last - piece.last) / rate_hz <= 1.5


@pytest.mark.parametrize("share", [0.01, 0.05, 0.2, 0.5, 0.8, 0.95])
def test_the_share_of_time_that_was_driven_does_not_matter(share):
    """A loud washboard beside a chassis twist of 0.02 m/s²: the same drives, ever longer rests."""
    drives = [("slow chassis twist", 30.0), ("washboard", 40.0), ("slow chassis twist", 30.0)]
    rest = max(100.0 * (1 - share) / share / 4, 3.0)
    recording, spans = session(np.random.default_rng(5), [rest] * 4, drives)
    assert_found(stretches(recording), spans)


@settings(max_examples=60, deadline=None)
@example([("washboard", 22.0), *[("fast washboard", 10.0)] * 4], 0.01, 0.3, 1_024_133_519)
@given(
    st.lists(
        st.tuples(st.sampled_from(sorted(TRACKS)), st.floats(10.0, 40.0)), min_size=1, max_size=8
    ),
    st.sampled_from([0.01, 0.03, 0.1, 0.3, 0.6, 0.9, 0.95]),
    st.sampled_from([0.0, 0.1, 0.3]),
    st.integers(0, 2**32),
)
def test_drives_of_any_kind_are_found_among_rests_of_any_length(drives, share, idle, seed):
    """With an engine that is off, or shakes the body fifteen times as much as a twist does."""
    rng = np.random.default_rng(seed)
    driven = sum(seconds for _, seconds in drives)
    rest = min(driven * (1 - share) / share, 4000.0)
    rests = 3.5 + rng.dirichlet(np.ones(len(drives) + 1)) * rest
    recording, spans = session(rng, rests, drives, idle)
    assert_found(stretches(recording), spans)


def test_an_engine_that_starts_and_stops_is_no_drive():
    recording, spans = session(
        np.random.default_rng(1), [100.0, 40.0], [("slow chassis twist", 25.0)]
    )
    time_s = recording.time_s
    runs = (time_s > 20.0) & (time_s < 150.0)
    recording.values[:] += (runs * np.sin(2 * np.pi * 21.0 * time_s))[:, None] * IDLE
    assert_found(stretches(recording), spans)


def test_recordings_without_a_rest_or_with_nothing_else_are_given_whole():
    """Nothing in them tells which of the two they are."""
    rng = np.random.default_rng(2)
    for kind in TRACKS:
        driven, _ = session(rng, [0.0, 0.0], [(kind, 60.0)])
        assert_found(stretches(driven), [(0, 6000)])
    still, _ = session(rng, [600.0], [])
    assert_found(stretches(still), [(0, 60000)])


@pytest.mark.parametrize("rate_hz", [50.0, 100.0, 400.0])
def test_seconds_count_and_not_samples(rate_hz):
    rng = np.random.default_rng(3)
    n = round(10 * rate_hz)
    level = np.repeat([NOISE, 1.0, NOISE], [n, 3 * n, 2 * n])
    values = rng.normal(size=(6 * n, 3)) * level[:, None]
    recording = Recording(values, rate_hz, tuple(Channel(p, "m/s²", p) for p in PLACES[:3]))
    assert_found(stretches(recording), [(n, 4 * n)], rate_hz)


def test_a_log_in_coarse_codes_whose_rest_moves_no_code():
    recording, spans = session(
        np.random.default_rng(4), [300.0, 5.0, 60.0], [("washboard", 20.0)] * 2
    )
    codes = np.round(recording.values / 0.3)
    assert_found(stretches(Recording(codes, RATE_HZ, recording.channels)), spans)


@pytest.mark.parametrize("residue", [0.0, 1e-14])
def test_a_recorder_that_is_fed_nothing_is_no_measure_of_rest(residue):
    """After the sensors were unplugged; a filter leaves what rounding leaves."""
    rng = np.random.default_rng(9)
    recording, spans = session(rng, [10.0, 10.0, 30.0], [("washboard", 20.0), ("washboard", 30.0)])
    recording.values[-2000:] = 9.8 + residue * rng.normal(size=(2000, 8))
    assert_found(stretches(recording), spans)


@settings(max_examples=30, deadline=None)
@given(
    st.sampled_from(["washboard", "fast washboard", "slow chassis twist"]),
    st.floats(20.0, 60.0),
    st.tuples(st.floats(2.0, 12.0), st.floats(2.0, 12.0)),
    st.floats(0.02, 0.05),
    st.integers(0, 2**32),
)
def test_the_steady_part_leaves_out_the_way_onto_the_track_and_off_it(
    kind, seconds, ways, velocity_m_s, seed
):
    rng = np.random.default_rng(seed)
    recording, [(first, last)] = session(rng, [8.0, 8.0], [(kind, sum(ways) + seconds)])
    on, off = (round(way * RATE_HZ) for way in ways)
    for rows in (slice(first, first + on), slice(last - off, last)):
        rough = on_rough_ground(rng, rows.stop - rows.start, velocity_m_s)
        recording.values[rows] = rough + rng.normal(0.0, NOISE, rough.shape)
    [piece] = stretches(recording)
    assert_found([piece], [(first, last)])
    steady = (piece.steady_first, piece.steady_last)
    assert steady[0] >= first + on - 50 and steady[1] <= last - off + 50
    assert steady == pytest.approx((first + on, last - off), abs=300)


def test_a_drive_that_goes_on_alike_is_steady_all_along():
    rng = np.random.default_rng(6)
    for kind in TRACKS:
        recording, [span] = session(rng, [10.0, 10.0], [(kind, 60.0)])
        [piece] = stretches(recording)
        assert (piece.steady_first, piece.steady_last) == pytest.approx(span, abs=250)
