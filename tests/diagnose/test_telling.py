"""Where only the best effects count: the runs that tell most are asked first, and what leaves far
more to first order is not simulated."""

from collections import defaultdict
from types import SimpleNamespace

import pytest

from tests import truth
from tests.diagnose.cases import CASES, LIBRARY, baseline_of
from wheelhop.diagnose.screen import first_order as screening
from wheelhop.diagnose.screen.first_order import screen, screen_best, taken_alone, telling
from wheelhop.diagnose.search import together
from wheelhop.diagnose.search.ladder import fit_with
from wheelhop.diagnose.search.scored import Search
from wheelhop.diagnose.search.together import exchange
from wheelhop.fit import fit


def runs_that_leave(*above):
    """Runs of ten data each, with so much left above their noise."""
    benches = [SimpleNamespace(size=10, cost=lambda residual, sigma: 10.0 + residual)] * len(above)
    runs = [SimpleNamespace(bench=b, residual=x) for b, x in zip(benches, above, strict=True)]
    return SimpleNamespace(runs=tuple(runs), sigma=1.0)


@pytest.mark.parametrize(
    ("above", "told"),
    [
        ((1.0, 5.0, 2.0, 1.0), (5.0,)),
        ((3.0, 1.0, 4.0, 2.0), (3.0, 4.0)),
        ((2.0, 2.0, 2.0, 2.0), (2.0, 2.0)),
        ((3.0, -9.0, 2.0), (3.0,)),  # what is below the noise is nothing
        ((-1.0, -2.0), (-1.0,)),
    ],
)
def test_the_fewest_runs_that_hold_half(above, told):
    assert tuple(run.residual for run in telling(runs_that_leave(*above))) == told


def quiet(text):
    pass


@pytest.fixture(scope="module")
def strong_friction(tmp_path_factory):
    hidden = CASES["dry-friction"].hidden
    folder = tmp_path_factory.mktemp("friction")
    return baseline_of(
        truth.make_campaign(folder, seed=104, effects=hidden, short=True, draft=True)
    )


def test_what_explains_far_less_there_is_not_simulated_in_the_others(strong_friction, monkeypatch):
    """To first order a digressive damper explains 51 % of what strong friction does, an engine and
    an asymmetric damper less than 5 %; of wheels in the air first order knows nothing."""
    base, workshop = strong_friction.rung.fit, strong_friction.workshop
    best = ("dry-friction", "digressive-damper", "tyre-lift-off")
    others = ("engine-vibration", "asymmetric-damper")
    effects = [LIBRARY[name] for name in (*others, *best)]
    everywhere = {s.variant.effect.id: s for s in screen(workshop, base, effects)}
    asked = defaultdict(set)
    plain = screening.signatures

    def counted(run, model, systems, prepared):
        for item in prepared:
            asked[item.variant.effect.id].add(run.bench.run.id)
        return plain(run, model, systems, prepared)

    monkeypatch.setattr(screening, "signatures", counted)
    found = {s.variant.effect.id: s for s in screen_best(workshop, base, effects)}
    assert set(found) == set(best)
    for name in best:
        assert found[name].gain == pytest.approx(everywhere[name].gain)
    few = {run.bench.run.id for run in telling(base)}
    assert all(asked[name] == few for name in others)
    assert len(few) < len(base.runs)


def test_what_the_vehicle_promises_by_itself_is_no_effect_s(strong_friction, monkeypatch):
    """A fit that ends where its derivatives mislead promises much more for a step of the vehicle
    alone, here of front tyres 5 % too stiff. No effect is likelier for that."""
    workshop, fitted = strong_friction.workshop, strong_friction.rung.fit
    tyre = "wheel.front.tyre_stiffness_N_m"
    astray = fitted.model.with_values({tyre: 1.05 * fitted.model.values[tyre]})
    monkeypatch.setitem(fit.__globals__, "ITERATIONS", 0)
    away = fit(workshop, astray, fitted.shared, workshop.of_role("fit"))
    alone = taken_alone(away).gain
    assert taken_alone(fitted).gain < 2e-3 * alone
    effects = [LIBRARY[n] for n in ("dry-friction", "engine-vibration", "tyre-lift-off")]
    there = {s.variant.effect.id: s for s in screen(workshop, fitted, effects)}
    for item in screen(workshop, away, effects):
        told = there[item.variant.effect.id]
        assert item.gain == pytest.approx(told.gain, rel=0.15)
        assert item.error / away.error == pytest.approx(told.error / fitted.error, rel=0.13)


def test_where_nothing_is_left_every_run_is_asked(strong_friction, monkeypatch):
    """What shows in few runs alone, or only in those held out, is not passed over."""
    base, workshop = strong_friction.rung.fit, strong_friction.workshop
    monkeypatch.setattr(screening, "all_noise", lambda fit, noise: True)
    found = screen_best(workshop, base, [LIBRARY["dry-friction"], LIBRARY["engine-vibration"]])
    assert {s.variant.effect.id for s in found} == {"dry-friction", "engine-vibration"}


def test_what_leaves_far_more_to_first_order_is_no_rival(strong_friction, monkeypatch):
    """Of strong friction first order explains a part, and of a digressive damper hardly less. An
    engine and an asymmetric damper explain next to nothing."""
    base = strong_friction
    friction = fit_with(base, [LIBRARY["dry-friction"]], quiet)[-1]
    names = ("dry-friction", "digressive-damper", "engine-vibration", "asymmetric-damper")
    library = {name: LIBRARY[name] for name in names}
    error = {
        s.variant.effect.id: s.error
        for s in screen(base.workshop, base.rung.fit, list(library.values()))
    }
    assert error["dry-friction"] > 2.0 * friction.error_fit
    assert error["digressive-damper"] < 2.0 * error["dry-friction"] < error["asymmetric-damper"]
    simulated = []

    def confirmed(incumbent, screened, beside):
        simulated.append(screened.variant.effect.id)
        return base.rung

    monkeypatch.setattr(together, "confirm", confirmed)
    exchange(Search(base.workshop, library, 4, quiet), friction)
    assert simulated == ["digressive-damper"]
