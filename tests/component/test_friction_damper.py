"""A full-scale friction damper on a hydraulic actuator: D. Coble et al. 2022, CC BY-SA 4.0."""

from pathlib import Path

import pytest

from wheelhop.campaign import read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_nominal

DATA = Path(__file__).parents[1] / "data/friction-damper"


def test_friction_is_named_and_a_cubic_spring_is_not():
    """Residual over force by least squares, fitted and held-out runs, as the data's README has
    them: spring and damper 0.66 and 0.64, one elastic slip element 0.25 and 0.21, two 0.23 and
    0.19. The authors' plateaus are +13 and −9 kN, reached after about 5 mm."""
    campaign = read_campaign(DATA)
    found = diagnose(campaign, read_nominal(campaign), load_effects(), jobs=1)
    assert found.verdict[0] in ("dry-friction", "backlash")
    first, last = found.ladder[0].rung, found.ladder[-1].rung
    assert first.error_fit == pytest.approx(0.66, abs=0.01)
    assert first.error_validate == pytest.approx(0.64, abs=0.015)
    assert last.error_fit < 0.25 and last.error_validate < 0.21
    ranked = {item.effect: item for item in found.ranking}
    spring = ranked["progressive-spring"]
    assert spring.screened_error > 0.6
    assert spring.validated_error is None or spring.validated_error > 0.6
    slip, _ = found.ladder[-1].parameters["dry-friction.strut_N"]
    stiffness, _ = found.ladder[-1].parameters["dry-friction.presliding_N_m"]
    assert 9e3 < slip < 13e3
    assert 3e-3 < slip / stiffness < 6e-3
