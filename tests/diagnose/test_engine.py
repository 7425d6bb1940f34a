"""An engine in runs that were fitted is the engine of those held out."""

import numpy as np
import pytest

from tests import truth
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.confirm.in_full import confirm
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import load_effects
from wheelhop.vehicle import read_nominal

HZ, FORCE_N = 12.376, 1400.0


def test_a_strong_line_is_found_in_the_runs_held_out(tmp_path):
    """One frequency for all runs and each run's share of it are told apart by what is believed of
    an engine alone: a fit may shift one against the other, and a run held out took no part."""
    place = truth.PRESETS["passenger-car"].vehicle
    engine = {"force_N": FORCE_N, "freq_hz": HZ, "x_m": place["engine.x_m"], "y_m": 0.0}
    truth.make_campaign(
        tmp_path,
        seed=3,
        effects={"engine-vibration": engine},
        preset="passenger-car",
        short=True,
        seconds=6.0,
        draft=True,
    )
    campaign = read_campaign(tmp_path)
    base = fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
    (screened,) = screen(base.workshop, base.rung.fit, [load_effects()["engine-vibration"]])
    found = confirm(Incumbent(base.workshop, base.rung), screened)
    assert found.error_validate < 0.2 * base.rung.error_validate
    assert found.model.values["engine-vibration.freq_hz"] == pytest.approx(HZ, rel=0.03)
    for own in found.model.runs.values():
        force = {key: own[f"engine-vibration.{key}"] for key in ("cos_m_s2", "sin_m_s2", "excess")}
        shaken = np.hypot(force["cos_m_s2"], force["sin_m_s2"])
        assert shaken == pytest.approx(FORCE_N / place["body.mass_kg"], rel=0.05)
        turned = (1.0 + force["excess"]) * found.model.values["engine-vibration.freq_hz"]
        assert turned == pytest.approx(HZ, rel=2e-3)
