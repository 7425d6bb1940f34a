"""Angles between signatures, and the run that would settle a doubt."""

import numpy as np
import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY, baseline_of
from wheelhop.diagnose.confirm.in_full import confirm
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.score import Rung
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.diagnose.search.scored import Candidate
from wheelhop.diagnose.verdict.ranking import AMBIGUOUS_DEG, Angles
from wheelhop.effects.dry_friction import DryFriction


class Twin(DryFriction):
    """The same physics under another name."""

    id = "twin"

    def with_choice(self, choice):
        return Twin(choice)


@pytest.fixture(scope="module")
def base(tmp_path_factory):
    case = CASES["dry-friction"]
    folder = truth.make_campaign(
        tmp_path_factory.mktemp("friction"),
        seed=case.seed,
        effects=case.hidden,
        short=True,
        draft=True,
    )
    return baseline_of(folder)


@pytest.fixture(scope="module")
def screened(base):
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


def test_at_the_fitted_strength_the_angle_is_what_the_rival_leaves(base, screened):
    """What explains everything changes the records by the whole residual r, a least-squares rival
    by the part of it that it explains: sin² of the angle between is the share it leaves."""
    fitted, found = screened
    pair = {s.variant.effect.id: s for s in found}
    candidates, share = [], dict[str, float]()
    for name in ("dry-friction", "digressive-damper"):
        fit = confirm(Incumbent(base.workshop, base.rung), pair[name]).fit
        candidates.append(Candidate(pair[name], Rung(fit, None), 0.0, 1, True))
        weighed = [
            (run.residual / before.spread, before.surprise)
            for run, before in zip(fit.runs, fitted.runs, strict=True)
        ]
        share[name] = sum(r @ r for r, _ in weighed) / sum(b @ b for _, b in weighed)
    assert share["dry-friction"] < 0.2 * share["digressive-damper"]
    angle = Angles(fitted, found, candidates).between("dry-friction", "digressive-damper")
    expected = np.degrees(np.arcsin(np.sqrt(share["digressive-damper"] - share["dry-friction"])))
    assert angle == pytest.approx(expected, rel=0.15)
    assert angle < 0.6 * Angles(fitted, found).between("dry-friction", "digressive-damper")
