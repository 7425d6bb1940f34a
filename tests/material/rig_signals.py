"""Rig signals made without wheelhop: the force of Maxwell elements under a displacement, by their
own differential equations, or of a whole modulus by the discrete Fourier transform."""

import numpy as np
from scipy import signal


def sine_steps(frequencies_hz, amplitudes_m, rate_hz=1000.0, cycles=12, rest_s=0.4):
    """Time and displacement: a dwell of each frequency at each amplitude, rests between."""
    pieces = [np.zeros(int(rest_s * rate_hz))]
    for amplitude in amplitudes_m:
        for f in frequencies_hz:
            n = round(cycles / f * rate_hz)
            pieces += [amplitude * np.sin(2 * np.pi * f * np.arange(n) / rate_hz)]
            pieces += [np.zeros(int(rest_s * rate_hz))]
    x = np.concatenate(pieces)
    return np.arange(len(x)) / rate_hz, x


def sweep(low_hz, high_hz, seconds, amplitude_m, rate_hz=1000.0):
    """A logarithmic sweep."""
    time = np.arange(round(seconds * rate_hz)) / rate_hz
    return time, amplitude_m * signal.chirp(time, low_hz, seconds, high_hz, "logarithmic", phi=-90)


def maxwell_force(time, x, spring, damper, strengths, times):
    """Σ of a spring, a damper and Maxwell elements, each solved by a linear-systems library."""
    force = spring * x + damper * np.gradient(x, time)
    for strength, tau in zip(strengths, times, strict=True):
        force += signal.lsim(([strength * tau, 0.0], [tau, 1.0]), x, time)[1]
    return force
