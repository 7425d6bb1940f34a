"""What a degenerate campaign does to single steps of a diagnosis: an order, and no warning."""

import re
import warnings
from dataclasses import replace

import numpy as np
import pytest

from tests.report.small import write_small_campaign
from wheelhop.campaign import CampaignError, Channel, read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.confirm.in_full import placed_anew
from wheelhop.diagnose.screen import first_order as screening
from wheelhop.diagnose.screen import signatures
from wheelhop.effects import load_effects
from wheelhop.effects.base import RunSetting
from wheelhop.effects.phase import shift_along
from wheelhop.vehicle import read_nominal


def test_an_effect_whose_simulation_runs_away_ranks_last_and_in_silence(tmp_path, monkeypatch):
    folder = write_small_campaign(tmp_path / "c")
    campaign = read_campaign(folder).select("washboard-high-fast", "washboard-high-slow")
    vehicle = read_nominal(campaign)
    base = fit_baseline(campaign, vehicle, progress=lambda text: None)
    stacked, variants = signatures._stacked, screening.variants
    calls = iter(range(1000))

    def first_runs_away(columns, size):
        """Every effect has two calls: its amplitudes, and what it leaves free in the run."""
        found = stacked(columns, size)
        return np.full_like(found, np.nan) if next(calls) < 2 else found

    monkeypatch.setattr(signatures, "_stacked", first_runs_away)
    monkeypatch.setattr(screening, "variants", lambda *about: variants(*about)[:1])
    library = load_effects()
    effects = [library[name] for name in ("speed-fluctuation", "dry-friction", "anti-roll-bar")]
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        found = screening.screen(base.workshop, base.rung.fit, effects)
    assert found[0].variant.effect.id == "dry-friction"
    assert found[-1].variant.effect.id == "speed-fluctuation" and found[-1].score == -np.inf


def test_an_effect_may_have_nothing_to_fit_in_one_of_the_runs(tmp_path, monkeypatch):
    """A car that stands does not brake."""
    campaign = read_campaign(write_small_campaign(tmp_path / "c"))
    campaign = campaign.select("washboard-high-fast", "washboard-low-slow")
    vehicle = read_nominal(campaign)
    base = fit_baseline(campaign, vehicle, progress=lambda text: None)
    braking = load_effects()["longitudinal-pitch"]
    moving = type(braking).per_run

    def per_run(effect, run):
        return moving(effect, run) if run.run_id == "washboard-high-fast" else ()

    monkeypatch.setattr(type(braking), "per_run", per_run)
    (found,) = screening.screen(base.workshop, base.rung.fit, [braking])
    assert np.isfinite(found.score)


def test_a_model_that_runs_away_has_no_better_place(tmp_path):
    campaign = read_campaign(write_small_campaign(tmp_path / "c")).select("washboard-high-fast")
    vehicle = read_nominal(campaign)
    base = fit_baseline(campaign, vehicle, progress=lambda text: None)
    engine = load_effects()["engine-vibration"]
    wild = base.rung.model.with_values({"suspension.front.damping_N_s_m": -1e6})
    wild = wild.with_effect(engine, base.workshop.parameters_of(engine))
    fitted = base.rung.fit
    runs = tuple(replace(r, residual=np.full_like(r.residual, np.inf)) for r in fitted.runs)
    rung = replace(base.rung, fit=replace(fitted, model=wild, runs=runs))
    assert placed_anew(base.workshop, rung) is wild


class StillAtTheEnd:
    """A record that is 0.1 m ahead of the model, and rests in its second half."""

    channels = (Channel("imu", "body"),)

    def time_s(self, run_id):
        return np.arange(1000) / 100.0

    def _signal(self, ahead_m):
        way = 2.0 * self.time_s("") + ahead_m
        return np.where(self.time_s("") < 5.0, np.sin(2 * np.pi * way), 0.0)[:, None]

    def measured(self, run_id):
        return self._signal(0.1)

    def all_modelled(self, run_id, trials):
        return [self._signal(trial["start_m"]) for trial in trials]


def test_windows_in_which_nothing_moves_tell_no_shift():
    run = RunSetting("r", 2.0, 0.0, 0.0, 10.0, True)
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)
        times, (ahead,) = shift_along(StillAtTheEnd(), run, (0,))
    assert ahead[times < 4.5] == pytest.approx(0.1, abs=0.02)
    assert np.isfinite(ahead).all()


def test_a_track_that_no_wheel_climbs_is_named(tmp_path):
    """A bump of 35 mm given as 350: the mistake of a campaign, not a program's."""
    folder = write_small_campaign(tmp_path / "c")
    file = folder / "campaign.toml"
    wall = 'track.kind = "step-bump"\ntrack.height_mm = 350.0\ntrack.width_mm = 1000.0\n'
    head, first, *others = file.read_text().split("[[run]]\n")
    first = re.sub(r"track\..*\n", "", first).rstrip() + "\n" + wall + "\n"
    file.write_text("[[run]]\n".join([head, first, *others]))
    campaign = read_campaign(folder)
    expected = f'{file}: run "{campaign.runs[0].id}": a step of 0.35 m is too high for a wheel'
    with pytest.raises(CampaignError, match=re.escape(expected)):
        fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)
