"""What an identified matrix foresees of the body, beside what was measured."""

from pathlib import Path

import numpy as np
import pytest

from tests.identify.test_command import model  # noqa: F401
from wheelhop.campaign import read_campaign
from wheelhop.compare import InBand
from wheelhop.identify import Measured, Structure, identify, measure, predict, spectra
from wheelhop.identify.synthetic import records, thesis_matrix, thesis_runs

EXAMPLES = Path(__file__).parents[2] / "examples"
THESIS = Structure("symmetric", rigid=False)
CORNERS = (0, 1, 2, 3)


def noisy_runs(runs, seed):
    """Of the thesis's matrix; every sensor, on axles and body, has the same noise."""
    exact = records(thesis_matrix(), runs=runs, samples=512, seed=seed)
    rng = np.random.default_rng(seed + 100)
    noisy = [record + 0.04 * rng.standard_normal(record.shape) for record in exact]
    return spectra(*noisy, 100.0, (0.5, 30.0))


def test_the_bands_hold_the_difference_as_often_as_they_say_on_runs_never_fitted():
    """The noise is not stated: what H leaves of the two runs fitted tells its level."""
    fitted, held = noisy_runs(2, 5), noisy_runs(20, 6)
    found = predict(
        identify([fitted], THESIS), Measured((fitted,), (held,), CORNERS, CORNERS, None)
    )
    assert [p.held_out for p in found] == [True] * 20 + [False] * 2
    away = np.array([(p.measured - p.predicted) / p.doubt for p in found[:20]])
    parts = np.abs([away.real, away.imag])
    assert np.mean(parts < 1.96) == pytest.approx(0.95, abs=0.01)
    assert np.sqrt(np.mean(parts**2)) == pytest.approx(1.0, abs=0.03)


def test_without_noise_the_prediction_is_the_measurement():
    runs = thesis_runs(runs=6)
    for p in predict(identify([runs], THESIS), Measured((), (runs,), CORNERS, CORNERS, 0.0)):
        assert p.error.max() < 1e-4


def test_doubt_of_one_axle_moved_alone_is_the_standard_error_of_its_column(model):  # noqa: F811
    s = 2j * np.pi * np.array([0.7, 3.0, 12.0])
    inputs = np.zeros((1, 3, 4), complex)
    inputs[0, :, 2] = np.array([2.0, 1.0j, -3.0])
    expected = np.abs(inputs[0, :, 2])[:, None] * model.standard_error(s)[:, :, 2]
    assert model.doubt(s, inputs)[0] == pytest.approx(expected, rel=1e-9)


def test_signals_and_densities_are_those_of_the_record():
    """Parseval: the density's integral is the mean square of the record in band."""
    rate, band = 100.0, (0.5, 30.0)
    axles, body = records(thesis_matrix(), 0.1, samples=700, rate_hz=rate, runs=2)
    part = spectra(axles, body, rate, band, ("a", "b"))
    h = identify([part], THESIS, order=4)
    first = predict(h, Measured((part,), (), CORNERS, CORNERS, None))[0]
    in_band = InBand(700, rate, band).signal(body[0])
    assert first.signal(first.measured) == pytest.approx(in_band, abs=1e-9 * np.abs(in_band).max())
    assert first.time_s[1] == pytest.approx(1 / rate)
    density = first.density(first.measured).sum(axis=0) * rate / 700
    assert density == pytest.approx(np.mean(in_band**2, axis=0))


@pytest.mark.parametrize(
    ("name", "least", "most"), [("clean", 0.9, 1.1), ("open-dry-friction", 3.0, 99)]
)
def test_a_linear_car_is_foreseen_to_the_noise_and_friction_is_not(name, least, most):
    measured = measure(read_campaign(EXAMPLES / name))
    h = identify(measured.fit, Structure("free"), order=6, noise_rms=measured.noise_rms)
    held = [p for p in predict(h, measured) if p.held_out]
    power = np.array([np.sum(np.abs(p.measured) ** 2, axis=0) for p in held])
    error, expected = (
        np.sqrt(np.sum(np.array([getattr(p, k) for p in held]) ** 2 * power))
        for k in ("error", "expected")
    )
    assert least < error / expected < most
