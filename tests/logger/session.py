"""Sessions as the firmware would write them, made from their sums."""

import numpy as np

from wheelhop.logger.block import (
    BLOCK_BYTES,
    DATA,
    HEADER,
    SUMMARY,
    pack_block,
    pack_scans,
    pack_text,
    scans_per_block,
)

SESSION = 0x000C_BEEF
NAMES = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")


def header(inputs=8, **changes):
    """The values of a header for the first so many inputs."""
    values = {
        "firmware": "1.0.0",
        "device": 3,
        "calibration": "rig-7",
        "name": "kerb",
        "rate_hz": 100,
        "conversions": 8,
        "channels": " ".join((*NAMES[:inputs], *["-"] * (8 - inputs))),
        "clock_ppm": -1250,
        "unix_s": 1790000000,
        "supply_mv": 3300,
        "reset": "power",
        "config_errors": 0,
    }
    return values | changes


def session(sums, *, lost=(), late=(), close=True, session=SESSION, **changes):
    """The bytes of a log with these (n, channels) sums; True in `lost` where a scan is in no block.

    `late` gives the numbers of the scans before which a trigger was late.
    """
    sums = np.asarray(sums)
    channels = sums.shape[1]
    gone = np.zeros(len(sums), bool)
    gone[list(lost)] = True
    blocks = [pack_block(HEADER, session, 0, payload=pack_text(header(channels, **changes)))]
    there = np.flatnonzero(~gone)
    begin = 0
    while begin < len(there):
        end = begin + 1
        while (
            end < len(there)
            and end - begin < scans_per_block(channels)
            and there[end] == there[end - 1] + 1
        ):
            end += 1
        first = int(there[begin])
        blocks.append(
            pack_block(
                DATA,
                session,
                len(blocks),
                first_scan=first,
                lost=int(gone[:first].sum()),
                late=sum(scan <= there[end - 1] for scan in late),
                count=end - begin,
                payload=pack_scans(sums[there[begin:end]]),
            )
        )
        begin = end
    if close:
        ends = {"end": "command", "due": len(sums), "written": len(there), "lost": int(gone.sum())}
        ends |= {"late": len(late), "stall_ms": 41, "deepest": 5, "room": 45, "card_errors": 0}
        blocks.append(
            pack_block(
                SUMMARY,
                session,
                len(blocks),
                first_scan=len(sums),
                lost=int(gone.sum()),
                late=len(late),
                payload=pack_text(ends | {"clock_ppm": -1250}),
            )
        )
    return b"".join(blocks)


def random_sums(scans=100, channels=8, seed=1):
    """Sums that a converter could have given."""
    return np.random.default_rng(seed).integers(0, 8 * 1023 + 1, (scans, channels))


def blocks_of(data):
    """The blocks of a file, as a list that a test may damage."""
    return [bytearray(data[k : k + BLOCK_BYTES]) for k in range(0, len(data), BLOCK_BYTES)]
