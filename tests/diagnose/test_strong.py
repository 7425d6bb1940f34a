"""An effect so strong that first order about the vehicle fitted without it sees none of it."""

import pytest

from tests import truth
from tests.diagnose.cases import LIBRARY, baseline_of
from wheelhop.diagnose.confirm.in_full import confirm, confirm_strong
from wheelhop.diagnose.confirm.starts import strong
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.screen.first_order import screen

HELD = {"dry-friction": {"coulomb_front_N": 145.0, "coulomb_rear_N": 220.0}}


@pytest.mark.slow
def test_friction_that_nearly_always_holds_is_found_where_it_is_strong(tmp_path):
    """The baseline has springs as stiff as the joints that hold. Begun as strong as shows clearly,
    where the vehicle is believed to be, a formula car's friction is the first of all, and leaves
    noise; begun at what first order expects, it leaves more."""
    folder = truth.make_campaign(
        tmp_path, seed=103, effects=HELD, preset="formula-student", short=True, draft=True
    )
    base = baseline_of(folder)
    workshop, incumbent = base.workshop, Incumbent(base.workshop, base.rung)
    screened = screen(workshop, base.rung.fit, list(LIBRARY.values()))
    (friction,) = [s for s in screened if s.variant.effect.id == "dry-friction"]
    noise = workshop.noise**2 * base.rung.fit.size
    rough = confirm(incumbent, friction)
    first, start = strong(incumbent, screened)[0]
    assert first.variant.effect.id == "dry-friction"
    rung = confirm_strong(incumbent, start, [])
    assert rung.fit.rss < 1.05 * noise < rough.fit.rss
    # What accelerations tell are forces per mass.
    values = rung.model.values
    ratio = values["dry-friction.rear_N"] / values["dry-friction.front_N"]
    assert ratio == pytest.approx(220.0 / 145.0, rel=0.05)


def test_where_the_vehicle_is_believable_nothing_is_begun_strong(tmp_path):
    folder = truth.make_campaign(
        tmp_path, seed=104, effects={}, preset="formula-student", short=True, draft=True
    )
    base = baseline_of(folder)
    screened = screen(base.workshop, base.rung.fit, [LIBRARY["dry-friction"]])
    assert strong(Incumbent(base.workshop, base.rung), screened) == []
