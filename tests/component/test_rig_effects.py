"""Effects that only a rig tells from their likes: closed forms, and the rig's own formulations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.component import rig
from tests.component.cases import DAMPER, LIBRARY, RIG_ONLY, diagnosed
from wheelhop.effects.compliant_damper import valves_in_series
from wheelhop.effects.hysteresis import bouc_wen, bristles, slip_behind_play, yielding
from wheelhop.effects.payne_effect import WAYS, stiffnesses
from wheelhop.law import Moved, Where
from wheelhop.law.along import follow_all, force_along
from wheelhop.simulate import Model

TURNS = np.sin(np.linspace(0.0, 6 * np.pi, 24001))
VALUES = {
    "component.mass_kg": 0.0,
    "component.stiffness_N_m": DAMPER.stiffness_N_m,
    "component.damping_N_s_m": DAMPER.damping_N_s_m,
    "rig.force_N": 600.0,
    "rig.travel_m": 0.02,
    "rig.speed_m_s": 0.2,
}


def follow(law, x, v, dt, numbers):
    """Force of one law along a motion."""
    return follow_all([(0, law, tuple(numbers))], x[:, None], v[:, None], dt)[:, 0]


def loop(law, amplitude, period_s, *numbers):
    """Extension, rate and force of the last of three cycles."""
    dt = 3 * period_s / (len(TURNS) - 1)
    x = amplitude * TURNS
    v = np.gradient(x, dt)
    force = follow(law, x, v, dt, numbers)
    last = slice(16000, None)
    return x[last], v[last], force[last]


def area(x, force):
    return float(np.trapezoid(force, x))


@pytest.mark.parametrize("name", RIG_ONLY)
def test_the_law_is_the_one_the_rig_has(name):
    """Along a random motion, in two formulations."""
    case = RIG_ONLY[name]
    time_s = rig.fine_time(3.0)
    x = rig.multisine(time_s, 6e-3, (0.5, 8.0), 4)
    v = np.gradient(x, rig.STEP_S)
    law = case.component("displacement").law()
    theirs = np.array([law(*pair) for pair in zip(x.tolist(), v.tolist(), strict=True)])
    effect = LIBRARY[case.effect]
    effect = effect.with_choice(case.form) if case.form else effect
    numbers = {f"{effect.id}.{k}": n for k, n in case.parameters["displacement"].items()}
    where, moved = Where("component", "strut", (0,)), Moved(x, v, (len(x),))
    ours = force_along(Model(VALUES | numbers, (effect,)), where, moved, rig.STEP_S)
    linear = DAMPER.stiffness_N_m * x + DAMPER.damping_N_s_m * v
    assert np.std(theirs - linear) > 10.0
    assert np.std(ours - theirs) < 0.02 * np.std(theirs - linear)


@pytest.mark.parametrize("name", RIG_ONLY)
def test_it_is_named_and_measured(name, tmp_path):
    case = RIG_ONLY[name]
    component = case.component("displacement")
    folder = rig.make_campaign(tmp_path / "c", "displacement", component, seed=1, noise=0.01)
    found = diagnosed(folder)
    assert found.verdict == (case.effect,)
    last = found.ladder[-1]
    assert last.over_floor < 1.1
    (effect,) = last.rung.model.effects
    form = getattr(effect, "form", "")
    assert form == case.form or "loss" not in case.parameters["displacement"]
    if form != case.form:  # valves that lose nothing once blown off never do
        assert last.parameters[f"{case.effect}.loss"][0] < 0.05
    for key, value in case.parameters["displacement"].items():
        reached, _ = last.parameters[f"{case.effect}.{key}"]
        assert reached == pytest.approx(value, rel=0.15), key


@given(st.floats(10.0, 500.0), st.floats(1e4, 1e6), st.floats(0.0, 0.02), st.floats(0.001, 0.02))
def test_play_loses_nothing_in_the_gap(slip, joint, gap, beyond):
    """4 F (X − g/2 − F/k) a cycle once it slips: the gap is crossed without force."""
    give = slip / joint
    amplitude = 0.5 * gap + give + beyond
    x, _, force = loop(slip_behind_play, amplitude, 1.0, slip, joint, gap)
    loss = 4 * slip * max(amplitude - 0.5 * gap - give, 0.0)
    assert area(x, force) == pytest.approx(loss, rel=5e-3, abs=1e-3 * slip * amplitude)


def test_bristles_hold_more_slowly_than_fast():
    """Sliding steadily they carry Stribeck's curve, whatever their stiffness."""
    for speed in (1e-3, 0.02, 0.5):
        x = speed * np.linspace(0.0, 0.05 / speed, 2001)
        dt = 0.05 / speed / 2000
        numbers = np.array([60.0, 2e5, 1.6, 0.02])
        force = follow(bristles, x, np.full(2001, speed), dt, numbers)
        expected = 60.0 * (1.0 + 0.6 * np.exp(-((speed / 0.02) ** 2)))
        assert force[-1] == pytest.approx(expected, rel=1e-6)


