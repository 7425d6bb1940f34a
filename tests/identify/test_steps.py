"""Step responses to damped sinusoids, to H(s), and back."""

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.identify import (
    Car,
    StateSpace,
    Struts,
    Wheels,
    fit_damped_sinusoids,
    incremental_model,
    read_steps,
    study,
)
from wheelhop.identify.equivalent import EquivalentVehicle
from wheelhop.identify.published import TABLE_2_2

EXAMPLES = Path(__file__).parents[2] / "examples"
TIME_S = np.arange(76) * 0.02
VEHICLE = EquivalentVehicle(0.45, 0.4, 0.55, 4.0, 60.0, 0.05)
BODY = VEHICLE.body()
RESPONSES = BODY.step(TIME_S).transpose(2, 1, 0)
TRUTH = sorted((-p.real, p.imag) for p in BODY.poles() if p.imag > 0)


@pytest.mark.parametrize("at_rest", [True, False])
def test_four_modes_are_four_sinusoids(at_rest):
    found = fit_damped_sinusoids(TIME_S, RESPONSES, 4, starts_at_rest=at_rest)
    assert found.error < 1e-8
    pairs = sorted(zip(found.sigma, found.omega, strict=True))
    assert np.array(pairs) == pytest.approx(np.array(TRUTH), rel=1e-5)
    s = 1j * np.array([1.0, 10.0, 60.0])
    h = found.transfer(4, 4)
    assert h(s) == pytest.approx(BODY(s), rel=1e-4, abs=1e-4 * np.abs(BODY(s)).max())
    assert h(s) == pytest.approx(h(s).transpose(0, 2, 1), abs=1e-4 * np.abs(h(s)).max())


def test_increments_over_two_steps_hold_all_four_modes():
    sigma, omega = incremental_model(TIME_S, RESPONSES, 2)
    for pair in zip(sigma, omega, strict=True):
        assert min(abs(complex(*pair) - complex(*truth)) for truth in TRUTH) < 1e-3


def test_the_first_guess_is_at_the_mercy_of_noise_and_the_fit_is_not():
    """Why Table A.2 can differ so much from Table 2.1: σ by 58 % (1.88 beside 4.452)."""
    noise = np.random.default_rng(0).standard_normal(RESPONSES.shape)
    noisy = RESPONSES + 1e-3 * np.abs(RESPONSES).max() * noise
    least = np.array(TRUTH)[np.argmin([sigma for sigma, _ in TRUTH])]
    guessed = min(
        np.array(incremental_model(TIME_S, noisy, 2)).T, key=lambda p: np.hypot(*(p - least))
    )
    fitted = fit_damped_sinusoids(TIME_S, noisy, 4)
    assert abs(guessed[0] / least[0] - 1) > 0.58
    assert fitted.sigma.min() == pytest.approx(least[0], rel=0.03)


def test_more_sinusoids_leave_less_and_transfer_matches_its_sinusoids():
    fits = [fit_damped_sinusoids(TIME_S, RESPONSES, j) for j in (1, 2, 3)]
    errors = [fit.error for fit in fits]
    assert errors == sorted(errors, reverse=True)
    fit = fits[-1]
    angle = np.outer(TIME_S, fit.omega)
    decay = np.exp(-np.outer(TIME_S, fit.sigma))
    by_terms = fit.residues[:, :1] + fit.residues[:, 1::2] @ (decay * np.sin(angle)).T
    by_terms = by_terms + fit.residues[:, 2::2] @ (decay * np.cos(angle)).T
    by_states = fit.transfer(4, 4).step(TIME_S).transpose(2, 1, 0).reshape(16, -1)
    assert by_states == pytest.approx(by_terms, abs=1e-9 * np.abs(by_terms).max())


def write(path, text):
    path.write_text(text)
    return path


