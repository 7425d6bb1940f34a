"""What a fit's own numbers betray, told from the numbers alone."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from wheelhop.campaign import Channel
from wheelhop.compare import Slice, estimate_noise_between_samples
from wheelhop.compare.floor import QUIETEST, REPEATED, Floor
from wheelhop.diagnose.diagnosis import Ranked
from wheelhop.diagnose.verdict.critic import (
    Number,
    _bounds,
    _fair_band,
    _floor,
    _laws,
    _moved,
    _no_vehicle,
    _rivals,
    _untold,
    upheld,
)
from wheelhop.effects import load_effects
from wheelhop.fit import Free
from wheelhop.gate import Finding

LIBRARY = load_effects()
INF = float("inf")


def number(
    name, value, sd=0.01, mean=0.0, sigma=INF, lower=-INF, upper=INF, shape=False, ahead=0.0
):
    scale = max(abs(value), 1e-3)
    return Number(Free(name, mean, sigma, scale, lower, upper, is_shape=shape), value, sd, ahead)


LOSS = number("digressive-damper.front_loss", 0.6, 0.02, lower=0.0, upper=1.0)
KNEE = number("digressive-damper.knee_m_s", 0.01, 0.001, 0.2, 0.2, 0.01, shape=True, ahead=-1.0)
DAMPER = [LIBRARY["digressive-damper"]]


def test_a_knee_at_rest_is_friction():
    (finding,) = _laws([LOSS, KNEE], DAMPER)
    assert list(_bounds([LOSS, KNEE], DAMPER)) == []  # that is what the bound means
    assert "dry-friction" in finding.text and "dry-friction" in finding.remedy
    assert finding.when == "after" and finding.about == KNEE.name


def test_a_knee_that_is_told_from_rest_is_a_knee():
    assert list(_laws([LOSS, replace(KNEE, value=0.15)], DAMPER)) == []


def step(*errors, above_floor=True):
    """A rung with these errors in bands of equal power, an octave each."""
    bands = [Slice(f"{2**i}", e**2, 1.0, 0.0, 0.0) for i, e in enumerate(errors)]
    total = Slice("all", sum(b.residual for b in bands), len(bands), 0.0, 1.0)
    breakdown = SimpleNamespace(band=bands, total=total)
    return SimpleNamespace(comparison=SimpleNamespace(breakdown=breakdown), above_floor=above_floor)


WORSE = [0.5, 0.3, 0.5, 0.6, 1.3, 1.1]  # beyond 8 Hz than no model


@pytest.mark.parametrize(
    ("baseline", "last", "band", "said"),
    [
        (WORSE, [], "1, 8", "the same model leaves 49 %, over the whole band 80 %"),
        ([0.2, 0.1, 0.2, 0.2, 0.9, 0.9], [], "1, 8", "the same model leaves 18 %"),
        (WORSE, [0.5, 0.3, 0.5, 0.6, 0.8, 0.7], "1, 8", "the baseline leaves 49 %"),
        ([0.5, 0.3, 0.5, 0.6, 0.7, 1.3], WORSE, "1, 8", "the same model leaves 49 %"),
        ([0.6] * 6, [], "", ""),
        ([1.2, 1.1, 1.2, 1.1, 0.9, 1.0], [], "", ""),  # fair in too little of it
    ],
)
def test_the_band_in_which_a_model_is_fair_is_offered(baseline, last, band, said):
    """Where it is worse than none elsewhere, or much better there; the last model's, or else the
    baseline's."""
    ladder = [step(*baseline), step(*(last or baseline))]
    found = list(_fair_band(ladder))
    offer = f"Set band_hz = [{band}] in campaign.toml to look only there."
    assert [f.remedy for f in found] == [offer] * bool(band)
    assert all(said in f.text for f in found)
    ladder[-1].above_floor = False
    assert list(_fair_band(ladder)) == []


def ranked(effect, fitted, held_out):
    return Ranked(effect, "suspension", fitted, fitted, held_out, 9.0, 1e-6, (), {}, "")


@pytest.mark.parametrize(
    ("fitted", "held_out", "said"),
    [(0.00762, 0.00531, True), (0.00761, 0.0062, False), (0.0095, 0.00528, False)],
)
def test_the_verdict_is_both_names_where_another_comes_as_far(fitted, held_out, said):
    """The one named is 13 % above the floor."""
    ranking = [ranked("digressive-damper", 0.00761, 0.00528)]
    ranking += [ranked("dry-friction", fitted, held_out), ranked("backlash", None, None)]
    found = list(_rivals(ranking, ["digressive-damper"], 0.0067, 0.00468))
    assert ["digressive-damper or dry-friction" in f.remedy for f in found] == [True] * said
    assert list(_rivals(ranking, [], 0.0067, 0.00468)) == []


