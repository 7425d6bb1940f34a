"""Was it a vehicle that moved, or a beam? Dampers turn phases, a beam off resonance does not."""

import numpy as np

from wheelhop.calibration.sync.delay import stretches
from wheelhop.logger.recording import Recording

SLOWEST_HZ = 1.5
FASTEST = 0.45  # of the rate
IN_PHASE = 0.02  # share of the motion out of phase: beams 0.001, vehicles 0.07 and more


def moves_in_phase(recording: Recording) -> bool:
    """All channels move in phase or antiphase at every frequency: what relates the points of a
    vehicle does not hold here, and exchanged channels are a matter for a check on the beam."""
    start, stop = max(stretches(~recording.missing), key=lambda s: s[1] - s[0], default=(0, 0))
    n = stop - start
    if n < 2 or recording.values.shape[1] < 2:
        return False
    values = recording.values[start:stop]
    x = np.fft.rfft((values - values.mean(axis=0)) * np.hanning(n)[:, None], axis=0)
    grid = np.fft.rfftfreq(n, 1 / recording.rate_hz)
    x = x[(grid >= SLOWEST_HZ) & (grid <= FASTEST * recording.rate_hz)]
    # Half the phase of the squares is the common one, whatever the signs.
    aligned = x * np.exp(-0.5j * np.angle(np.sum(x**2, axis=1)))[:, None]
    return bool(np.sum(aligned.imag**2) < IN_PHASE * np.sum(np.abs(aligned) ** 2))
