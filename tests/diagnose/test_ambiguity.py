"""Angles between signatures, and the run that would settle a doubt."""

import numpy as np
import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY, baseline_of
from wheelhop.diagnose.ambiguity import AMBIGUOUS_DEG, Angles
from wheelhop.diagnose.screen import screen
from wheelhop.effects.dry_friction import DryFriction


class Twin(DryFriction):
    """The same physics under another name."""

    id = "twin"

    def with_choice(self, choice):
        return Twin(choice)


@pytest.fixture(scope="module")
def screened(tmp_path_factory):
    case = CASES["dry-friction"]
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("friction"), seed=case.seed, effects=case.hidden, short=True
    )
    base = baseline_of(folder)
    names = ("dry-friction", "digressive-damper", "progressive-spring", "driver-seat")
    effects = [*(LIBRARY[name] for name in names), Twin()]
    fitted = base.rung.fit
    return fitted, screen(base.workshop, fitted, effects)


def test_what_is_hidden_is_screened_first(screened):
    _, found = screened
    assert {found[0].variant.effect.id, found[1].variant.effect.id} == {"dry-friction", "twin"}
    assert all(np.isfinite(s.gain) and s.error >= 0 for s in found)


def test_angles_are_symmetric_and_the_twin_cannot_be_told_apart(screened):
    angles = Angles(*screened)
    names = [s.variant.effect.id for s in screened[1]]
    for one in names:
        for other in names:
            angle = angles.between(one, other)
            assert 0.0 <= angle <= 90.0
            assert angle == pytest.approx(angles.between(other, one))
    assert angles.between("dry-friction", "twin") == pytest.approx(0.0, abs=0.1)
    assert angles.near("dry-friction")[0][0] == "twin"
    near = [angle for _, angle in angles.near("dry-friction")]
    assert near == sorted(near) and all(angle < AMBIGUOUS_DEG for angle in near)
    assert angles.between("dry-friction", "driver-seat") > AMBIGUOUS_DEG
    assert angles.between("dry-friction", "nobody") == 90.0