def test_all_that_come_as_far_are_in_one_sentence():
    ranking = [ranked(name, 0.0076, 0.0053) for name in ("mr-damper", "dry-friction", "backlash")]
    (finding,) = _rivals(ranking, ["mr-damper"], 0.0067, 0.0046)
    assert finding.about == "mr-damper and dry-friction and backlash"
    assert "dry-friction (0.530 %) and backlash (0.530 %)" in finding.text


def test_a_law_that_leaves_noise_alone_has_no_rivals():
    ranking = [ranked("dry-friction", 0.0067, 0.00468), ranked("backlash", 0.0068, 0.00475)]
    assert list(_rivals(ranking, ["dry-friction"], 0.0067, 0.00468)) == []


def test_a_law_without_strength_is_none():
    faint = replace(LOSS, value=0.03, sd=0.02)
    (finding,) = _laws([faint, replace(KNEE, value=0.15)], DAMPER)
    assert "no strength" in finding.text


def test_a_number_on_its_bound_is_said_and_an_absent_amplitude_is_not():
    mass = number("body.mass_kg", 4.0, 0.1, 200.0, 20.0, lower=4.0, ahead=-1.0)
    absent = replace(LOSS, value=0.0, ahead=-1.0)
    (finding,) = _bounds([mass, absent], DAMPER)
    assert finding.about == "body.mass_kg" and finding.kind == "at-bound"


@pytest.mark.parametrize(("ahead", "said"), [(-0.29, False), (-0.31, True), (0.4, False)])
def test_a_number_as_likely_to_be_just_short_of_its_bound_is_not_held_by_it(ahead, said):
    """The truth may well lie there, as no lean at all of a driver who rocks (blind seed 13417: 2.04
    of its deviations, and half of all confidence): three, of 0.1, outwards are told from it."""
    mass = number("body.mass_kg", 4.0, 0.1, 200.0, 20.0, lower=4.0, upper=400.0, ahead=ahead)
    assert bool(list(_bounds([mass], DAMPER))) is said


@pytest.mark.parametrize(
    ("value", "sd", "said"),
    [(229.0, 1.0, False), (231.0, 1.0, True), (160.0, 1.0, True), (226.0, 6.0, True)],
)
def test_three_standard_deviations(value, sd, said):
    """Of how far a fit moves a right belief: what is left uncertain was not moved."""
    found = list(_moved([number("body.mass_kg", value, sd, 200.0, 10.0)], []))
    assert bool(found) == said


@pytest.mark.parametrize(
    ("value", "said"), [(149.0, False), (147.0, True), (269.0, False), (271.0, True)]
)
def test_a_number_believed_in_proportion_moves_by_its_logarithm(value, said):
    """Of 200 to 10 %, three deviations are 148.4 to 269.6: 1 % is left uncertain."""
    mass = Free("body.mass_kg", 200.0, 20.0, 20.0, in_proportion=True)
    assert bool(list(_moved([Number(mass, value, 0.01 * value, 0.0)], []))) == said


def masses(sd):
    names = ("body.mass_kg", "suspension.front.stiffness_N_m", "suspension.rear.stiffness_N_m")
    return [number(name, 100.0, sd, 100.0, 10.0) for name in names]


def test_the_common_scale_is_named_once():
    """Ratios known to 0.1 %, the scale as well as it was believed."""
    ones = np.ones((3, 3)) / 3
    covariance = 10.0**2 * ones + 0.1**2 * (np.eye(3) - ones)
    (finding,) = _untold(masses(1.0), covariance)
    assert "common scale" in finding.about


def test_what_only_belief_holds_is_named():
    """The first number is as uncertain as before; the others the data have told."""
    (finding,) = _untold(masses(1.0), np.diag([100.0, 0.01, 0.01]))
    assert finding.about == "body.mass_kg"


def test_what_the_data_have_told_is_not():
    assert list(_untold(masses(1.0), np.diag([1.0, 1.0, 1.0]))) == []


def test_every_declared_limit_is_a_parameter_with_that_bound(nominal):
    declared = [(e, limit) for e in LIBRARY.values() for limit in e.becomes]
    assert declared
    for effect, limit in declared:
        found = {p.name: p for p in effect.parameters_for(nominal.values, ())}
        bound = getattr(found[limit.parameter], limit.at)
        assert np.isfinite(bound), (effect.id, limit)


@pytest.fixture
def nominal():
    from pathlib import Path

    from wheelhop.vehicle import read_vehicle

    return read_vehicle(Path(__file__).parents[2] / "examples/clean/vehicle.toml")


