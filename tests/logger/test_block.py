"""The block and the scan as SPEC.md fixes them."""

import binascii

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.firmware.promises import reader
from wheelhop.logger import block

SUMS = st.integers(1, 8).flatmap(
    lambda channels: arrays(
        np.int64, st.tuples(st.integers(1, 60), st.just(channels)), elements=st.integers(0, 8191)
    )
)


def test_sizes_are_those_of_the_specification():
    assert [block.scan_bytes(n) for n in range(1, 9)] == [2, 4, 5, 7, 9, 10, 12, 13]
    assert block.scans_per_block(8) == 37
    assert block.scans_per_block(1) == 127
    assert block.FIELDS.itemsize == block.BLOCK_BYTES
    assert block.crc(b"123456789") == 0x31C3


@given(SUMS)
def test_scans_come_back_as_they_were_stored(sums):
    stored = block.pack_scans(sums)
    channels = sums.shape[1]
    assert np.array_equal(block.unpack_scans(stored, channels), sums)
    size = block.scan_bytes(channels)
    by_the_specification = [
        reader.unpack(stored[i : i + size], channels) for i in range(0, len(stored), size)
    ]
    assert by_the_specification == [tuple(row) for row in sums.tolist()]


@given(
    st.sampled_from([b"H", b"D", b"S", b"?"]),
    st.integers(1, 2**32 - 1),
    st.integers(0, 2**32 - 1),
    st.integers(0, 2**32 - 1),
    st.integers(0, 70000),
    st.integers(0, 127),
    st.binary(max_size=486),
)
def test_a_block_is_read_by_a_reader_of_the_specification(
    kind, session, sequence, first, late, count, payload
):
    packed = block.pack_block(
        kind,
        session,
        sequence,
        first_scan=first,
        lost=first // 2,
        late=late,
        count=count,
        payload=payload,
    )
    assert len(packed) == 512
    read = reader.parse_block(packed, sequence)
    assert (read.kind, read.session, read.count) == (kind, session, count)
    assert (read.first_scan, read.lost, read.late) == (first, first // 2, min(late, 65535))
    assert read.payload.rstrip(b"\0") == payload.rstrip(b"\0")
    fields = np.frombuffer(packed, block.FIELDS)[0]
    assert fields["crc"] == block.crc(packed[:510])
    assert (fields["session"], fields["first_scan"], fields["kind"]) == (session, first, kind[0])


def test_a_payload_that_is_too_long_is_refused():
    with pytest.raises(ValueError, match="487"):
        block.pack_block(b"D", 1, 0, payload=bytes(487))


@pytest.mark.parametrize("count", [0, 1, block.FEW - 1, block.FEW, 1000])
def test_many_check_sums_at_a_time_are_those_of_one_at_a_time(count):
    blocks = np.random.default_rng(count).integers(0, 256, (count, 512), dtype=np.uint8)
    expected = [binascii.crc_hqx(bytes(row[:510]), 0) for row in blocks]
    assert block.crcs(blocks).tolist() == expected


@given(
    st.dictionaries(
        st.text("abcdefghijklmnopqrstuvwxyz_", min_size=1, max_size=8),
        st.text([chr(code) for code in range(0x20, 0x7F)], min_size=1, max_size=20),
        max_size=10,
    )
)
def test_text_comes_back(values):
    assert block.parse_text(block.pack_text(values)) == values


@given(st.binary(max_size=486))
def test_any_bytes_are_some_text_that_a_terminal_can_take(payload):
    values = block.parse_text(b"name=" + payload)
    assert all(key and value for key, value in values.items())
    assert all(text.isprintable() and text.isascii() for pair in values.items() for text in pair)


def test_an_empty_value_is_as_good_as_a_missing_one():
    assert block.parse_text(b"clock_ppm=\nname=a=b\nno value\n\0\0junk=1\n") == {"name": "a=b"}