def test_a_table_of_steps_is_fitted_by_command(tmp_path, capsys):
    header = ["time_s", *(f"B{p + 1}/F{f + 1}" for f in range(4) for p in range(4))]
    columns = [TIME_S, *(1000 * RESPONSES[f, p] for f in range(4) for p in range(4))]
    rows = [",".join(header), *(",".join(map(repr, row)) for row in np.array(columns).T.tolist())]
    file = write(tmp_path / "steps.csv", "\n".join(rows))
    steps = read_steps(file, 1000.0)
    assert steps.responses == pytest.approx(RESPONSES)
    mat = tmp_path / "steps.mat"
    words = ["identify", str(file), "--force-N", "1000", "--order", "8", "--mat", str(mat)]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert all(f"{sigma:.3f}" in printed for sigma, _ in TRUTH)
    written = loadmat(mat)
    h = StateSpace(*(written[name] for name in "ABCD"))([8j])
    assert h == pytest.approx(BODY(np.array([8j])), rel=1e-4, abs=1e-4 * np.abs(h).max())
    assert [str(name.item()) for name in written["outputs"].ravel()] == ["B1", "B2", "B3", "B4"]


def test_steps_are_studied_as_the_car_they_are_of(tmp_path, capsys):
    """Height at rest over a raised wheel: of the fitted body as of the body itself."""
    header = ["time_s", *(f"B{p + 1}/F{f + 1}" for f in range(4) for p in range(4))]
    columns = [TIME_S, *(RESPONSES[f, p] for f in range(4) for p in range(4))]
    rows = [",".join(header), *(",".join(map(repr, row)) for row in np.array(columns).T.tolist())]
    file = write(tmp_path / "steps.csv", "\n".join(rows))
    text = (EXAMPLES / "clean/vehicle.toml").read_text()
    front, rear, front_loss, rear_loss = TABLE_2_2["old"]  # what BODY stands on
    for ours, theirs in (("10500.0", front), ("6500.0", rear), ("630.0", front_loss)):
        text = text.replace(ours, f"{theirs:.1f}")
    toml = write(tmp_path / "vehicle.toml", text.replace("590.0", f"{rear_loss:.1f}"))
    words = ["identify", str(file), "--order", "8", "--study", "front-stiffness=1,1.5"]
    assert main([*words, "--vehicle", str(toml)]) == 0
    printed = capsys.readouterr().out
    wheels = Wheels((15.0, 12.5), (40e3, 40e3), (200.0, 200.0))
    car = Car(BODY, Struts(*TABLE_2_2["old"]), wheels, VEHICLE.sprung_kg())
    truth = study(car, "front-stiffness", [1.0, 1.5])
    assert all(f"{v.static:.3f}" in printed for v in truth)
    assert main(words) == 2
    assert "need --vehicle" in capsys.readouterr().err
    assert main([*words, "--physics"]) == 2
    assert "--physics is for campaigns" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("t,B1/F1\n0,0\n1,1", "first column must be time_s"),
        ("time_s,B1\n0,0\n1,1", "name it POINT/FORCE"),
        ("time_s,B1/F1,B2/F2\n0,0,0\n1,1,1", "each response once"),
        ("time_s,B1/F1\n0,0\n1,x", 'row 3, column B1/F1: "x"'),
        ("time_s,B1/F1\n0,0\n1", "row 3 has 1 cells"),
        ("time_s,B1/F1\n1,0\n2,1", "must begin at 0"),
        ("time_s,B1/F1\n0,0\n1,1", "too few"),
    ],
)
def test_a_table_that_is_wrong_is_one_line(tmp_path, capsys, text, line):
    file = write(tmp_path / "steps.csv", text)
    assert main(["identify", str(file)]) == 2
    assert line in (printed := capsys.readouterr().err)
    assert printed.count("\n") == 1


def test_silence_cannot_be_fitted():
    with pytest.raises(CampaignError, match="all zero"):
        fit_damped_sinusoids(TIME_S, 0 * RESPONSES, 1)
