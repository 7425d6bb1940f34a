"""The library: what every effect says of itself, and effects from a user's file."""

import re
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from matplotlib.mathtext import MathTextParser

from tests import truth
from tests.simulate.setup import ATV, CHANNELS, EFFECTS, campaign_of, model_of, simulated
from wheelhop.campaign import CampaignError
from wheelhop.effects import (
    Amplitude,
    Effect,
    Place,
    RandomHeights,
    RunSetting,
    Shape,
    load_effects,
)
from wheelhop.simulate import Model, RunSimulator

TWELVE = {
    *("speed-fluctuation", "left-right-drift", "tyre-lift-off", "progressive-spring"),
    *("asymmetric-damper", "digressive-damper", "dry-friction", "driver-seat"),
    *("engine-vibration", "frame-twist", "sensor-gain", "sensor-polarity"),
}
ON_ROAD = RunSetting("run", 4.0, -4.0, 0.0, 5.0, True)
TRACK = truth.Track("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0})
RUN = {"run": truth.Run(TRACK, 5.0, 33.0, np.arange(200) / 100.0)}


def forms(effect):
    return [effect.with_choice(c) if c else effect for c in effect.choices(CHANNELS)]


FORMS = [
    pytest.param(effect.with_choice(c) if c else effect, id=f"{effect.id} {c}".strip())
    for effect in EFFECTS.values()
    for c in effect.choices(CHANNELS)[:10]
]


def test_the_twelve_are_there():
    assert set(EFFECTS) >= TWELVE
    assert all(effect.id == name for name, effect in EFFECTS.items())


@pytest.mark.parametrize("effect", EFFECTS.values(), ids=EFFECTS)
def test_every_effect_says_what_it_is(effect):
    assert effect.place in get_args(Place)
    assert len(effect.title) > 10 and effect.title == effect.title.strip()
    assert len(effect.source) > 10
    assert effect.choices(CHANNELS)
    MathTextParser("path").parse(f"${effect.equation}$")  # raises on what cannot be set
    if effect.place in ("track", "speed", "wheel", "tyre"):
        assert effect.needs_road  # with measured axles it cannot be seen
    assert 0 < effect.longest_step_s <= 0.0025


@pytest.mark.parametrize("effect", FORMS)
def test_every_parameter_has_unit_meaning_scale_and_consistent_bounds(effect):
    parameters = [*effect.parameters_for(ATV, CHANNELS), *effect.per_run(ON_ROAD)]
    assert parameters
    assert len({p.name for p in parameters}) == len(parameters)
    for p in parameters:
        assert p.unit and len(p.meaning) > 8
        assert p.scale > 0
        assert p.lower < p.upper
        if isinstance(p, Shape):
            assert all(p.lower <= start <= p.upper for start in p.starts)
        else:
            # Less than a lower bound above what is absent has another effect's name.
            assert p.absent <= p.upper
            assert p.lower <= p.absent + p.scale <= p.upper
        if p.unit != "1" and "_" in p.name:
            # The name ends in its unit, written without signs: N·s/m is N_s_m.
            plain = p.unit.replace("·", "_").replace("/", "_").replace("³", "3").replace("²", "2")
            assert p.name.lower().endswith(plain.lower())


def test_scales_grow_with_the_vehicle():
    car = dict(truth.PRESETS["passenger-car"].vehicle)
    for name in ("dry-friction", "asymmetric-damper", "progressive-spring"):
        small, large = (
            EFFECTS[name].parameters_for(vehicle, CHANNELS)[0].scale for vehicle in (ATV, car)
        )
        assert small != large


@pytest.mark.parametrize("effect", FORMS)
def test_an_absent_effect_changes_nothing(effect):
    campaign, base = campaign_of(RUN), model_of(ATV, RUN)
    own = {f"{effect.id}.{p.name}": p.start for p in effect.per_run(ON_ROAD)}
    absent = base.with_effect(effect, effect.parameters_for(ATV, CHANNELS)).with_run("run", own)
    expected = simulated(campaign, base)["run"]
    # A finer step, where an effect asks for one, is all that may differ.
    atol = 1e-9 if effect.longest_step_s >= 0.0025 else 1e-4 * np.abs(expected).max()
    np.testing.assert_allclose(simulated(campaign, absent)["run"], expected, atol=atol)


WITH_STRENGTH = [effect for effect in FORMS if effect.values[0].id != "tyre-lift-off"]
"""A wheel leaves the ground or does not, and that is the road's doing."""


@pytest.mark.parametrize("effect", WITH_STRENGTH)
def test_a_visible_strength_is_visible(effect):
    """At its `scale` an effect changes this record by more than half a per cent of its size."""
    campaign, base = campaign_of(RUN), model_of(ATV, RUN)
    parameters = effect.parameters_for(ATV, CHANNELS)
    present = base.with_effect(effect, parameters).with_values(
        {f"{effect.id}.{p.name}": p.typical for p in parameters if isinstance(p, Amplitude)}
    )
    # A history swings: an acceleration that stays would be no vibration.
    own = {
        f"{effect.id}.{p.name}": p.start + p.scale * (-1) ** (i // 2)
        for i, p in enumerate(effect.per_run(ON_ROAD))
    }
    present = present.with_run("run", own)
    if isinstance(effect, RandomHeights):
        series = RunSimulator(campaign, campaign.runs[0], 4.0).series
        theta = present.theta(effect)
        density = effect.height_density(theta, series.wave_number_rad_m)
        present = present.with_heights({"run": series.drawn(density, np.random.default_rng(0))})
    one, other = simulated(campaign, base)["run"], simulated(campaign, present)["run"]
    assert np.linalg.norm(one - other) > 0.005 * np.linalg.norm(one)


INVERTIBLE = [effect for effect in FORMS if effect.values[0].id != "sensor-clipping"]
"""What a sensor has cut off is lost."""


@pytest.mark.parametrize("effect", INVERTIBLE)
def test_restore_undoes_sense(effect):
    time = np.arange(400) / 100.0
    swell = np.hanning(len(time))[:, None]
    acceleration = swell**2 * np.cos(2 * np.pi * np.outer(time, np.linspace(3.0, 24.0, 8)))
    theta = {
        p.name: 0.3 * p.scale if type(p) is Amplitude else p.typical
        for p in effect.parameters_for(ATV, CHANNELS)
    }
    sensed = effect.sense(theta, acceleration, CHANNELS, 100.0)
    restored = effect.restore(theta, sensed, CHANNELS, 100.0)
    np.testing.assert_allclose(restored, acceleration, atol=1e-3)
    assert (effect.place == "sensor") == bool(np.any(sensed != acceleration))


def test_effects_take_part_in_any_combination():
    """All laws and modes at once: the integrator takes them, the response stays finite."""
    model = model_of(ATV, RUN)
    for effect in EFFECTS.values():
        form = forms(effect)[0]
        parameters = form.parameters_for(ATV, CHANNELS)
        model = model.with_effect(form, parameters).with_values(
            {f"{form.id}.{p.name}": 0.2 * p.scale for p in parameters if isinstance(p, Amplitude)}
        )
    response = simulated(campaign_of(RUN), model)["run"]
    assert np.isfinite(response).all()
    # The order in which they were added is of no consequence (sensors' faults aside).
    sensors = [effect for effect in model.effects if effect.place == "sensor"]
    physics = [effect for effect in model.effects if effect.place != "sensor"]
    turned = Model(model.values, (*physics[::-1], *sensors), model.runs)
    again = simulated(campaign_of(RUN), turned)["run"]
    np.testing.assert_allclose(again, response, atol=1e-6 * np.abs(response).max())


USERS = """
from wheelhop.effects import Amplitude, Effect, law
from wheelhop.vehicle import CORNERS, suspension

@law
def quintic(x, v, dx, dt, z, p):
    return p[0] * x**5, z

class QuinticSpring(Effect):
    id = "quintic-spring"
    place = "suspension"
    title = "a spring of the fifth order"
    equation = "f = k_5 x^5"
    source = "the user"

    def parameters_for(self, vehicle, channels):
        return (Amplitude("rate_N_m5", "N/m5", "rate", 1e9),)

    def modify(self, theta, vehicle, parts):
        for i in CORNERS:
            parts.add_law(suspension(vehicle, i), quintic, (theta["rate_N_m5"],))
"""


def test_an_effect_from_a_users_file_joins_the_library(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(USERS)
    library = load_effects(file)
    assert set(library) == set(EFFECTS) | {"quintic-spring"}
    effect = library["quintic-spring"]
    base = model_of(ATV, RUN)
    present = base.with_effect(effect, effect.parameters_for(ATV, CHANNELS)).with_values(
        {"quintic-spring.rate_N_m5": 1e10}
    )
    one, other = (simulated(campaign_of(RUN), model)["run"] for model in (base, present))
    assert np.linalg.norm(one - other) > 1e-3 * np.linalg.norm(one)


def test_a_users_effect_replaces_a_built_in_one_of_its_id(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(USERS.replace('"quintic-spring"', '"progressive-spring"'))
    library = load_effects(file)
    assert set(library) == set(EFFECTS)
    assert library["progressive-spring"].title == "a spring of the fifth order"


MISTAKES = {
    "not there": (None, "mine.py", ["no such file", "Python file"]),
    "not Python": ("hello", "mine.txt", ["must end in .py"]),
    "syntax": ("class X(:\n", "mine.py", ["does not run", "SyntaxError"]),
    "import": ("import no_such_module\n", "mine.py", ["does not run", "no_such_module"]),
    "leaves": ("raise SystemExit(3)\n", "mine.py", ["does not run"]),
    "law": (
        USERS.replace("return p[0]", "return 'a' + p[0]"),
        "mine.py",
        ["a law in line 7 does not compile", "add(Literal[str](a), float64); it"],
    ),
    "empty": ("x = 1\n", "mine.py", ["holds no effect", "wheelhop.effects.Effect"]),
    "only imports one": (
        "from wheelhop.effects import Effect\n",
        "mine.py",
        ["holds no effect"],
    ),
    "without id": (USERS.replace('id = "quintic-spring"', ""), "mine.py", ["QuinticSpring", "id"]),
    "without place": (
        USERS.replace('place = "suspension"', ""),
        "mine.py",
        ["QuinticSpring", "place"],
    ),
    "wrong place": (
        USERS.replace('place = "suspension"', 'place = "gearbox"'),
        "mine.py",
        ["QuinticSpring", "gearbox", "suspension"],
    ),
    "constructor wants something": (
        USERS + "    def __init__(self, n):\n        self.n = n\n",
        "mine.py",
        ["QuinticSpring"],
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_mistakes_in_a_users_file_get_one_line(mistake, tmp_path):
    text, name, words = MISTAKES[mistake]
    file = tmp_path / name
    if text is not None:
        file.write_text(text)
    with pytest.raises(CampaignError) as caught:
        load_effects(file)
    line = str(caught.value)
    assert line.startswith(str(file)) and line.isprintable()
    assert all(word in line for word in words), line


def test_the_base_class_does_nothing():
    class Idle(Effect):
        id, place, title, equation, source = "idle", "body", "idle", "0", "none"

        def parameters_for(self, vehicle, channels):
            return ()

    base = model_of(ATV, RUN)
    idle = Model(base.values, (Idle(),), base.runs)
    one, other = (simulated(campaign_of(RUN), model)["run"] for model in (base, idle))
    np.testing.assert_array_equal(one, other)


def strong(form):
    """Every number of a form well away from where it is absent: shared, and a run's own."""
    shared = {p.name: p.typical for p in form.parameters_for(ATV, CHANNELS)}
    setting = RunSimulator(campaign_of(RUN), campaign_of(RUN).runs[0], 4.0).setting
    return shared, {p.name: p.start + 0.5 * p.scale for p in form.per_run(setting)}


def heavier(values, units):
    """Twice the mass, and whatever holds it twice as strong."""
    found = dict(values)
    for name, unit in units.items():
        above, _, below = unit.partition("/")
        for part, factor in ((above, 2.0), (below, 0.5)):
            found[name] *= factor if {"N", "kg"} & set(re.split("[·²³]", part)) else 1.0
    return found


VEHICLE_UNITS = {key: "kg" for key in ATV if re.search("mass|inertia|stiffness|damping", key)}


MOVING = [f for f in FORMS if f.values[0].on_vehicle and f.values[0].place != "sensor"]


@pytest.mark.parametrize("form", MOVING)
def test_records_do_not_show_how_heavy_the_vehicle_is(form):
    """Twice as heavy on springs and dampers twice as strong, with an effect whose forces are twice
    as large, it moves as it did. What is free in a run is the same for both: a belief in it must
    not say how heavy the vehicle is."""
    shared, own = strong(form)
    units = {p.name: p.unit for p in form.parameters_for(ATV, CHANNELS)}
    records = []
    for values, theta in ((ATV, shared), (heavier(ATV, VEHICLE_UNITS), heavier(shared, units))):
        model = replace(model_of(values, RUN, form.id, theta, own=own), effects=(form,))
        records.append(simulated(campaign_of(RUN), model)["run"])
    np.testing.assert_allclose(records[1], records[0], atol=1e-6 * np.abs(records[0]).max())
