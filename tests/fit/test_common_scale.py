"""Records do not show the common scale of all masses and forces: nothing but beliefs may."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests import truth
from tests.simulate.setup import ATV, EFFECTS, campaign_of, model_of, simulated
from wheelhop.fit import Free, Workshop, effect_parameters, fit, of_forces, vehicle_parameters
from wheelhop.fit.belief import Belief
from wheelhop.vehicle import Vehicle

TIME = np.arange(300) / 100.0
RUNS = {
    kind: truth.Run(truth.Track(kind, keys), speed, start, TIME)
    for kind, keys, speed, start in (
        ("herringbone", {"amplitude_mm": 20.0, "pitch_mm": 800.0}, 5.1, 33.7),
        ("chassis-twist", {"amplitude_mm": 150.0, "pitch_mm": 2000.0}, 4.2, 40.3),
    )
}
FRICTION = {"front_N": 60.0, "rear_N": 45.0}
TAPED = ("geometry.", "wheel.front.radius", "wheel.rear.radius")
STATED = Vehicle(
    "stated", ATV, {k: (0.01 if k.startswith(TAPED) else 0.1) * v for k, v in ATV.items()}
)
NOISE = 0.05


def heavier(values, factor):
    """The same with all masses and forces so many times as large."""
    return {k: v * factor if of_forces(k) else v for k, v in values.items()}


def friction_of(workshop, model, form):
    effect = EFFECTS["dry-friction"].with_choice(form)
    parameters = workshop.parameters_of(effect)
    model = model.with_effect(effect, parameters)
    return model, effect_parameters(parameters, model, effect)


@pytest.fixture(scope="module")
def numbers():
    """Those of the vehicle and of friction that is stiff before it slips."""
    campaign, model = campaign_of(RUNS), model_of(ATV, RUNS)
    model, own = friction_of(Workshop(campaign, model, jobs=1), model, "elastic")
    tyre = "wheel.front.tyre_damping_N_s_m"
    stated = replace(STATED, uncertainty={**STATED.uncertainty, tyre: 2.0 * ATV[tyre]})
    return [*vehicle_parameters(campaign, stated), *own]


@given(factor=st.floats(0.2, 5.0), seed=st.integers(0, 99))
def test_what_is_believed_in_proportion_alone_tells_the_scale(numbers, factor, seed):
    """Bounds move along with it, and so does what is believed of a joint's stiffness, or of
    damping that may be nothing."""
    rng = np.random.default_rng(seed)
    values = {f.name: f.mean * np.exp(0.2 * rng.normal()) for f in numbers}
    other, belief = heavier(values, factor), Belief.of(numbers)
    assert belief.scale(other) == pytest.approx(factor * belief.scale(values))
    others = [f for f in numbers if f.follows_scale]
    following = [i for i, f in enumerate(numbers) if f.follows_scale]
    own_names = [f.name.rpartition(".")[2] for f in others]
    assert own_names == ["tyre_damping_N_s_m", "presliding_N_m"]
    room, moved = belief.room(values)[:, following], belief.room(other)[:, following]
    assert moved == pytest.approx(room)
    alone = [f for f in numbers if not f.follows_scale]
    told = [Belief.of(alone).distance(v) for v in (values, other)]
    whole = [belief.distance(v) for v in (values, other)]
    assert whole[1] - told[1] == pytest.approx(whole[0] - told[0])


@given(seed=st.integers(0, 99))
def test_pull_precision_and_coordinates_are_slopes(numbers, seed):
    rng = np.random.default_rng(seed)
    values = {f.name: (f.mean or f.scale) * np.exp(0.1 * rng.normal()) for f in numbers}
    belief, scale = Belief.of(numbers), np.array([f.scale for f in numbers])
    step = 1e-4 * rng.normal(size=len(numbers))
    there = {f.name: values[f.name] + f.scale * d for f, d in zip(numbers, step, strict=True)}
    back = {f.name: values[f.name] - f.scale * d for f, d in zip(numbers, step, strict=True)}
    slope = (belief.distance(there) - belief.distance(back)) / 2.0
    assert -2.0 * belief.pull(values) @ step == pytest.approx(slope, rel=1e-3, abs=1e-9)
    ahead, behind = belief.moved(values, step), belief.moved(values, -step)
    went = np.array([ahead[f.name] - behind[f.name] for f in numbers]) / scale / 2.0
    assert belief.coordinates(values) @ step == pytest.approx(went, rel=1e-3, abs=1e-9)


@given(seed=st.integers(0, 99))
def test_a_fit_ends_on_the_scale_that_is_likeliest(numbers, seed):
    """Nothing else tells it. What divides by a mass becomes smaller as masses become larger."""
    rng = np.random.default_rng(seed)
    numbers = [*numbers, Free("frame-twist.participation_1_kg", 0.0, np.inf, 0.01, lower=0.0)]
    values = {f.name: (f.mean or f.scale) * np.exp(0.1 * rng.normal()) for f in numbers}
    belief = Belief.of(numbers)
    moved = belief.on_scale(values)
    assert belief.scale(moved) == pytest.approx(1.0)
    factor = moved["body.mass_kg"] / values["body.mass_kg"]
    for f in numbers:
        assert moved[f.name] == pytest.approx(values[f.name] * factor ** of_forces(f.name))
    certain = values | {"mount.stiffness_N_m": 1e5}
    assert belief.on_scale(certain) == {}


def test_a_heavier_car_leaves_the_same_records_and_is_fitted_as_stated():
    """Friction that creeps, fitted by a joint that gives way elastically: it would be stiffer than
    its bound. All else would be softer and lighter, were that bound in N/m."""
    campaign, creep = campaign_of(RUNS), {"creep_m_s": 0.002}
    records = []
    for factor in (1.0, 1.3):
        theta = {k: factor * v for k, v in FRICTION.items()} | creep
        vehicle = heavier(ATV, factor)
        true = model_of(vehicle, RUNS, "dry-friction", theta, choice="creeping")
        records.append(simulated(campaign, true))
    for name in RUNS:
        assert records[1][name] == pytest.approx(records[0][name], abs=1e-6)
    rng = np.random.default_rng(0)
    noisy = {k: v + NOISE * rng.normal(size=v.shape) for k, v in records[1].items()}
    campaign, start = campaign_of(RUNS, noisy, noise_rms=0.1 * NOISE), model_of(ATV, RUNS)
    workshop = Workshop(campaign, start, jobs=1)
    start, own = friction_of(workshop, start, "elastic")
    spring = next(f for f in own if f.name.endswith("presliding_N_m"))
    start = start.with_values(
        {f"dry-friction.{k}": v for k, v in FRICTION.items()} | {spring.name: spring.upper}
    )
    shared = [*vehicle_parameters(campaign, STATED), *own]
    fitted = fit(workshop, start, shared, workshop.of_role("fit"))
    scale = fitted.belief.scale(fitted.model.values)
    print(scale, fitted.model.values, fitted.error, fitted.cost / fitted.size)
    assert scale == pytest.approx(1.0, abs=1e-6)
    assert fitted.model.values[spring.name] == pytest.approx(scale * spring.upper)
