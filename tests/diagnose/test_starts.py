"""Where a fit begins, and when it begins somewhere else, too."""

from types import SimpleNamespace

import pytest

from wheelhop.diagnose.confirm import starts as starting
from wheelhop.diagnose.confirm.starts import Start, plainer, starts
from wheelhop.effects import Shape, load_effects
from wheelhop.simulate import Model

NOISE = 1.0
SHAPE = Shape("clearance", "m", "clearance", 1.0, starts=(0.5,))


def ended(error, evidence, away=0.0, vehicle=0.0):
    """A fit with one number of its last effect and one of the vehicle, so many deviations from what
    is believed."""
    values = {"stop.clearance": away, "wheel.radius": vehicle}
    free = [SimpleNamespace(name=name, away=lambda value: value) for name in values]
    model = SimpleNamespace(values=values, effects=[SimpleNamespace(id="stop")])
    return SimpleNamespace(error=error, evidence=evidence, shared=free, model=model)


def begun(monkeypatch, forms, results, *, believed=True, plain=()):
    """Why each fit of a stop began that screening expects to leave an error of 1, in these forms,
    if they end like this; `believed`: whether the vehicle is believable; `plain`: forms with fewer
    numbers than any of these."""
    item = SimpleNamespace(id="stop", error=1.0, variant=SimpleNamespace(parameters=[SHAPE]))
    known = SimpleNamespace(workshop=SimpleNamespace(noise=NOISE), rung="fitted")
    known.as_believed = None if believed else "believed"

    def screened(workshop, base, item):
        return [(form, Start(None, form, base)) for form in forms]

    def saturated(workshop, base, item):
        yield Start(None, "saturated", base)

    monkeypatch.setattr(starting, "_screened", screened)
    monkeypatch.setattr(starting, "saturated", saturated)
    monkeypatch.setattr(starting, "plainer", lambda workshop, fit: [(p, None) for p in plain])
    monkeypatch.setattr(starting, "all_noise", lambda fit, noise: fit.error < NOISE)
    fits, why = [], []
    for start, result in zip(starts(known, item, fits), results, strict=False):
        why.append(start.why)
        fits.append(result)
    return why


NEAR, ASTRAY, IN_NOISE = ended(1.1, 1.0), ended(1.3, 1.0), ended(0.9, 2.0)
WRONG, BETTER = ended(1.1, 1.0, away=5.0), ended(1.1, 3.0)
SMALL_WHEELS, IN_NOISE_SO = ended(1.1, 1.0, vehicle=5.0), ended(0.9, 2.0, vehicle=5.0)


@pytest.mark.parametrize(
    ("forms", "results", "expected"),
    [
        (["one"] * 3, [NEAR, NEAR], ["one"]),  # as near as screening expects
        (["one"] * 3, [ASTRAY] * 4, ["one"] * 3),  # never: every share is tried
        (["one", "other", "one"], [NEAR] * 3, ["one", "other"]),  # another form may be nearer
        (["one", "other", "one"], [IN_NOISE] * 3, ["one"]),  # none can be
        (["one"] * 3, [WRONG] * 5, ["one"] * 3 + ["saturated"]),  # hard to believe
        (["one"] * 3, [WRONG, BETTER, NEAR], ["one"] * 2),  # the likeliest one counts
    ],
)
def test_a_fit_begins_anew_until_one_has_come_far_enough(forms, results, expected, monkeypatch):
    assert begun(monkeypatch, forms, results) == expected


@pytest.mark.parametrize(("result", "more"), [(SMALL_WHEELS, 1), (IN_NOISE_SO, 0), (NEAR, 0)])
def test_where_something_is_left_it_begins_in_the_vehicle_as_believed(result, more, monkeypatch):
    """As long as no fit has led back to a vehicle that is believable."""
    found = begun(monkeypatch, ["one"], [result] * 3, believed=False)
    assert found == ["one"] + more * ["in the vehicle as believed"]


@pytest.mark.parametrize(
    ("form", "result", "more"), [("other", NEAR, 1), ("other", IN_NOISE, 0), ("one", NEAR, 0)]
)
def test_where_something_is_left_it_begins_in_plainer_forms_once(form, result, more, monkeypatch):
    found = begun(monkeypatch, ["one"], [result] * 5, plain=[form])
    assert found == ["one"] + more * ["in a plainer form"]


def test_plainer_forms_have_some_of_the_numbers_and_no_others():
    """Friction that sticks, without what makes it stick: it begins where that has ended."""
    library, vehicle = load_effects(), {"component.mass_kg": 0.0, "rig.force_N": 600.0}
    vehicle |= {"component.stiffness_N_m": 2e4, "component.damping_N_s_m": 1500.0}
    vehicle |= {"rig.travel_m": 0.02, "rig.speed_m_s": 0.2}
    workshop = SimpleNamespace(
        nominal=vehicle,
        campaign=SimpleNamespace(channels=()),
        parameters_of=lambda effect: effect.parameters_for(vehicle, ()),
    )
    form = library["dry-friction"].with_choice("sticking")
    numbers = {"strut_N": 60.0, "presliding_N_m": 2e5, "sticking": 1.6, "stribeck_m_s": 0.02}
    values = vehicle | {f"dry-friction.{k}": v for k, v in numbers.items()}
    fit = SimpleNamespace(model=Model(values, (form,)))
    ((choice, model),) = plainer(workshop, fit)
    assert choice == "elastic" and model.effects[0].form == "elastic"
    own = {"dry-friction.strut_N": 60.0, "dry-friction.presliding_N_m": 2e5}
    assert model.values == vehicle | own
