"""Runs that do not forget how they began: wheels that bounce from wave to wave."""

from dataclasses import replace

import pytest

from benchmarks.blind.vehicles import rougher
from tests.diagnose.cases import LIBRARY, diagnosed
from tests.report.small import write_small_campaign
from tests.truth import PRESETS
from tests.truth.campaign import write_campaign
from tests.truth.effects import make_effects
from wheelhop.campaign import read_campaign
from wheelhop.diagnose import fit_baseline
from wheelhop.diagnose.score import LAW
from wheelhop.diagnose.screen.signatures import variants
from wheelhop.diagnose.search.forgets import (
    begun_otherwise,
    never_forgotten,
    remaining,
    without_runs,
)
from wheelhop.gate import Finding, Gated
from wheelhop.vehicle import read_nominal


@pytest.mark.slow
def test_a_run_in_which_wheels_bounce_is_left_out_and_the_rest_is_diagnosed(tmp_path):
    """A light, hard car on tracks three times as rough: what it does on one of them hangs on how
    the run began, and would veil a sensor's gain on all the others."""
    hidden = {"tyre-lift-off": {}, "sensor-gain": {"channel": "A1", "gain_error": 0.08}}
    rough = rougher(PRESETS["formula-student"], 3.0)
    write_campaign(tmp_path, rough, make_effects(hidden), seed=101, short=True)
    # A driver who brakes is free in every run, and would follow what the others do not forget.
    library = {name: LIBRARY[name] for name in (*hidden, "dry-friction", "longitudinal-pitch")}
    found = diagnosed(tmp_path, library)
    assert set(found.verdict) == set(hidden)
    (finding,) = (f for f in found.findings if f.kind == "forgets")
    assert finding.about == "herringbone-high-fast" and "It is left out" in finding.remedy
    campaign = read_campaign(tmp_path)
    judged = found.ladder[-1].comparison.roles
    assert {run.id for run in campaign.runs} - set(judged) == {finding.about}


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    campaign = read_campaign(write_small_campaign(tmp_path_factory.mktemp("small") / "c"))
    return campaign, fit_baseline(campaign, read_nominal(campaign), progress=lambda text: None)


def test_a_linear_vehicle_forgets_within_its_run_up(small):
    _, base = small
    for run in base.rung.fit.runs:
        assert begun_otherwise(base.workshop, base.rung, run) < 2e-3
    assert never_forgotten(base.workshop, base.rung) == []


def test_nothing_is_left_out_where_no_run_to_fit_would_stay(small):
    campaign, _ = small
    every = [
        Finding("after", "forgets", run.id, "", "", "certain")
        for run in campaign.runs
        if run.role == "fit"
    ]
    assert remaining(campaign, every) == ()
    fewer = without_runs(Gated((), campaign), every[1:])
    assert len(fewer.findings) == len(every) - 1
    assert [run.id for run in fewer.campaign.fit_runs] == [every[0].about]


@pytest.mark.parametrize("name", [n for n, e in LIBRARY.items() if e.on_vehicle])
def test_no_effect_remembers_more_than_laws_differ_by(name, small):
    """Nothing in an effect's law may hang on where the run-up begins: clearly visible on a road
    that is no rougher than usual it changes the motion by far less than is left out for."""
    _, base = small
    workshop, model = base.workshop, base.rung.model
    for variant in variants(workshop, base.rung.fit, LIBRARY[name]):
        effect = variant.effect
        parameters = workshop.parameters_of(effect)
        strong = {p.name: p.typical for p in parameters}
        with_it = model.with_effect(effect, parameters).with_values(
            {f"{effect.id}.{name}": value for name, value in strong.items()}
        )
        for run in base.rung.fit.runs:
            setting = run.bench.simulator.setting
            own = {f"{effect.id}.{p.name}": p.scale for p in effect.per_run(setting)}
            with_own = with_it.with_run(run.bench.run.id, own)
            rung = replace(base.rung, fit=replace(base.rung.fit, model=with_own), validation=None)
            assert begun_otherwise(workshop, rung, run) < 0.4 * LAW