def test_noise_from_one_sample_to_the_next():
    """White noise of 0.1 under a wave of a twentieth of the sample rate, thirty times as large."""
    rng, time = np.random.default_rng(0), np.arange(2000)
    wave = 3.0 * np.sin(2 * np.pi * 0.02 * time)[:, None]
    records = [wave + 0.1 * rng.normal(size=(2000, 4)) for _ in range(3)]
    found = estimate_noise_between_samples(records, 0.59)
    assert 0.6 < found / (0.1 * np.sqrt(0.59)) < 1.2


@pytest.mark.parametrize(
    ("rms", "stated", "basis", "filtered", "said"),
    [
        (0.30, False, QUIETEST, False, True),
        (0.09, False, QUIETEST, False, False),
        (0.30, True, QUIETEST, False, False),
        (0.30, False, REPEATED, False, False),
        (0.30, False, QUIETEST, True, False),
    ],
)
def test_an_estimated_floor_that_neighbouring_samples_do_not_show_is_misfit(
    rms, stated, basis, filtered, said
):
    """The sensors' noise is 0.1 m/s², 0.077 of it in band; nothing is said of what differs from
    repeat to repeat, nor of a recorder that has filtered the noise between samples away."""
    record = 0.1 * np.random.default_rng(1).normal(size=(4000, 2))
    if filtered:
        lines = np.fft.rfft(record, axis=0)
        lines[len(lines) * 6 // 10 :] = 0.0
        record = np.fft.irfft(lines, len(record), axis=0)
    bench = SimpleNamespace(
        run=SimpleNamespace(record=record),
        predicted=np.array([True, True]),
        band=SimpleNamespace(count=59, n=100),
        noise_scale=np.ones(2),
        simulator=SimpleNamespace(campaign=SimpleNamespace(unstated=(Channel("A1", "A1"),))),
    )
    fitted = SimpleNamespace(runs=(SimpleNamespace(bench=bench),))
    key = "noise_rms_m_s2"
    source = key if stated else "estimated"
    floor = Floor(*[0.1] * 6, source, np.full(2, rms), key, "m/s²", 0.0, basis=basis)
    rung = SimpleNamespace(fit=fitted, validation=None)
    step = SimpleNamespace(rung=rung, comparison=SimpleNamespace(floor=floor))
    assert [(f.kind, f.about) for f in _floor(step)] == [("floor", "noise_rms_m_s2")] * said


@pytest.mark.parametrize("is_free", [True, False])
def test_fitted_numbers_that_no_vehicle_has(nominal, is_free):
    """A number that the fit did not choose is the gate's affair, who saw it before."""
    spring = "suspension.front.stiffness_N_m"
    values = {**nominal.values, spring: 1e-3 * nominal.values[spring]}
    fitted = SimpleNamespace(model=SimpleNamespace(values=values))
    free = [number(spring if is_free else "body.mass_kg", 1.0)]
    found = list(_no_vehicle(SimpleNamespace(rung=SimpleNamespace(fit=fitted)), free))
    assert [f.about for f in found] == [spring] * is_free
    assert all(f.when == "after" for f in found)


LATE = Finding("before", "out-of-step", "channels A1 and A2", "The axles are 40 ms late.", "Look.")
UPSIDE_DOWN = Finding("before", "polarity", "channels B1", "B1 is upside down.", "Turn it over.")


def rung(power, *effects):
    """What leaves so much of a datum's power, in units of the noise's."""
    judging = SimpleNamespace(charged=1e4 * power, size=10_000)
    return SimpleNamespace(judging=judging, model=SimpleNamespace(effects=effects))


@pytest.mark.parametrize(
    ("first", "last", "is_left"),
    [
        pytest.param(rung(100.0), rung(5.0, *DAMPER), False, id="nearly-all-is-explained"),
        pytest.param(rung(1.02), rung(1.02), False, id="nothing-is-missing"),
        pytest.param(rung(100.0), rung(40.0, *DAMPER), True, id="a-part-is-explained"),
        pytest.param(rung(100.0), rung(1.0, LIBRARY["sensor-skew"]), True, id="by-a-sensor"),
    ],
)
def test_no_clock_is_wrong_where_laws_explain_the_records_as_they_are(first, last, is_left):
    diagnosis = SimpleNamespace(ladder=[SimpleNamespace(rung=first), SimpleNamespace(rung=last)])
    left = upheld([LATE, UPSIDE_DOWN], diagnosis, noise=1.0)
    assert left == ([LATE, UPSIDE_DOWN] if is_left else [UPSIDE_DOWN])
