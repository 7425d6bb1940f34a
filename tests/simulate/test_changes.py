"""What a small change of a number makes of a record, in longer steps than the record itself."""

from importlib import import_module

import numpy as np
import pytest

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, TIME, campaign_of, model_of
from wheelhop.effects import Effect
from wheelhop.simulate import RunSimulator
from wheelhop.simulate.abreast import integrate_jobs
from wheelhop.vehicle import axle_name

WASHBOARD = truth.Track("washboard", {"amplitude_mm": 25.0, "pitch_mm": 600.0})
RUNS = {"run": truth.Run(WASHBOARD, 4.0, 20.0, TIME)}
MOVED = ("unsprung_mass_kg", "tyre_stiffness_N_m", "tyre_damping_N_s_m")
SHORT_S = 0.00015625


def slipping(force_N, **before_slip):
    return {"front_N": force_N, "rear_N": force_N, **before_slip}


def columns(model):
    """Changes (k, n, channels) of the record when one number after the other grows by 1 %."""
    campaign = campaign_of(RUNS)
    simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
    names = [f"wheel.{axle_name(i)}.{key}" for i in (0, 2) for key in MOVED]
    others = [model.with_values({name: 1.01 * model.values[name]}) for name in names]
    base, *trials = [(m, m.system(CHANNELS, "road")) for m in (model, *others)]
    return np.array(simulator.changes(base, trials))


@pytest.mark.parametrize(
    ("effect", "form", "theta", "times", "wrong_by"),
    [
        ("tyre-lift-off", "", {"lifts": 1.0}, 2, 0.02),
        ("dry-friction", "elastic", slipping(60.0, presliding_N_m=3e5), 2, 0.08),
        ("dry-friction", "elastic", slipping(60.0, presliding_N_m=1.2e6), 2, 0.1),
        ("dry-friction", "elastic", slipping(60.0, presliding_N_m=5e6), 1, 0.1),
        ("dry-friction", "creeping", slipping(60.0, creep_m_s=0.012), 2, 0.08),
        ("dry-friction", "creeping", slipping(150.0, creep_m_s=0.004), 1, 0.2),
    ],
)
def test_a_change_is_as_good_in_twice_the_step_as_long_as_a_law_is_gentle(
    effect, form, theta, times, wrong_by, monkeypatch
):
    model = model_of(ATV, RUNS, effect, theta, choice=form)
    law = model.effects[0]
    assert law.change_step_s(model.theta(law), model.values) == times * law.longest_step_s
    found = columns(model)
    monkeypatch.setattr(type(law), "change_step_s", lambda *_: SHORT_S)
    exact = columns(model)
    assert np.linalg.norm(found - exact) < wrong_by * np.linalg.norm(exact)


def test_an_effect_that_says_nothing_has_one_step():
    law = Effect()
    assert law.change_step_s({}, {}) == law.longest_step_s


def test_light_wheels_on_strong_dampers_are_followed(monkeypatch):
    """A fit may come by wheels of 2 kg. In steps of 2.5 ms their motion would grow without end, and
    a fit that knows no derivative stays where it is."""
    light = {f"wheel.{end}.unsprung_mass_kg": 2.0 for end in ("front", "rear")}
    strong = {f"suspension.{end}.damping_N_s_m": 2500.0 for end in ("front", "rear")}
    model = model_of(ATV, RUNS).with_values({**light, **strong})
    found = columns(model)
    monkeypatch.setattr(import_module("wheelhop.simulate.run"), "STABLE", 0.1)
    exact = columns(model)
    assert np.linalg.norm(found - exact) < 0.02 * np.linalg.norm(exact)


@pytest.mark.parametrize("kept", [1, 4])
def test_what_is_kept_of_motions_changes_nothing(kept, monkeypatch):
    """What an engine's force changes is superposed on the record without, whatever was asked for in
    between: integrated by itself it would be another number, and take longer."""
    monkeypatch.setattr(import_module("wheelhop.simulate.run"), "KEPT_MOTIONS", kept)
    monkeypatch.setattr(
        import_module("wheelhop.simulate.run"), "integrate_jobs", counted := Counted()
    )
    model = model_of(ATV, RUNS, "engine-vibration", {"freq_hz": 11.0}, own={"cos_m_s2": 0.5})
    campaign = campaign_of(RUNS)
    simulator = RunSimulator(campaign, campaign.runs[0], 4.0)
    systems = model.system(CHANNELS, "road")
    own = model.runs["run"]
    further = [{**own, "start_m": own["start_m"] + 0.01 * i} for i in range(1, 6)]
    louder = {**own, "engine-vibration.cos_m_s2": 1.5}
    trials = [model.with_run("run", numbers) for numbers in (*further, louder)]
    simulator.changes((model, systems), [(trial, systems) for trial in trials])
    assert counted.jobs == 1 + len(further)


class Counted:
    """Integrates, and counts."""

    jobs = 0

    def __call__(self, asked):
        given = list(asked)
        self.jobs += len(given)
        integrate_jobs(given)
