"""Confirmation: an effect finds its numbers although the vehicle was bent to make up for it."""

from dataclasses import dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests import truth
from tests.diagnose.cases import LIBRARY, baseline_of
from wheelhop.diagnose.confirm import in_full as confirming
from wheelhop.diagnose.confirm.in_full import confirm, refit, worth_simulating
from wheelhop.diagnose.confirm.starts import Start, saturated
from wheelhop.diagnose.confirm.validate import Incumbent
from wheelhop.diagnose.score import Rung
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import Switch


def test_shapes_wait_until_the_amplitude_has_come(tmp_path):
    """The baseline has taken the rocking driver for a body of 21 kg m² in roll, not 28: to the
    small amplitude that fits such a body hardly any frequency is wrong."""
    hidden = {"driver-rocking": {"roll_inertia_kg_m2": 6.0, "freq_hz": 2.4, "zeta": 0.25}}
    folder = truth.make_campaign(
        tmp_path, seed=103, effects=hidden, preset="formula-student", short=True, draft=True
    )
    base = baseline_of(folder)
    (screened,) = screen(base.workshop, base.rung.fit, [LIBRARY["driver-rocking"]])
    rung = confirm(Incumbent(base.workshop, base.rung), screened)
    noise = base.workshop.noise**2 * rung.fit.size
    assert rung.fit.rss < 1.05 * noise < base.rung.fit.rss / 1.5
    assert rung.model.values["driver-rocking.inertia_kg_m2"] == pytest.approx(6.0, rel=0.1)
    assert rung.model.values["driver-rocking.freq_hz"] == pytest.approx(2.4, rel=0.05)


@pytest.mark.slow  # test_starts asks when the vehicle as believed is a start
def test_an_effect_whose_lack_has_led_the_vehicle_astray_is_found(tmp_path):
    """For want of long contact patches the baseline makes wheels of two fifths of their radius or
    less and unsprung masses of a tenth of theirs. From there even a fit with all derivatives ended
    at 9.6 times the noise's power."""
    hidden = {"tyre-envelope": {"front_m": 0.26, "rear_m": 0.32}}
    folder = truth.make_campaign(
        tmp_path, seed=105, effects=hidden, preset="formula-student", short=True, draft=True
    )
    base = baseline_of(folder)
    (screened,) = screen(base.workshop, base.rung.fit, [LIBRARY["tyre-envelope"]])
    rung = confirm(Incumbent(base.workshop, base.rung), screened)
    assert rung.fit.rss < 1.05 * base.workshop.noise**2 * rung.fit.size


def test_a_driver_on_a_stiff_seat_is_no_negative_mass(tmp_path):
    """Above a formula car's heave: of a soft seat one would need less than nothing there."""
    hidden = {"driver-seat": {"mass_kg": 60.0, "freq_hz": 12.0, "zeta": 0.15, "x_m": 0.05}}
    folder = truth.make_campaign(
        tmp_path, seed=104, effects=hidden, preset="formula-student", short=True, draft=True
    )
    base = baseline_of(folder)
    (screened,) = screen(base.workshop, base.rung.fit, [LIBRARY["driver-seat"]])
    assert screened.score > 0.0
    rung = refit(base.workshop, confirm(Incumbent(base.workshop, base.rung), screened))
    assert rung.fit.rss < 1.05 * base.workshop.noise**2 * rung.fit.size
    assert rung.model.values["driver-seat.freq_hz"] == pytest.approx(12.0, rel=0.05)


@pytest.mark.slow
def test_a_gap_that_is_never_used_up_is_not_believed_to_be_wide(tmp_path):
    """Behind, the strut hangs free and seldom reaches the gap's other side: a gap some times as
    wide fits nearly as well, and the search may begin there."""
    hidden = {"backlash": {"gap_m": 0.001}}
    folder = truth.make_campaign(tmp_path, seed=7101, effects=hidden, short=True)
    base = baseline_of(folder)
    (screened,) = screen(base.workshop, base.rung.fit, [LIBRARY["backlash"]])
    values = confirm(Incumbent(base.workshop, base.rung), screened).model.values
    mean, balance = values["backlash.gap_m"], values["backlash.balance"]
    assert mean * (1.0 + balance) == pytest.approx(0.001, rel=0.1)
    assert mean * (1.0 - balance) == pytest.approx(0.001, rel=0.1)


