"""The faults of the line, byte by byte."""

import numpy as np

from wheelhop.hil_sim.double.faults import DoubleFaults


class Wire:
    """Lets bytes of one direction through as the faults allow; the same seed, the same faults."""

    def __init__(self, faults: DoubleFaults, direction: int) -> None:
        self._faults = faults
        self._random = np.random.default_rng([faults.seed, direction])

    def carry(self, data: bytes) -> bytes:
        """What arrives of `data`."""
        faults = self._faults
        if not data or not (faults.garbled or faults.noise or faults.dropped or faults.duplicated):
            return data
        arrived = np.frombuffer(data, np.uint8)
        if faults.garbled:  # a receiver that is too slow sees several bits as one
            return (arrived[::3] | 0xE1).astype(np.uint8).tobytes() + b"\n" * data.count(b"\n")
        hit = self._random.random(len(arrived)) < faults.noise
        bits = 1 << self._random.integers(0, 8, len(arrived), dtype=np.uint8)
        arrived = np.where(hit, arrived ^ bits, arrived).astype(np.uint8)
        copies = np.ones(len(arrived), np.int64)
        copies[self._random.random(len(arrived)) < faults.duplicated] = 2
        copies[self._random.random(len(arrived)) < faults.dropped] = 0
        return np.repeat(arrived, copies).tobytes()
