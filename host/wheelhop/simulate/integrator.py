"""Time integration of a mechanism with nonlinear force laws: the one hot loop of wheelhop.

Classical Runge–Kutta of fourth order at a fixed step. Force laws are called through function
pointers, so that the integrator is compiled once and any set of laws can be combined.
"""

from __future__ import annotations

import warnings
from math import floor

import numba
import numpy as np
from numba.core.errors import NumbaExperimentalFeatureWarning
from numpy.typing import NDArray

from wheelhop.effects import law
from wheelhop.vehicle import Law, System

Array = NDArray[np.float64]

# Calling compiled laws through pointers is marked experimental in numba; tests hold what we use.
warnings.simplefilter("ignore", NumbaExperimentalFeatureWarning)


SLOTS = 4
"""Tuples of laws are padded to a multiple of this: each length is compiled once more, as is the
integrator without any law."""


@law
def _no_force(x: float, v: float, dx: float, dt: float, z: float, p: Array) -> tuple[float, float]:
    return 0.0, z


def padded(laws: tuple[Law, ...]) -> tuple[Law, ...]:
    """A tuple of laws of one of the few lengths that are compiled."""
    return laws + (_no_force,) * (-len(laws) % SLOTS if laws else SLOTS)


@numba.njit(cache=True, nogil=True, fastmath=True, error_model="numpy")
def _integrate(  # type: ignore[no-untyped-def]
    a, b, e, p, r, g, port_law, laws, law_par, out, u, du, w, q0, dt, first, stride,
    window, n_samples
):  # fmt: skip
    """Run-time loop. a: (n, 2n) −M⁻¹[K C]; b: (n, 2m); e: (n, k); p, r: ports; g: (n, ports) M⁻¹Pᵀ;
    u, du: (T+1, m); w: (2T+1, k). Returns mean accelerations (n_samples, c) of the outputs."""
    n, m, ports, c = a.shape[0], u.shape[1], p.shape[0], out.shape[0]
    steps = u.shape[0] - 1
    q, trial, change = q0.copy(), q0.copy(), np.zeros(2 * n)
    acc, force = np.zeros(n), np.zeros(ports)
    v_old, a_old = np.zeros(n), np.zeros(n)
    drive, pushed = np.zeros(2 * m), np.zeros(n)
    start = np.zeros(ports)
    for port in range(ports):
        for j in range(n):
            start[port] += p[port, j] * q0[j]
        for j in range(m):
            start[port] += r[port, j] * u[0, j]
    memory, memory_new = np.zeros(ports), np.zeros(ports)
    y = np.zeros((n_samples, c))
    lead = np.int64(np.floor(-0.5 * window / dt))
    lead_part = -0.5 * window / dt - lead
    lag = np.int64(np.floor(0.5 * window / dt))
    lag_part = 0.5 * window / dt - lag

    for t in range(steps):
        for stage in range(4):
            if (stage == 0 and t == 0) or stage == 1 or stage == 3:
                _forcing(drive, pushed, b, e, u, du, w, 2 * t + (stage + 1) // 2, dt)
            for i in range(n):
                s = pushed[i]
                for j in range(2 * n):
                    s += a[i, j] * trial[j]
                acc[i] = s
            elapsed = 0.5 * dt * ((stage + 1) // 2)
            if laws is not None:
                for port in range(ports):
                    x, v = 0.0, 0.0
                    for j in range(n):
                        x += p[port, j] * trial[j]
                        v += p[port, j] * trial[n + j]
                    for j in range(m):
                        x += r[port, j] * drive[j]
                        v += r[port, j] * drive[m + j]
                    force[port], memory_new[port] = laws[port_law[port]](
                        x, v, x - start[port], elapsed, memory[port], law_par[port]
                    )
                for i in range(n):
                    s = 0.0
                    for port in range(ports):
                        s += g[i, port] * force[port]
                    acc[i] -= s
            if stage == 0:
                _sample(
                    y, out, q, acc, v_old, a_old, t, dt, first, stride, window, n_samples,
                    lead, lead_part, lag, lag_part,
                )  # fmt: skip
                for i in range(n):
                    v_old[i], a_old[i] = q[n + i], acc[i]
            weight = 1.0 if stage == 0 or stage == 3 else 2.0
            advance = 0.5 * dt if stage < 2 else dt
            for i in range(n):
                speed = trial[n + i]
                if stage == 0:
                    change[i], change[n + i] = speed, acc[i]
                else:
                    change[i] += weight * speed
                    change[n + i] += weight * acc[i]
                trial[i] = q[i] + advance * speed
                trial[n + i] = q[n + i] + advance * acc[i]
        for i in range(2 * n):
            q[i] += dt / 6.0 * change[i]
            trial[i] = q[i]
        if laws is not None:
            for port in range(ports):
                x, v = 0.0, 0.0
                for j in range(n):
                    x += p[port, j] * q[j]
                    v += p[port, j] * q[n + j]
                for j in range(m):
                    x += r[port, j] * u[t + 1, j]
                    v += r[port, j] * du[t + 1, j]
                _, memory[port] = laws[port_law[port]](
                    x, v, x - start[port], dt, memory[port], law_par[port]
                )
                start[port] = x
    return y


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _forcing(drive, pushed, b, e, u, du, w, half_step, dt):  # type: ignore[no-untyped-def]
    """Prescribed motion and its rate at a half step, and the accelerations it and the applied
    forces cause by themselves; between steps the motion is a cubic Hermite polynomial."""
    m, t = u.shape[1], half_step // 2
    for j in range(m):
        if half_step % 2 == 0:
            drive[j], drive[m + j] = u[t, j], du[t, j]
        else:
            rise = u[t + 1, j] - u[t, j]
            drive[j] = u[t, j] + 0.5 * rise + 0.125 * dt * (du[t, j] - du[t + 1, j])
            drive[m + j] = 1.5 * rise / dt - 0.25 * (du[t, j] + du[t + 1, j])
    for i in range(pushed.shape[0]):
        s = 0.0
        for j in range(2 * m):
            s += b[i, j] * drive[j]
        for j in range(w.shape[1]):
            s += e[i, j] * w[half_step, j]
        pushed[i] = s


@numba.njit(cache=True, nogil=True, fastmath=True, inline="always")
def _sample(  # type: ignore[no-untyped-def]
    y, out, q, acc, v_old, a_old, t, dt, first, stride, window, n_samples,
    lead, lead_part, lag, lag_part,
):  # fmt: skip
    """The mean acceleration over a window is its velocity at the end less that at the beginning."""
    n = acc.shape[0]
    if window == 0.0:
        if t >= first and (t - first) % stride == 0 and (t - first) // stride < n_samples:
            row = (t - first) // stride
            for o in range(out.shape[0]):
                for i in range(n):
                    y[row, o] += out[o, i] * acc[i]
        return
    for edge in range(2):
        offset, part, sign = (lead, lead_part, -1.0) if edge == 0 else (lag, lag_part, 1.0)
        since = t - 1 - first - offset
        if since < 0 or since % stride != 0 or since // stride >= n_samples:
            continue
        # Cubic Hermite of the velocity over the step just finished.
        h00 = (1.0 + 2.0 * part) * (1.0 - part) ** 2
        h01 = part * part * (3.0 - 2.0 * part)
        h10 = part * (1.0 - part) ** 2 * dt
        h11 = part * part * (part - 1.0) * dt
        for i in range(n):
            v = h00 * v_old[i] + h01 * q[n + i] + h10 * a_old[i] + h11 * acc[i]
            for o in range(out.shape[0]):
                y[since // stride, o] += sign * out[o, i] * v / window


def integrate(
    system: System,
    height: Array,
    rate: Array,
    force: Array,
    *,
    initial: Array,
    step_s: float,
    first: int,
    stride: int,
    window_s: float,
    n_samples: int,
) -> Array:
    """Accelerations of the outputs.

    Parameters
    ----------
    system
        The mechanism.
    height, rate : (T + 1, m)
        Prescribed motions (m) and their rates (m/s) at every step.
    force : (2 T + 1, k)
        Applied forces (N) at every half step.
    initial : (2 n,)
        Displacements and velocities at the first step.
    step_s
        Step of the integration. Accuracy needs (highest natural frequency) × step below about 1.
    first, stride
        Sample i is taken at step first + i · stride.
    window_s
        Each sample is the mean acceleration over this window, centred on it; 0: the value itself.
    n_samples
        Number of samples; the last window must end before step T.

    Returns
    -------
    (n_samples, c) m/s²; NaN columns for outputs that are not predicted.
    """
    reach = first + (n_samples - 1) * stride + floor(0.5 * window_s / step_s) + 1
    if reach > len(height) - 1 or first < floor(0.5 * window_s / step_s) + 1:
        raise ValueError("the samples do not lie inside the integrated span")
    inverse = np.linalg.inv(system.mass)
    laws = padded(system.laws) if system.laws else None
    y: Array = _integrate(
        -inverse @ np.hstack([system.stiffness, system.damping]),
        inverse @ np.hstack([system.input_stiffness, system.input_damping]),
        np.ascontiguousarray(inverse @ system.force),
        system.port,
        system.port_input,
        np.ascontiguousarray(inverse @ system.port.T),
        np.array(system.port_law, dtype=np.int64),
        laws,
        system.law_parameters,
        np.nan_to_num(system.output),
        height,
        rate,
        force,
        initial,
        step_s,
        first,
        stride,
        window_s,
        n_samples,
    )
    y[:, np.isnan(system.output).any(axis=1)] = np.nan
    return y
