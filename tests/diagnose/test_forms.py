"""Which form of an effect a diagnosis comes to."""

from types import SimpleNamespace

import pytest

from tests import truth
from tests.diagnose.cases import LIBRARY, baseline_of
from wheelhop.diagnose import climb
from wheelhop.diagnose.confirm.starts import in_form, other_forms
from wheelhop.diagnose.search import together

STOPS = {"clearance_m": 0.02, "rebound_clearance_m": 0.032, "stiffness_N_m": 1.5e4}


def quiet(text):
    pass


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stops")
    return truth.make_campaign(
        folder, seed=31, effects={"bump-stop": STOPS}, short=True, draft=True
    )


def test_a_pair_of_stops_begins_where_one_of_them_has_ended(stopped):
    """The stop in rebound is farther away than that in compression. To first order, at any of the
    clearances that screening gives to both, they explain a fifth of what one does."""
    bump_stop = {"bump-stop": LIBRARY["bump-stop"]}
    diagnosis = climb(baseline_of(stopped), bump_stop, max_effects=1, progress=quiet)
    assert diagnosis.verdict == ("bump-stop",) and diagnosis.ladder[-1].over_floor < 1.05
    found = diagnosis.ranking[0].parameters
    assert found["form"] == "both"
    assert found["clearance_m"] == pytest.approx(0.02, rel=0.01)
    assert found["rebound_ratio"] == pytest.approx(1.6, rel=0.01)


@pytest.mark.parametrize(
    ("effect", "form", "expected"),
    [
        ("bump-stop", "compression", ["both"]),
        ("bump-stop", "rebound", ["both"]),
        ("bump-stop", "both", []),
        ("dry-friction", "elastic", ["creeping"]),
        ("dry-friction", "creeping", ["elastic"]),
        ("sensor-mount", "B1", []),
        ("mount-bushing", "", []),
    ],
)
def test_another_form_has_some_of_the_numbers_and_some_of_its_own(stopped, effect, form, expected):
    """These stay as they are, as do the vehicle and the other effects; what it has not is gone."""
    base = baseline_of(stopped)
    workshop, driver = base.workshop, LIBRARY["driver-seat"]
    chosen = LIBRARY[effect].with_choice(form)
    model = base.rung.model.with_effect(chosen, workshop.parameters_of(chosen))
    model = model.with_effect(driver, workshop.parameters_of(driver))
    found = SimpleNamespace(model=model, sigma=base.rung.fit.sigma)
    others = other_forms(workshop, chosen)
    assert list(others) == expected
    for other in others.values():
        after = in_form(workshop, found, other)
        assert after.effects == (other, model.effects[-1])
        numbers = {f"{other.id}.{p.name}" for p in workshop.parameters_of(other)}
        assert {name for name in after.values if name.startswith(f"{other.id}.")} == numbers
        same = after.values.keys() & model.values.keys()
        assert all(after.values[name] == model.values[name] for name in same)
        assert any(name.startswith(f"{other.id}.") for name in same)


@pytest.mark.parametrize(("left", "asked"), [(0.01, ["dry-friction"]), (0.0, [])])
def test_effects_are_asked_for_another_form_once_others_are_there(monkeypatch, left, asked):
    """All but the last one, which has just been, and where more is left than a right model may
    leave: of those that have another form."""
    effects = [LIBRARY[name] for name in ("dry-friction", "driver-seat", "bump-stop")]
    rung, better = (SimpleNamespace(model=SimpleNamespace(effects=effects)) for _ in range(2))
    tried = []

    def in_other_forms(workshop, rung, effect):
        tried.append(effect.id)
        return better

    forms = {"dry-friction": {"creeping": None}, "driver-seat": {}, "bump-stop": {"both": None}}
    step = SimpleNamespace(unexplained=left)
    monkeypatch.setattr(together, "step_of", lambda workshop, rung: step)
    monkeypatch.setattr(together, "other_forms", lambda workshop, effect: forms[effect.id])
    monkeypatch.setattr(together, "in_other_forms", in_other_forms)
    workshop = SimpleNamespace(noise=1.0)
    search = SimpleNamespace(workshop=workshop, progress=quiet, best=lambda rung: rung)
    assert together.in_best_forms(search, rung) is (better if asked else rung)
    assert tried == asked
