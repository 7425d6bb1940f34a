"""What a linear fault of the instrument makes of a record: a transfer function, applied to it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from wheelhop.effects.base import Array

MARGIN_S = 0.5
"""Records are continued by this much at both ends, as what comes before and after is not known."""


def transferred(
    record: Array,
    rate_hz: float,
    transfer: Callable[[Array], NDArray[np.complex128]],
    jumps: tuple[float, float] = (0.0, 0.0),
) -> Array:
    """A record (n, c) after a filter whose transfer function at frequencies (f,), Hz, is `transfer`
    (f, c) or (f, 1), with exp(+iωt); for filters that remember a moment, no longer.

    The filter acts in the frequency domain. Beyond its ends the record is continued by its own
    point reflection, which fades to one level, so that nothing jumps where the transform closes it
    to a ring. What really came before and after differs from that by `jumps`, in the record's unit,
    which fade as well: two numbers nobody recorded.
    """
    margin = min(round(MARGIN_S * rate_hz), len(record) - 1)
    longer = np.pad(record, ((margin, margin), (0, 0)), mode="reflect", reflect_type="odd")
    n = len(longer)
    fade = 0.5 + 0.5 * np.cos(np.pi * np.arange(1, margin + 1) / margin)[:, None]
    level = 0.5 * (record[0] + record[-1])
    longer[margin + len(record) :] = level + fade * (longer[margin + len(record) :] - level)
    longer[:margin] = level + fade[::-1] * (longer[:margin] - level)
    longer[:margin] += jumps[0] * fade[::-1]
    longer[margin + len(record) :] += jumps[1] * fade
    spectrum = fft.rfft(longer, axis=0) * transfer(fft.rfftfreq(n, 1.0 / rate_hz))
    return np.asarray(fft.irfft(spectrum, n, axis=0)[margin : margin + len(record)])


def on_a_mount(acceleration: Array, rate_hz: float, resonance_hz: float, zeta: float) -> Array:
    """Acceleration (n,) of a mass on a spring and damper whose foot has this `acceleration` (n,);
    at the first sample the mass moves with its foot.

    The foot's acceleration is that of its Fourier series, which repeats once the end has been led
    back to the beginning. Of the steady motion relative to the foot, r″ + 2ζω_r r′ + ω_r² r = −a,
    the free decay from its own state at the first sample is taken off: no step of the time enters.
    """
    n = len(acceleration)
    turn = np.linspace(0.0, np.pi, round(MARGIN_S * rate_hz))[1:-1]
    back = acceleration[0] + (acceleration[-1] - acceleration[0]) * (1.0 + np.cos(turn)) / 2.0
    ring = np.concatenate([acceleration, back])
    omega, own = 2 * np.pi * fft.rfftfreq(len(ring), 1.0 / rate_hz), 2 * np.pi * resonance_hz
    foot = fft.rfft(ring)
    relative = -foot / (own**2 - omega**2 + 2j * zeta * own * omega)
    states = np.stack([relative, 1j * omega * relative, foot - omega**2 * relative])
    distance, rate, steady = fft.irfft(states, len(ring), axis=1)[:, :n]
    root = _root(resonance_hz, zeta)
    # The free motion Re(A exp(root t)) with this distance and rate at 0 s.
    free = distance[0] + 1j * (root.real * distance[0] - rate[0]) / root.imag
    since_s = np.arange(n) / rate_hz
    return np.asarray(steady - ringing(free * root**2, since_s, resonance_hz, zeta))


def ringing(amplitude: complex, since_s: Array, resonance_hz: float, zeta: float) -> Array:
    """Free decay (n,) of a mass on a spring and damper from 0 s on, in the unit of its amplitude:
    the real part is its value at 0 s, the negative imaginary part a quarter of a turn later."""
    motion = amplitude * np.exp(_root(resonance_hz, zeta) * np.maximum(since_s, 0.0))
    return np.where(since_s < 0.0, 0.0, motion.real)


def _root(resonance_hz: float, zeta: float) -> complex:
    """Root of s² + 2ζω_r s + ω_r² (zeta below 1), 1/s."""
    return complex(2 * np.pi * resonance_hz * (-zeta + 1j * np.sqrt(1.0 - zeta**2)))
