"""Frames: every content survives the line, and damage costs the frames it hits, nothing more."""

import itertools
import os
import random
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.firmware.promises.reader import checked, parse_frame
from wheelhop.logger.frames import (
    MOST_CONTENT,
    Acknowledgement,
    Frame,
    FrameReader,
    acknowledgement,
    pack_acknowledgement,
    pack_command,
    pack_frame,
    pack_scan_frame,
    streamed_scan,
    stuff,
    unstuff,
)

MUTATIONS = int(os.environ.get("WHEELHOP_FUZZ", 3000))

payloads = st.binary(max_size=48) | st.lists(st.sampled_from([0, 1, 255]), max_size=48).map(bytes)
kinds = st.sampled_from("DBHSLKEMF?")


@given(st.binary(max_size=600))
def test_stuffing_leaves_no_zero_and_comes_back(content):
    stuffed = stuff(content)
    assert 0 not in stuffed and unstuff(stuffed) == content
    assert len(stuffed) <= len(content) + 1 + len(content) // 254


@given(st.lists(st.tuples(kinds, payloads), max_size=12), st.lists(st.integers(0, 700)))
def test_frames_come_back_however_the_stream_is_cut(sent, cuts):
    stream = b"".join(pack_frame(kind, k, payload) for k, (kind, payload) in enumerate(sent))
    reader = FrameReader()
    places = sorted({0, *(cut for cut in cuts if cut < len(stream)), len(stream)})
    parts = [stream[a:b] for a, b in itertools.pairwise(places)]
    got = [frame for part in parts for frame in reader.feed(part, 1.5)]
    assert [(frame.kind, frame.payload) for frame in got] == sent
    assert (reader.broken, reader.lost, reader.bytes) == (0, 0, len(stream))


@given(kinds, st.integers(0, 255), payloads)
def test_frames_are_what_the_decoder_written_from_the_spec_reads(kind, counter, payload):
    piece = pack_frame(kind, counter, payload)
    assert piece[0] == piece[-1] == 0
    frame = parse_frame(piece[1:-1])
    assert (frame.kind, frame.counter, frame.payload) == (kind, counter, payload)


@settings(derandomize=True)  # one damaged frame in 65536 passes for a good one
@given(st.lists(payloads, min_size=3, max_size=8), st.data())
def test_a_wrong_byte_costs_one_frame(sent, data):
    stream = bytearray(b"".join(pack_frame("D", k, item) for k, item in enumerate(sent)))
    at = data.draw(st.integers(0, len(stream) - 1))
    stream[at] ^= data.draw(st.integers(1, 255))
    got = [(frame.counter, frame.payload) for frame in FrameReader().feed(bytes(stream))]
    assert len(got) >= len(sent) - 1 and set(got) <= set(enumerate(sent))


def test_gaps_in_the_counter_are_counted_and_a_restart_is_none():
    reader = FrameReader()
    for counter in (254, 255, 0, 3):
        reader.feed(pack_frame("D", counter))
    assert reader.lost == 2
    reader.feed(pack_frame("M", 0, b"ready"))
    assert reader.lost == 2


@given(st.integers(0, 2**32 - 1), st.integers(0, 2**32 - 1), st.binary(min_size=1, max_size=13))
def test_what_frames_carry_comes_back(session, number, stored):
    frame = Frame("D", 0, pack_scan_frame(session, number, stored))
    scan = streamed_scan(frame)
    assert (scan.session, scan.number, scan.stored) == (session, number, stored)
    told = Acknowledgement(session, number, 3, 4, 5, 6, 7, 8, 9)
    assert acknowledgement(Frame("B", 0, pack_acknowledgement(told))) == told
    assert acknowledgement(Frame("B", 0, pack_acknowledgement(told)[:-1])) is None
    assert streamed_scan(Frame("D", 0, frame.payload[:8])) is None


def test_commands_carry_their_check_sum():
    assert pack_command("stop") == b"stop*B8E2\n" == checked("stop")
    with pytest.raises(ValueError, match="at most 54"):
        pack_command("x" * 55)
    with pytest.raises(ValueError):
        pack_command("set name=ü")


def mutated(stream, rng):
    """A stream with a few things gone wrong."""
    out = bytearray(stream)
    for _ in range(rng.randrange(1, 6)):
        at = rng.randrange(len(out))
        match rng.randrange(5):
            case 0:
                out[at] ^= 1 << rng.randrange(8)
            case 1:
                del out[at : at + rng.randrange(1, 40)]
            case 2:
                out[at:at] = out[at : at + rng.randrange(1, 40)]
            case 3:
                out[at:at] = rng.randbytes(rng.randrange(1, 80))
            case 4:
                out[at] = 0
    return bytes(out)


def test_no_mutated_stream_is_believed_beyond_the_odds_of_the_check_sum():
    """`WHEELHOP_FUZZ=1000000` asks for so many."""
    rng = random.Random(11)
    sent = [("DBLKHSF"[k % 7], rng.randbytes(rng.randrange(1, 45))) for k in range(12)]
    stream = b"".join(pack_frame(kind, k, payload) for k, (kind, payload) in enumerate(sent))
    last = pack_frame("K", 99, b"HOP00001.HOP")
    begin, wrong, broken = time.perf_counter(), 0, 0
    for _ in range(MUTATIONS):
        reader = FrameReader()
        data = mutated(stream, rng)
        cut = rng.randrange(len(data))
        got = [*reader.feed(data[:cut]), *reader.feed(data[cut:] + b"\0" + last)]
        assert got and (got[-1].kind, got[-1].payload) == ("K", b"HOP00001.HOP")
        assert len(reader._rest) <= MOST_CONTENT + 2
        wrong += sum((frame.kind, frame.payload) not in sent for frame in got[:-1])
        broken += reader.broken
    rate = MUTATIONS / (time.perf_counter() - begin)
    print(f"{MUTATIONS} streams, {rate:.0f}/s; {wrong} of {broken} broken frames believed")
    assert wrong <= 5 + 4 * broken / 65536
