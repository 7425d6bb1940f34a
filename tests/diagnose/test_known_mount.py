"""A vehicle whose struts stand on a specimen measured on a rig: an independent simulator hides the
mount, with one relaxation of its own, and the specimen's file is beside vehicle.toml."""

from dataclasses import dataclass

import numpy as np
import pytest

from tests.truth import campaign as truth
from tests.truth.presets import PRESETS
from tests.truth.suspension_effects import MountBushing
from wheelhop.campaign import read_campaign
from wheelhop.diagnose.search.ladder import steps_with
from wheelhop.effects import load_effects
from wheelhop.material import GeneralizedMaxwell, Specimen, write_specimen
from wheelhop.vehicle import read_nominal

SPRING, CHAIN, TIME_S = 8e4, 6e4, 0.02


@dataclass
class RelaxingMount(MountBushing):
    """The mount of the truth with a Maxwell chain beside: E z, z the spring's part of u, by the
    trapezoidal rule with what the chain had at the last step."""

    def start(self, drive):
        super().start(drive)
        self._step, self._dashpot = 2 * self._half_step, np.zeros(4)

    def suspension(self, force, compression, rate):
        direct = self._k * compression + self._c * rate
        damping = self._c + self.damping_N_s_m
        stiffness = self._k + self.stiffness_N_m + CHAIN
        predicted = self._give + self._half_step * self._give_rate
        known = direct + CHAIN * self._dashpot - stiffness * predicted
        self._give_rate = known / (damping + stiffness * self._half_step)
        before = self._give
        self._give = predicted + self._half_step * self._give_rate
        own = self._k * (compression - self._give) + self._c * (rate - self._give_rate)
        share = self._half_step / TIME_S
        middle = before + self._give
        self._dashpot = ((1 - share) * self._dashpot + share * middle) / (1 + share)
        return force + own - direct


RUNS = ("washboard-low-slow", "washboard-high-fast", "washboard-high-slow")


@pytest.mark.slow
def test_the_mount_is_recovered_from_a_vehicle_campaign(tmp_path, monkeypatch):
    """Once as stiff as measured, front and rear, within three standard deviations and 15 %: from
    two runs, and a third that is not fitted."""
    planned = truth.planned_runs
    monkeypatch.setattr(
        truth, "planned_runs", lambda *a, **k: [r for r in planned(*a, **k) if r.id in RUNS]
    )
    hidden = [RelaxingMount(stiffness_N_m=SPRING, damping_N_s_m=20.0)]
    folder = truth.write_campaign(tmp_path / "c", PRESETS["atv"], hidden, seed=7, short=True)
    model = GeneralizedMaxwell([TIME_S])
    specimen = Specimen("mount", model, np.array([SPRING, CHAIN]), (1.0, 30.0))
    write_specimen(folder / "specimen.toml", specimen)
    vehicle = folder / "vehicle.toml"
    vehicle.write_text('mount = "specimen.toml"\n' + vehicle.read_text())
    campaign = read_campaign(folder)
    assert len(campaign.fit_runs) == 2 and len(campaign.validate_runs) == 1
    effect = load_effects()["mount-bushing"]
    before, after = steps_with(campaign, read_nominal(campaign), [effect], lambda text: None)
    assert after.rung.error < 0.5 * before.rung.error
    for end in ("front", "rear"):
        value, spread = after.parameters[f"mount-bushing.{end}_mounts"]
        assert abs(value - 1.0) < 3 * spread + 0.05
        assert value == pytest.approx(1.0, abs=0.15)
