"""Are all channels of a recording sampled at the same instant? A driven cantilever answers.

Away from resonance every point of a lightly damped beam moves in phase, or in antiphase, with its
drive, whatever the damping: what is left of the measured phases is the channels' own.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.sync.beam_file import BeamSession
from wheelhop.calibration.sync.faults import (
    ACCEPTABLE,
    Fault,
    find_faults,
    indistinct_pairs,
)
from wheelhop.calibration.sync.fit import Tones, fit_tones
from wheelhop.logger.recording import Recording

LIMIT_S = 0.5e-3
ACCELERATION = "m/s²"
NEAR_RESONANCE = 0.10  # of the natural frequency: dimensions and modulus are not known better
NODE = 0.10  # of the largest amplitude, below which a sensor sits near a node
SMALL_LOSS = 5e-3  # loss factor of which even a steel beam in its clamp is not sure
DAMPING_MODEL = 0.1  # part of that influence which damping of another kind may add
COVERAGE = 2.0
RAMP = 0.9  # part of the skews' variance that a straight ramp must explain to be called one

Real = NDArray[np.float64]


@dataclass(frozen=True)
class ChannelSkew:
    """One channel. `skew_s` is how much later than the first live channel it is sampled, NaN if
    it cannot be told, ± `expanded_s` (k = 2); `off_s` the distance within which half of the
    others lie. `measured` and `expected` are signed amplitudes at the frequencies used, in the
    recording's unit; expected of the stated force, or else of one that fits all best. `verdict` is
    "pass", "fail", "open" (the limit lies within the uncertainty)
    or "not told".
    """

    name: str
    position_m: float
    skew_s: float
    expanded_s: float
    off_s: float
    measured: tuple[float, ...]
    expected: tuple[float, ...]
    verdict: str


@dataclass(frozen=True)
class SyncCheck:
    """What a beam session says. `frequencies_hz` are those used, `refused` those that were not with
    the reason; `faults` what else is wrong; `ramp_s` the delay from one channel to the next where
    they are sampled in turn, 0 where not; `loss_factor` ± `loss_expanded` (k = 2) the damping
    found; `level` (f,) how many times as much the beam moves as the stated force moves it, empty if
    it cannot be said; `remarks` what the reader should know."""

    channels: tuple[ChannelSkew, ...]
    frequencies_hz: tuple[float, ...]
    refused: tuple[tuple[float, str], ...]
    faults: tuple[Fault, ...]
    ramp_s: float
    loss_factor: float
    loss_expanded: float
    remarks: tuple[str, ...]
    level: tuple[float, ...] = ()

    @property
    def passed(self) -> bool:
        """All channels pass, and nothing else is wrong."""
        return not self.faults and all(c.verdict == "pass" for c in self.channels)

    @property
    def skews_s(self) -> dict[str, float]:
        """By channel, for `align`."""
        return {c.name: c.skew_s for c in self.channels if not np.isnan(c.skew_s)}


@dataclass(frozen=True)
class _Estimate:
    """Skew (c,) up to a constant, NaN: not told; covariance (c, c); loss factor ± expanded."""

    skew_s: Real
    covariance: Real
    loss_factor: float
    loss_expanded: float


def check_synchronicity(
    recording: Recording, session: BeamSession, limit_s: float = LIMIT_S
) -> SyncCheck:
    """Compare a recording of the driven beam with theory.

    Raises CalibrationError where a channel is not in the recording, where the drive is not, or
    where every frequency is too near a resonance to tell.
    """
    at = _columns(recording, session)
    values = recording.values[:, at]
    used, refused = _usable(session)
    tones = fit_tones(values, recording.rate_hz, session.frequencies_hz)
    keep = [session.frequencies_hz.index(frequency) for frequency in used]
    tones = Tones(*(getattr(tones, f)[keep] for f in Tones.__dataclass_fields__))
    undamped = session.shape(tones.frequencies_hz, 0.0).real
    phase = np.angle(np.sum(tones.ratios**2, axis=1)) / 2  # of all, whatever their signs
    aligned = tones.ratios * np.exp(-1j * phase)[:, None]
    signed = np.abs(aligned) * np.where(aligned.real < 0, -1.0, 1.0)
    noise = tones.uncertainty / np.abs(signed).max(axis=1, keepdims=True)
    faults, expected, chi = find_faults(signed, undamped, noise, session.channels)
    slope = _damping_slope(session, tones.frequencies_hz)
    shape = expected.of(undamped)
    estimate = _estimate(tones, shape, slope[:, expected.at], session.loss_factor)
    factor = np.sum(signed * shape, axis=1) / np.sum(shape**2, axis=1) * tones.amplitudes
    drawn, level = factor, np.zeros(0)
    if session.force_N and all(recording.channels[i].unit == ACCELERATION for i in at):
        kept = np.sinc(tones.frequencies_hz * recording.averaging_s)
        drawn = np.sign(factor) * session.force_N * kept
        level = factor / drawn
    channels = _channels(session, tones, signed, drawn, estimate, limit_s)
    return SyncCheck(
        channels,
        tuple(float(f) for f in tones.frequencies_hz),
        refused,
        faults,
        _ramp(recording, channels),
        estimate.loss_factor,
        estimate.loss_expanded,
        (*_remarks(session, undamped, noise, chi, faults), *_unforced(session, level)),
        tuple(level.tolist()),
    )


def _columns(recording: Recording, session: BeamSession) -> list[int]:
    names = [channel.name for channel in recording.channels]
    for name in session.channels:
        if name not in names:
            raise CalibrationError(
                f"[[sensor]] {name!r}: the recording has no such channel, only {', '.join(names)}"
            )
    return [names.index(name) for name in session.channels]


def _usable(session: BeamSession) -> tuple[tuple[float, ...], tuple[tuple[float, str], ...]]:
    """The frequencies away from resonance, and the others with the reason."""
    natural = session.beam.natural_frequencies_hz(2 * max(session.frequencies_hz))
    refused = []
    for frequency in session.frequencies_hz:
        for own in natural[np.abs(natural / frequency - 1) < NEAR_RESONANCE]:
            refused.append(
                (
                    frequency,
                    f"{frequency:g} Hz is within {NEAR_RESONANCE:.0%} of the beam's natural"
                    f" frequency {own:.2f} Hz: phases there depend on damping",
                )
            )
            break
    bad = {frequency for frequency, _ in refused}
    used = tuple(f for f in session.frequencies_hz if f not in bad)
    if not used:
        better = [np.sqrt(a * b) for a, b in pairwise(natural)]
        nearest = min(better, key=lambda f: abs(f - session.frequencies_hz[0]), default=np.nan)
        hint = f"; drive at {nearest:.1f} Hz, midway between two" if better else ""
        raise CalibrationError("; ".join(reason for _, reason in refused) + hint)
    return used, tuple(refused)


def _damping_slope(session: BeamSession, frequencies_hz: Real) -> Real:
    """(f, c) seconds by which a loss factor of 1 would let a channel seem sampled later.

    Structural damping turns a channel's phase in proportion while it is small; the turn common to
    all channels is taken out. Infinite near a node.
    """
    small = max(session.loss_factor, SMALL_LOSS)
    still = session.shape(frequencies_hz, 0.0)
    turned = session.shape(frequencies_hz, small) * still.conj()
    turn = np.angle(turned / turned.sum(axis=1, keepdims=True))
    size = np.abs(still) / np.abs(still).max(axis=1, keepdims=True)
    return np.where(size > NODE, turn / small / (2 * np.pi * frequencies_hz[:, None]), np.inf)


def _estimate(tones: Tones, shape: Real, slope: Real, loss: float) -> _Estimate:
    """Skews, as far as they can be told, from all frequencies by weighted least squares.

    phase / ω = skew of the channel + an instant of the frequency + slope · loss factor. The loss
    factor is one more unknown, which the assumed value only starts with (± 100 %); `DAMPING_MODEL`
    is for damping of another kind.
    """
    n_f, n_c = slope.shape
    omega = 2 * np.pi * tones.frequencies_hz[:, None]
    turned = tones.ratios * np.sign(shape)
    turned = turned * np.exp(-1j * np.angle(turned.sum(axis=1, keepdims=True)))
    late = np.angle(turned) / omega
    noise = tones.uncertainty / np.maximum(np.abs(turned), 1e-30) / omega
    assumed = max(loss, SMALL_LOSS)
    usable = np.isfinite(slope) & (shape != 0)
    f, c = np.nonzero(usable)
    design = np.zeros((len(f) + 1, n_c + n_f + 1))
    rows = np.arange(len(f))
    design[rows, c] = design[rows, n_c + f] = 1.0
    design[rows, -1] = slope[f, c]
    design[-1, -1] = 1.0
    sigma = np.append(np.hypot(noise, DAMPING_MODEL * slope * assumed)[f, c], assumed)
    goal = np.append(late[f, c], loss) / sigma
    weighted = design / sigma[:, None]
    scale = np.linalg.norm(weighted, axis=0) + (np.abs(weighted).max(axis=0) == 0)
    covariance = np.linalg.pinv(weighted.T @ weighted / np.outer(scale, scale)) / np.outer(
        scale, scale
    )
    found = covariance @ weighted.T @ goal
    freedom = len(goal) - int(np.linalg.matrix_rank(weighted / scale))
    excess = float(np.sum((weighted @ found - goal) ** 2))
    covariance = covariance * max(1.0, excess / freedom if freedom > 0 else 1.0)  # Birge ratio
    return _Estimate(
        np.where(usable.any(axis=0), found[:n_c], np.nan),
        covariance[:n_c, :n_c],
        float(found[-1]),
        COVERAGE * float(covariance[-1, -1]) ** 0.5,
    )


def _channels(
    session: BeamSession,
    tones: Tones,
    signed: Real,
    drawn: Real,
    estimate: _Estimate,
    limit_s: float,
) -> tuple[ChannelSkew, ...]:
    skew, covariance = estimate.skew_s, estimate.covariance
    variance = np.diag(covariance)
    between = np.sqrt(np.maximum(variance[:, None] + variance - 2 * covariance, 0.0))
    told = np.flatnonzero(~np.isnan(skew))
    undamped = session.shape(tones.frequencies_hz, 0.0).real
    out = []
    for c, name in enumerate(session.channels):
        later, expanded, off = np.nan, np.nan, np.nan
        verdict = "not told"
        others = told[told != c]
        if c in told and len(others):
            later = skew[c] - skew[told[0]]
            apart = sorted((abs(skew[c] - skew[o]), between[c, o]) for o in others)
            off, doubt = apart[(len(apart) - 1) // 2]
            expanded = COVERAGE * max(doubt, between[c, told[0]])
            verdict = _verdict(off, COVERAGE * doubt, limit_s)
        out.append(
            ChannelSkew(
                name,
                session.positions_m[c],
                float(later),
                float(expanded),
                float(off),
                tuple(float(v) for v in signed[:, c] * tones.amplitudes),
                tuple(float(v) for v in drawn * undamped[:, c]),
                verdict,
            )
        )
    return tuple(out)


def _verdict(off_s: float, expanded_s: float, limit_s: float) -> str:
    if off_s + expanded_s <= limit_s:
        return "pass"
    return "fail" if off_s - expanded_s > limit_s else "open"


def _ramp(recording: Recording, channels: tuple[ChannelSkew, ...]) -> float:
    """Seconds from one channel of the recorder to the next where skews lie on a straight ramp."""
    names = [channel.name for channel in recording.channels]
    told = [c for c in channels if not np.isnan(c.skew_s)]
    if len(told) < 3:
        return 0.0
    order = np.array([names.index(c.name) for c in told], dtype=np.float64)
    skew = np.array([c.skew_s for c in told])
    order, skew = order - order.mean(), skew - skew.mean()
    step = float(order @ skew / (order @ order))
    explained = step**2 * (order @ order) / max(float(skew @ skew), 1e-30)
    doubt = max(c.expanded_s for c in told) / np.sqrt(order @ order)
    return step if explained > RAMP and abs(step) > 5 * doubt else 0.0


def _unforced(session: BeamSession, level: Real) -> tuple[str, ...]:
    if not session.force_N or len(level):
        return ()
    return (f"force_N is stated and the recording is not in {ACCELERATION}: decode it calibrated",)


def _remarks(
    session: BeamSession, shape: Real, noise: Real, chi: float, faults: tuple[Fault, ...]
) -> tuple[str, ...]:
    found = []
    if chi > ACCEPTABLE:
        found.append(
            "amplitudes do not fit the beam described: check its dimensions and the positions"
        )
    for pair in indistinct_pairs(shape, noise, session.channels):
        found.append(
            f"whether {pair[0]} and {pair[1]} are exchanged cannot be seen at these frequencies"
        )
    if len(shape) == 1:
        found.append(
            "one frequency: the uncertainty holds the assumed damping; two or more measure it"
        )
    if any(fault.rivals for fault in faults):
        found.append("where 'or' stands, another frequency would tell")
    return tuple(found)