@given(st.floats(0.5, 1.0), st.floats(1e-4, 1e-2))
def test_bouc_wen_loads_exponentially_and_unloads_by_its_roundness(roundness, way):
    x = np.concatenate([np.linspace(0.0, 8 * way, 4001), np.linspace(8 * way, 7.99 * way, 11)[1:]])
    numbers = np.array([80.0, way, 1.0, 2.0 * roundness - 1.0])
    force = follow(bouc_wen, x, np.zeros(len(x)), 1e-3, numbers)
    np.testing.assert_allclose(force[:4001], 80.0 * (1 - np.exp(-x[:4001] / way)), rtol=1e-9)
    back = (force[-1] - force[4000]) / (x[-1] - x[4000])
    assert back == pytest.approx(80.0 / way * 2 * roundness, rel=0.03)


@given(st.floats(-0.9, 0.45), st.floats(1e-3, 1e-2), st.floats(0.1, 2.0))
def test_hysteresis_without_a_limit_loads_and_unloads_in_closed_form(softening, way, far):
    """F (1 − exp(−s x/d)) / s on first loading, hardening where s < 0; back to no force by
    d ln(1 + (1 − s) f / F) / (1 − s): less far than it came, so that every cycle loses energy."""
    x = np.linspace(0.0, far * way, 2001)
    numbers = np.array([80.0, way, softening, 1.0 - softening])
    up = follow(bouc_wen, x, np.zeros(2001), 1e-3, numbers)
    s = softening if abs(softening) > 1e-12 else 1e-12
    np.testing.assert_allclose(up, -80.0 * np.expm1(-s * x / way) / s, rtol=1e-6)
    back = way * np.log1p((1.0 - s) * up[-1] / 80.0) / (1.0 - s)
    there = np.concatenate([x, [x[-1] - back]])
    down = follow(bouc_wen, there, np.zeros(2002), 1e-3, numbers)
    assert down[-1] == pytest.approx(0.0, abs=1e-6 * up[-1])
    assert back < x[-1]


@given(st.floats(-0.9, 0.5), st.floats(1e-3, 1e-2), st.floats(2e-3, 1e-2))
def test_hysteresis_never_gives_energy(softening, way, amplitude):
    numbers = (80.0, way, softening, 1.0 - softening)
    x, _, force = loop(bouc_wen, amplitude, 1.0, *numbers)
    assert area(x, force) > 0.0


VALVES = st.tuples(
    st.floats(1e-3, 0.05),
    st.floats(500.0, 5000.0),
    st.floats(-0.6, 0.6),
    st.floats(0.0, 200.0),
    st.floats(0.05, 1.0),
    st.floats(0.0, 0.9),
    st.floats(50.0, 500.0),
)
"""Lag, damping, asymmetry, opening force, bleed, loss and blow-off force."""


@given(VALVES, st.floats(-1.0, 1.0))
def test_steadily_dragged_valves_resist_by_their_curve(valves, speed):
    """The spring is still: bleed, open and blown-off slopes in turn, none of the lag."""
    lag, damping, asymmetry, opening, bleed, loss, blow_off = valves
    dt = lag / 50
    x = speed * dt * np.arange(3001)
    force = follow(valves_in_series, x, np.full(3001, speed), dt, valves) + damping * speed
    f = abs(force[-1])
    side = damping * (1.0 + asymmetry if speed > 0.0 else 1.0 - asymmetry)
    flow = (
        bleed * f
        + (1.0 - bleed) * max(f - opening, 0.0)
        + loss / (1.0 - loss) * max(f - opening - blow_off, 0.0)
    )
    assert flow / side == pytest.approx(abs(speed), rel=1e-6, abs=1e-12)
    assert force[-1] * speed >= 0.0


@given(st.floats(1e-3, 0.05), st.floats(500.0, 5000.0), st.floats(0.5, 10.0))
def test_valves_that_never_shut_are_maxwells_element(lag, damping, frequency):
    """Damping c / (1 + iωτ) of a linear dashpot behind a spring."""
    period = 1.0 / frequency
    numbers = (lag, damping, 0.0, 0.0, 1.0, 0.0, np.inf)
    cycles = 3 + int(np.ceil(8 * lag / period))
    time = np.arange(4000 * cycles + 1) * period / 4000
    turn = 2 * np.pi * frequency
    x, v = 0.01 * np.sin(turn * time), 0.01 * turn * np.cos(turn * time)
    force = (follow(valves_in_series, x, v, period / 4000, numbers) + damping * v)[-4000:]
    moved = np.exp(-1j * turn * time[-4000:])
    exact = damping / (1.0 + 1j * turn * lag)
    assert (force @ moved) / (v[-4000:] @ moved) == pytest.approx(exact, rel=1e-3)


