"""Laws of worn and special parts, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from tests.truth import Run, Track, integrate
from tests.truth import outside_laws as laws
from tests.truth.body_effects import DriverSeat
from tests.truth.closed_form import ATV
from tests.truth.test_outside_effects import STEP, driven
from tests.truth.vehicle import suspension_static_load

K = 1e4
SLOW = np.concatenate([np.linspace(0.0, 0.05, 4001), np.linspace(0.05, -0.05, 8001)[1:]])


def test_a_loose_spring_pulls_nothing_while_it_is_off_its_seat() -> None:
    total = K * SLOW + driven(laws.OneSidedPlay(0.02, 0.01), SLOW)
    off = (SLOW < -0.02) & (SLOW > -0.03)
    np.testing.assert_allclose(total[off], -200.0)
    np.testing.assert_allclose(total[SLOW > -0.02], K * SLOW[SLOW > -0.02])
    assert total[-1] == pytest.approx(-400.0)


def test_a_rubber_is_stiffest_where_it_begins() -> None:
    force = driven(laws.BumpRubber(0.02, 900.0), SLOW)
    assert not force[SLOW <= 0.02].any()
    begin = (SLOW > 0.02) & (SLOW < 0.0201)
    np.testing.assert_allclose(force[begin] / (SLOW[begin] - 0.02), 900.0 * 1.3 * 150.0, rtol=1e-2)
    assert force.max() < 900.0


def test_a_cracked_weld_opens_on_one_side_of_one_corner() -> None:
    force = driven(laws.CrackedWeld(1.0, 0.3), SLOW)
    np.testing.assert_allclose(force, np.where(SLOW < 0.0, -0.3 * K * SLOW, 0.0), atol=1e-9)
    assert not driven(laws.CrackedWeld(3.0, 0.3), SLOW).any()


def test_a_valve_stays_open_below_where_it_opened() -> None:
    speed = np.concatenate([np.linspace(0.0, 1.0, 20000), np.linspace(1.0, 0.0, 20000)])
    added = driven(laws.BlowOffValve(0.5, 0.2, 0.2, 0.0), np.cumsum(speed) * STEP)
    rising, falling = 8000, 32000  # at 0.4 m/s
    assert added[rising] == pytest.approx(0.0)
    assert added[falling] == pytest.approx(-0.8 * 500.0 * 0.2, rel=1e-2)


def test_friction_follows_the_load() -> None:
    force = driven(laws.LoadFriction(0.05, 0.05), SLOW)
    load = suspension_static_load(ATV)[0]
    sliding = np.arange(len(SLOW)) > 5000  # coming back
    np.testing.assert_allclose(force[sliding], -0.05 * (load + K * SLOW[sliding]).clip(0.0))


def test_a_seat_sticks_until_it_is_pulled_loose() -> None:
    """With much friction the car is one whose driver sits still, with none the softly sprung."""
    track = Track("washboard", {"amplitude_mm": 8.0, "pitch_mm": 600.0})
    run = Run(track, 2.0, 35.0, np.array([0.0, 0.5]))

    def motion(*effects: object) -> np.ndarray:
        found = integrate(ATV, run, effects)
        return found.velocity[found.time > -1.0]

    free = motion(DriverSeat(70.0, 3.0, 0.3, -0.1))
    still, loose = motion(), motion(laws.StickSlipSeat(70.0, 3.0, 0.3, -0.1, 0.0, 1e-3))
    stuck = motion(laws.StickSlipSeat(70.0, 3.0, 0.3, -0.1, 0.0, 2000.0))
    between = motion(laws.StickSlipSeat(70.0, 3.0, 0.3, -0.1, 0.0, 30.0))
    apart = np.linalg.norm(still - free)
    assert np.linalg.norm(loose - free) < 0.01 * apart
    assert np.linalg.norm(stuck - still) < 0.05 * apart
    assert min(np.linalg.norm(between - other) for other in (still, free)) > 0.2 * apart
