"""Whatever effects a model has, and wherever its numbers lie: an answer that is not finite is one
that is infinitely far off, and no effect that looks at it ends a diagnosis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests import truth
from tests.component import rig
from tests.component.cases import DAMPER, OSCILLATOR
from wheelhop.campaign import Campaign, TrackSpec, read_campaign
from wheelhop.diagnose.verdict.stability import unstable
from wheelhop.effects import Effect, Shape, load_effects
from wheelhop.fit import FitProbe, Workshop, fit, initial_model, linearised
from wheelhop.fit.parameters import effect_run_parameters, run_parameters
from wheelhop.fit.probe import NotFinite
from wheelhop.simulate import Model
from wheelhop.vehicle import read_nominal

DRIVES = ("road", "axles", "travel", "displacement", "force")
LIBRARY = load_effects()


def campaign_on(drive: str, folder) -> Campaign:
    """One short run, moved in one of the ways a model can be."""
    if drive in ("displacement", "force"):
        component = DAMPER if drive == "displacement" else OSCILLATOR
        rig.make_campaign(folder / "c", drive, component, seed=1, noise=0.01, seconds=2.0)
        campaign = read_campaign(folder / "c")
    else:
        sensors = truth.SENSORS if drive == "travel" else None
        more = {} if sensors is None else {"sensors": sensors}
        truth.make_campaign(folder / "c", seed=1, effects={}, short=True, seconds=2.0, **more)
        campaign = read_campaign(folder / "c")
    runs = campaign.fit_runs[:1]
    if drive in ("axles", "travel"):
        runs = tuple(replace(run, track=TrackSpec("unknown", {})) for run in runs)
    return replace(campaign, runs=runs)


class Thrown:
    """Models of one campaign with effects whose numbers are thrown anywhere they may lie."""

    def __init__(self, campaign: Campaign, seed: int) -> None:
        nominal = read_nominal(campaign)
        self.base = initial_model(campaign, nominal)
        self.workshop = Workshop(campaign, self.base, jobs=1)
        self.bench = next(iter(self.workshop.benches.values()))
        self.rng = np.random.default_rng(seed)
        self.effects = [e for e in LIBRARY.values() if self._acts(e)]

    def _acts(self, effect: Effect) -> bool:
        return effect.applies_to(self.base.values) and self.bench.simulator.acts(effect)

    def model(self, effects: tuple[Effect, ...]) -> Model:
        """A form of each at random, amplitudes to ten times what shows clearly."""
        model = self.base
        for effect in effects:
            form = effect.with_choice(
                str(self.rng.choice(effect.choices(self.workshop.campaign.channels)))
            )
            parameters = self.workshop.parameters_of(form)
            thrown = {
                f"{form.id}.{p.name}": float(
                    np.clip(p.start + 10.0 * p.scale * self.rng.normal(), p.lower, p.upper)
                )
                for p in parameters
            }
            own = {
                f.name: float(np.clip(f.mean + 3.0 * f.scale * self.rng.normal(), f.lower, f.upper))
                for f in effect_run_parameters(self.bench.simulator.setting, form)
            }
            model = model.with_effect(form, parameters).with_values(thrown)
            model = model.with_run(self.bench.run.id, own)
        own = run_parameters(self.bench.run, self.bench.simulator.setting, model)
        means = {f.name: f.mean for f in own} | dict(model.runs.get(self.bench.run.id, {}))
        return model.with_run(self.bench.run.id, means)

    def check(self, effects: tuple[Effect, ...]) -> None:
        """Data are numbers or infinite, a fit begins, and all who look find something."""
        model, run_id = self.model(effects), self.bench.run.id
        data = self.bench.modelled(model, self.workshop.systems(model))
        assert not np.isnan(data).any(), model
        begun = linearised(self.workshop, model, (), [self.bench])
        with np.errstate(over="ignore"):  # of 1e225
            square = float(np.sum(data**2))
        assert not np.isnan(begun.rss) and (np.isfinite(begun.rss) or np.isinf(square))
        probe = FitProbe(self.workshop, model, [self.bench])
        for effect in self.effects:
            other = effect.with_choice(effect.choices(self.workshop.campaign.channels)[0])
            for start in probe.shape_starts(other):
                assert all(np.isfinite(value) for value in start.values())
            setting = self.bench.simulator.setting
            shapes = {
                p.name: p.start for p in self.workshop.parameters_of(other) if isinstance(p, Shape)
            }
            assert probe.run_starts(other, setting, shapes)
        assert all(ran == run_id for ran, _ in self.workshop.run_away)

    def drawn(self, count: int) -> Iterator[tuple[Effect, ...]]:
        """So many pairs and triples."""
        for k in range(count):
            chosen = self.rng.choice(len(self.effects), size=2 + k % 2, replace=False)
            yield tuple(self.effects[i] for i in chosen)


@pytest.mark.parametrize("drive", DRIVES)
def test_pairs_and_triples_of_effects_anywhere(drive, tmp_path):
    thrown = Thrown(campaign_on(drive, tmp_path), seed=2)
    for effects in thrown.drawn(4):
        thrown.check(effects)


@pytest.mark.slow
@pytest.mark.parametrize("drive", DRIVES)
def test_every_pair_and_many_triples_of_effects_anywhere(drive, tmp_path):
    thrown = Thrown(campaign_on(drive, tmp_path), seed=3)
    for effects in (*combinations(thrown.effects, 2), *thrown.drawn(200)):
        thrown.check(effects)


@pytest.fixture
def away(tmp_path):
    """A component whose spring pushes: x grows without bounds."""
    campaign = campaign_on("force", tmp_path)
    model = initial_model(campaign, read_nominal(campaign))
    workshop = Workshop(campaign, model, jobs=1)
    pushing = model.with_values({"component.stiffness_N_m": -1e7})
    (bench,) = workshop.benches.values()
    start = {"initial_m": 0.01, "initial_m_s": 0.0, "offset_N": 0.0}
    return workshop, pushing.with_run(bench.run.id, start), bench


def test_what_is_not_finite_is_infinitely_far_off(away):
    workshop, model, bench = away
    assert np.isnan(bench.records([(model, workshop.systems(model))])[0]).any()
    assert np.isinf(bench.modelled(model, workshop.systems(model))).all()
    assert fit(workshop, model, (), [bench]).rss == np.inf


def test_a_probe_says_which_model_ran_away_and_begins_as_usual(away):
    class Looks(Effect):
        id = "looks"

        def shape_starts(self, probe):
            return [{"width_m": float(np.ptp(probe.modelled(probe.settings[0].run_id, {})))}]

        def run_starts(self, probe, run, shapes):
            return [{"phase_rad": float(probe.modelled(run.run_id, {}).max())}]

    workshop, model, bench = away
    probe = FitProbe(workshop, model, [bench])
    assert probe.shape_starts(Looks()) == ()
    assert probe.run_starts(Looks(), bench.simulator.setting, {}) == ({},)
    (finding,) = unstable(workshop.run_away)
    assert finding.about == bench.run.id and "baseline runs away" in finding.text
    with pytest.raises(NotFinite, match="runs away in run"):
        probe.modelled(bench.run.id, {})