@given(VALVES, st.floats(1.0, 10.0), st.floats(0.001, 0.02))
def test_valves_behind_a_spring_never_give_energy(valves, frequency, amplitude):
    x, v, force = loop(valves_in_series, amplitude, 1.0 / frequency, *valves)
    taken = area(x, force + valves[1] * v)
    assert taken > 0.0


@pytest.mark.parametrize(
    ("name", "law", "numbers", "damping"),
    [
        (
            "compliant-damper",
            valves_in_series,
            (0.005, 1500.0, 0.2, 60.0, 0.15, 0.6, 250.0),
            1500.0,
        ),
        ("mr-damper", yielding, (100.0, 0.001, 0.03), 0.0),
    ],
)
def test_its_error_falls_with_the_square_of_the_step(name, law, numbers, damping):
    """At the step that the library asks for it is below a thousandth of the force."""

    def at(step, every):
        time = np.arange(0.0, 1.0, step)
        x = 0.02 * np.sin(2 * np.pi * 2.0 * time)
        v = 0.02 * 4 * np.pi * np.cos(2 * np.pi * 2.0 * time)
        return (follow(law, x, v, step, numbers) + damping * v)[::every]

    step = LIBRARY[name].longest_step_s
    exact = at(step / 32, 32)
    errors = [np.std(at(step / n, n) - exact) / np.std(exact) for n in (1, 2, 4)]
    assert errors[0] < 1e-3
    assert errors[2] < errors[0] / 8


@given(st.floats(0.02, 1.0), st.floats(0.01, 0.3), st.floats(1e-4, 5e-3))
def test_a_fluid_that_yields_flows_at_its_steady_force(speed, creep, way):
    """Dragged along steadily it carries F tanh(v/w); the first slope is F/d."""
    dt = 1e-3 * way / speed
    x = speed * dt * np.arange(20001)
    force = follow(yielding, x, np.full(20001, speed), dt, np.array([100.0, way, creep]))
    assert force[-1] == pytest.approx(100.0 * np.tanh(speed / creep), rel=1e-3)
    assert force[1] / x[1] == pytest.approx(100.0 / way, rel=0.05)


def test_rubber_softens_with_amplitude_as_kraus_says():
    """Storage stiffness over the loop's ends: F/(half way + X), by the curve of first loading."""
    half_way, total = 0.002, 100.0
    for amplitude in (2e-4, 1e-3, 5e-3, 2e-2):
        ends = sum(
            total * k * min(amplitude, way * half_way) / half_way
            for k, way in zip(stiffnesses(), WAYS, strict=True)
        )
        exact = total * amplitude / (half_way + amplitude)
        assert ends == pytest.approx(exact, rel=0.05)


def parameter(effect, name):
    return next(p for p in effect.parameters_for(VALUES, ()) if p.name == name)


def test_a_damper_gives_way_visibly_or_not_at_all():
    """At its least lag the force is 0.7° late in a sine of the record's own travel and speed, and
    its bleed is at most twenty times as steep as its open valves."""
    damper = LIBRARY["compliant-damper"]
    turn = 3.0 * VALUES["rig.speed_m_s"] / VALUES["rig.travel_m"]
    late = np.degrees(np.arctan(turn * parameter(damper, "strut_s").lower))
    assert late == pytest.approx(0.7, abs=0.1)
    assert 1.0 / parameter(damper, "bleed").lower == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("form", "name"),
    [("creeping", "creep_m_s"), ("sticking", "stribeck_m_s"), ("smooth", "yield_m")],
)
def test_bounds_of_friction_follow_the_record(form, name):
    """A record a hundredth as fast and as long creeps and yields a hundredth as early; a carriage
    that comes to 0.3 m/s is allowed to slide from 0.01 mm/s on."""
    friction = LIBRARY["dry-friction"].with_choice(form)
    slow = VALUES | {"rig.travel_m": 2e-4, "rig.speed_m_s": 2e-3}
    here = parameter(friction, name)
    there = next(p for p in friction.parameters_for(slow, ()) if p.name == name)
    for number in ("lower", "upper", "scale"):
        assert getattr(there, number) == pytest.approx(0.01 * getattr(here, number))
    assert there.starts == pytest.approx([0.01 * start for start in here.starts])
    if form == "creeping":
        assert here.lower * 0.3 / (3 * VALUES["rig.speed_m_s"]) == pytest.approx(1e-5, rel=0.2)


def test_they_do_not_take_part_on_a_vehicle():
    from tests.simulate.setup import ATV

    for case in RIG_ONLY.values():
        effect = LIBRARY[case.effect]
        form = effect.with_choice(case.form) if case.form else effect
        assert not form.applies_to(ATV)
        assert form.applies_to(VALUES)
