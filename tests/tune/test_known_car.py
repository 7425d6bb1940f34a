"""A car as it is known: read from a model's file, and drawn as it may be."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.report.conftest import LIBRARY, Case
from tests.report.small import write_small_campaign
from tests.tune.cars import FILE, VEHICLE, car
from wheelhop.api.tuning import driven
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.effects import load_effects
from wheelhop.predict.known_car import KnownCar, read_car
from wheelhop.report.model_file import write_model


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    """A fitted car, and the file that it was written to."""
    folder = write_small_campaign(tmp_path_factory.mktemp("friction") / "c")
    case = Case(folder, {"dry-friction": LIBRARY["dry-friction"]})
    write_model(folder / "model.toml", case.campaign, case.vehicle, case.diagnosis.ladder)
    return case.diagnosis.ladder[-1], folder


def test_the_car_of_a_campaign_is_the_one_that_was_fitted(fitted):
    step, folder = fitted
    found = read_car(folder, load_effects())
    fit = step.rung.fit
    assert found.correlated and found.misfit == step.rung.error_validate
    for name, value in found.values.items():
        assert value == step.rung.model.values[name]
    at = [
        [free.name for free in fit.shared].index(name)
        for name in found.names
        if name in fit.deviations
    ]
    names = [fit.shared[i].name for i in at]
    stated = found.covariance[np.ix_(*2 * [[found.names.index(name) for name in names]])]
    spread = np.sqrt(np.diag(fit.covariance))
    expected = (fit.covariance / np.outer(spread, spread))[np.ix_(at, at)]
    deviation = np.array([step.parameters[name][1] for name in names])
    assert stated == pytest.approx(expected * np.outer(deviation, deviation), rel=1e-6, abs=1e-12)


def test_correlations_keep_what_the_records_tell_apart(fitted):
    """Records tell the ratio of stiffness to mass far better than either: so must the draws."""
    _, folder = fitted
    found = read_car(folder, load_effects())
    draws = found.draws(200, np.random.default_rng(0))
    mass, rate = (
        np.array([one[name] for one in draws])
        for name in ("body.mass_kg", "suspension.front.stiffness_N_m")
    )
    ratio = rate / mass
    assert ratio.std() / ratio.mean() < 0.2 * mass.std() / mass.mean()


def test_an_older_file_without_correlations_is_read_and_says_so(fitted, tmp_path):
    _, folder = fitted
    text = (folder / "model.toml").read_text(encoding="utf-8")
    head, _, rest = text.partition("\n[correlation]\n")
    older = tmp_path / "model.toml"
    older.write_text(head + "\n" + rest[rest.index("\n[") :], encoding="utf-8")
    found, newer = read_car(older, load_effects()), read_car(folder, load_effects())
    assert not found.correlated
    assert np.diag(found.covariance) == pytest.approx(np.diag(newer.covariance))
    assert found.covariance == pytest.approx(np.diag(np.diag(found.covariance)))


def test_it_drives_what_its_campaign_drove(fitted):
    _, folder = fitted
    runs, drives = read_campaign(folder).runs, driven(folder)
    assert [drive.id for drive in drives] == [run.id for run in runs]
    for drive, run in zip(drives, runs, strict=True):
        assert drive.track == run.track
        assert drive.speed_kmph / 3.6 == pytest.approx(run.speed_m_s)


def test_a_vehicle_file_is_a_car_too():
    found = read_car(FILE, {})
    assert found.values == VEHICLE.values and found.misfit == 0.0 and not found.effects


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('id = "dry-friction"', 'id = "dry-fricton"', "did you mean"),
        ('vehicle_name = "', 'vehicle_nam = "', "vehicle_name"),
        ("front_N = ", "front = ", "front_N"),
        ("mass_kg = ", "mass_kg = -", "mass_kg"),
        ('"body.mass_kg" = [', '"body.mass_kg" = [1.0, ', "must have"),
    ],
)
def test_a_file_that_is_wrong_is_one_line(fitted, tmp_path, old, new, says):
    _, folder = fitted
    text = (folder / "model.toml").read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "model.toml").write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CampaignError, match=says) as told:
        read_car(tmp_path, load_effects())
    assert str(tmp_path) in str(told.value) and "\n" not in str(told.value)


def test_a_campaign_without_a_model_says_how_to_make_one(tmp_path):
    with pytest.raises(CampaignError, match="wheelhop add"):
        read_car(tmp_path, {})


@given(st.floats(0.01, 0.2), st.floats(-0.99, 0.99))
def test_draws_have_the_covariance_that_is_stated(relative, correlation):
    names = ("suspension.front.stiffness_N_m", "body.mass_kg")
    spread = relative * np.array([VEHICLE[name] for name in names])
    covariance = np.outer(spread, spread) * [[1.0, correlation], [correlation, 1.0]]
    known = KnownCar(VEHICLE, (), names, covariance, 0.0, True)
    drawn = np.array([[*one.values()] for one in known.draws(4000, np.random.default_rng(1))])
    assert np.cov(drawn.T) / np.outer(spread, spread) == pytest.approx(
        covariance / np.outer(spread, spread), abs=0.12
    )


def test_no_draw_leaves_what_a_number_can_be():
    known = car(["dry-friction:front_N=5"], relative=3.0)
    for one in known.draws(50, np.random.default_rng(2)):
        assert all(value > 0.0 for value in one.values())
    assert known.bounded({"dry-friction.front_N": -3.0}) == {"dry-friction.front_N": 0.0}
