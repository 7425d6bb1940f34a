"""Faults planted into random beam sessions are named, and nothing is named where there is none."""

from itertools import pairwise

import numpy as np
import pytest

from wheelhop.calibration.sync.beam import Beam
from wheelhop.calibration.sync.beam_file import BeamSession
from wheelhop.calibration.sync.check import check_synchronicity
from wheelhop.hil_sim.beam_rig import BeamRig

SESSIONS = 100
KINDS = ("skewed", "swapped", "inverted", "dead")


def ruler(positions_m, frequencies_hz, *, modulus=2e11, sensor_kg=2e-3, loss_factor=0.006):
    """The thesis's steel ruler with sensors, driven at its free end."""
    beam = Beam.rectangular(0.6096, 0.0254, 0.000635, modulus, 7850.0).carrying(0.6096)
    for position in positions_m:
        beam = beam.carrying(position, sensor_kg)
    names = tuple(f"A{i}" for i in range(len(positions_m)))
    return BeamSession(beam, loss_factor, 0.6096, tuple(frequencies_hz), names, tuple(positions_m))


def random_session(draw):
    """What the user describes, and the slightly different truth."""
    count = int(draw.integers(4, 9))
    positions = np.linspace(0.2, 0.98, count) * 0.6096 + draw.uniform(-6e-3, 6e-3, count)
    natural = ruler(positions, [1.0]).beam.natural_frequencies_hz(90.0)
    between = [a + draw.uniform(0.35, 0.65) * (b - a) for a, b in pairwise(natural[1:])]
    described = ruler(positions, [f for f in between if f < 44.0])
    true = ruler(
        positions + draw.normal(0.0, 0.5e-3, count),
        described.frequencies_hz,
        modulus=2e11 * (1 + 0.02 * draw.normal()),
        loss_factor=draw.uniform(0.002, 0.015),
    )
    return described, true


def planted(draw, kind, names):
    """Settings of the rig, and the channels whose names must come out."""
    gain = {name: 1 + 0.03 * draw.normal() for name in names}
    one, other = (str(name) for name in draw.choice(names, 2, replace=False))
    if kind == "skewed":
        late = draw.choice([-1, 1]) * draw.uniform(0.7e-3, 2e-3)
        return {"gain": gain, "late_s": {one: late}}, (one,)
    if kind == "swapped":
        return {"gain": gain, "swapped": (one, other)}, tuple(sorted((one, other)))
    return {"gain": gain | {one: -gain[one] if kind == "inverted" else 0.0}}, (one,)


def recorded(draw, true, **settings):
    count = len(true.frequencies_hz)
    rig = BeamRig(true, (0.6,) * count, clock_ppm=draw.uniform(-3000, 3000), **settings)
    return rig.record(20.0, seed=int(draw.integers(1 << 31)))


@pytest.mark.parametrize("kind", KINDS)
def test_every_planted_fault_is_named(kind):
    missed = []
    for number in range(SESSIONS // len(KINDS)):
        draw = np.random.default_rng([KINDS.index(kind), number])
        described, true = random_session(draw)
        settings, guilty = planted(draw, kind, described.channels)
        check = check_synchronicity(recorded(draw, true, **settings), described)
        if kind == "skewed":
            named = tuple(c.name for c in check.channels if c.verdict == "fail")
            right = named == guilty and not check.faults
        else:
            right = [(f.kind, f.channels, f.rivals) for f in check.faults] == [(kind, guilty, ())]
        if not right or check.passed:
            missed.append((number, guilty, [str(f) for f in check.faults], check.remarks))
    assert missed == []


def test_untouched_sessions_pass():
    wrong, spans = [], []
    for number in range(SESSIONS):
        draw = np.random.default_rng([9, number])
        described, true = random_session(draw)
        gain = {name: 1 + 0.03 * draw.normal() for name in described.channels}
        check = check_synchronicity(recorded(draw, true, gain=gain), described)
        spans += [(abs(c.skew_s), c.expanded_s) for c in check.channels if c.skew_s != 0.0]
        if not check.passed or check.ramp_s:
            wrong.append(
                (number, [(c.name, c.verdict, c.off_s) for c in check.channels], check.faults)
            )
    assert wrong == []
    assert np.mean([error <= expanded for error, expanded in spans]) > 0.9  # k = 2
    assert np.median([expanded for _, expanded in spans]) < 30e-6