@pytest.mark.slow
def test_a_gap_wider_than_any_strut_moves_is_tried(tmp_path):
    """It moves the records as any wider one does: where a fit from below ends at front and rear
    gaps that nobody believes to be so unlike, one from above counts if it does as well."""
    hidden = {"backlash": {"gap_m": 0.01}}
    folder = truth.make_campaign(tmp_path, seed=108, effects=hidden, preset="atv", short=True)
    base = baseline_of(folder)
    (screened,) = screen(base.workshop, base.rung.fit, [LIBRARY["backlash"]])
    (start,) = saturated(base.workshop, base.rung, screened)
    wide = start.model
    assert wide.values["backlash.balance"] == 0.0  # of all that fit alike, what is believed
    assert wide.values["backlash.gap_m"] > 0.005
    wider = wide.with_values({"backlash.gap_m": 3.0 * wide.values["backlash.gap_m"]})
    one, other = (base.workshop.responses(model) for model in (wide, wider))
    for run, same in zip(one, other, strict=True):
        np.testing.assert_allclose(run.record, same.record, rtol=1e-9)
    rung = confirm(Incumbent(base.workshop, base.rung), screened)
    assert rung.judging.rss < 1.1 * base.workshop.noise**2 * rung.judging.size


def test_a_switch_is_no_rival_of_what_explains_nearly_all(tmp_path):
    """Friction explains everything here. Whether wheels lift no first order tells: it is simulated,
    and makes it worse however the vehicle is bent; but not beside friction."""
    hidden = {"dry-friction": {"coulomb_front_N": 75.0, "coulomb_rear_N": 55.0}}
    folder = truth.make_campaign(tmp_path, seed=105, effects=hidden, short=True, draft=True)
    base = baseline_of(folder)
    effects = [LIBRARY["dry-friction"], LIBRARY["tyre-lift-off"]]
    screened = screen(base.workshop, base.rung.fit, effects)
    chosen = worth_simulating(base.workshop, base.rung, screened)
    friction, lifting = (confirm(Incumbent(base.workshop, base.rung), item) for item in chosen)
    assert friction.fit.rss < base.rung.fit.rss < lifting.fit.rss
    (left,) = worth_simulating(base.workshop, base.rung, screened, settled=True)
    assert left.variant.effect.id == "dry-friction"


@dataclass
class Quick:
    """A fit with borrowed derivatives."""

    model: object
    cost: float
    error: float
    evidence: float

    @property
    def misfit(self):
        return self.cost


@pytest.mark.parametrize(
    ("cost", "error", "beside", "bars"),
    [
        (150.0, 1.9, [], [100.0]),
        (150.0, 2.1, [], []),
        (100.2, 1.9, [], []),
        (150.0, 1.9, [130.0, 60.0], [60.0]),
    ],
)
def test_a_switch_that_leaves_twice_as_much_is_fitted_no_further(
    cost, error, beside, bars, monkeypatch
):
    """Wheels lift in a model where they should not: no full fit makes up for that. And where none
    lifts in the runs fitted, a quick fit is as good as a full one. One that has no hope to come as
    far as the best model beside it ends early."""
    switch = SimpleNamespace(amplitudes=[Switch("lifts", "1", "1: it lifts")], parameters=())
    switch.effect = SimpleNamespace()
    model = SimpleNamespace(theta=lambda effect: {}, random_heights=None, effects=(), values={})
    fitted = SimpleNamespace(cost=100.0, misfit=100.0, size=100.0, error=1.0, model=model)
    base = Rung(fitted, None)
    quick = Quick(model, cost=cost, error=error, evidence=0.0)
    fitted = []

    def full(workshop, rung, bar):
        fitted.append(bar)
        return rung

    workshop = SimpleNamespace(noise=1.0, of_role=lambda role: [])
    monkeypatch.setattr(confirming, "starts", lambda *_: [Start(model, "", base)])
    monkeypatch.setattr(confirming, "fitted_from", lambda *_: quick)
    monkeypatch.setattr(confirming, "begun", lambda *_: model)
    monkeypatch.setattr(confirming, "validate", lambda workshop, fit, update: Rung(fit, None))
    monkeypatch.setattr(confirming, "refit", full)
    others = [replace(base, fit=SimpleNamespace(misfit=each, model=model)) for each in beside]
    confirm(Incumbent(workshop, base), SimpleNamespace(variant=switch, error=1.0), others)
    assert fitted == bars


@pytest.mark.slow
@pytest.mark.parametrize("rate", [0.012, 0.02])
def test_sides_far_apart_are_placed_each_by_itself(tmp_path, rate):
    """Where one side is waves ahead in the end, one speed is true of neither, and a fit that begins
    with sides abreast ends in a false minimum in run after run."""
    hidden = {"left-right-drift": {"rate": rate}}
    folder = truth.make_campaign(tmp_path, seed=107, effects=hidden, short=True)
    base = baseline_of(folder)
    (screened,) = screen(base.workshop, base.rung.fit, [LIBRARY["left-right-drift"]])
    rung = refit(base.workshop, confirm(Incumbent(base.workshop, base.rung), screened))
    assert rung.fit.rss < 1.05 * base.workshop.noise**2 * rung.fit.size < base.rung.fit.rss / 100
