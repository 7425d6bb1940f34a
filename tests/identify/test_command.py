"""wheelhop identify and wheelhop thesis, and the files they write."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pandas as pd
import pytest
import skrf
from scipy.io import loadmat
from skrf.vectorFitting import VectorFitting

from wheelhop.campaign import read_campaign
from wheelhop.cli.main import main
from wheelhop.identify import (
    Sections,
    Structure,
    TransferMatrix,
    identify,
    measure,
    poles_and_residues,
    polynomials,
    state_space,
    suspensions,
    write_mat,
)
from wheelhop.vehicle import read_vehicle

CLEAN = Path(__file__).parents[2] / "examples/clean"
S = 2j * np.pi * np.array([0.7, 3.0, 12.0])


def with_a_dead_axle(folder):
    """The clean example, its third axle's sensor unplugged: it tells of its own noise."""
    shutil.copytree(CLEAN, folder)
    rng = np.random.default_rng(1)
    for file in (folder / "runs").glob("*.csv"):
        table = pd.read_csv(file)
        table["A3"] = rng.normal(0.0, 0.02, len(table)).round(4)
        table.to_csv(file, index=False)
    return folder


@pytest.fixture(scope="module")
def model():
    campaign = read_campaign(CLEAN)
    vehicle = read_vehicle(campaign.vehicle_file)
    belief = suspensions(vehicle.values, vehicle.uncertainty)
    return identify(measure(campaign).fit, Structure(), order=5, suspensions=belief)


def test_states_polynomials_and_residues_are_the_same_matrix(model):
    h = model(S)
    assert state_space(model)(S) == pytest.approx(h, rel=1e-9)
    numerators, denominator = polynomials(model)
    over = np.array([[np.polyval(n, S) for n in row] for row in numerators])
    assert (over / np.polyval(denominator, S)).transpose(2, 0, 1) == pytest.approx(h, rel=1e-8)
    system = state_space(model)
    theirs = control.ss(system.a, system.b, system.c, system.d)
    assert theirs(S[1]) == pytest.approx(h[1], rel=1e-9)


def test_residues_are_those_of_scikit_rf(model):
    """Its rational function of one element, from our poles, residues and constant."""
    poles, residues, direct = poles_and_residues(model)
    fitting = VectorFitting(skrf.Network(f=[1, 2], s=np.zeros((2, 1, 1)), z0=50))
    fitting.poles, fitting.residues = poles, residues[0, 2][None]
    fitting.constant_coeff = np.array([direct[0, 2]])
    fitting.proportional_coeff = np.zeros(1)
    found = fitting.get_model_response(0, 0, S.imag / (2 * np.pi))
    assert found == pytest.approx(model(S)[:, 0, 2], rel=1e-8)


def test_poles_that_coincide_have_no_residues_and_are_still_written(model, tmp_path):
    sections = Sections(np.array([12.0, 25.0]), np.array([0.4, 1.0]), 60.0)
    double = replace(model, sections=sections)
    with pytest.raises(ValueError, match="coincide"):
        poles_and_residues(double)
    write_mat(double, tmp_path / "h.mat")
    mat = loadmat(tmp_path / "h.mat")
    assert "A" in mat and "poles" not in mat


def test_the_command_judges_draws_and_exports(tmp_path, capsys):
    files = {key: tmp_path / f"out.{key}" for key in ("json", "mat", "png")}
    arguments = ["identify", str(CLEAN), "--order", "6", "--physics", "--json", str(files["json"])]
    arguments += ["--mat", str(files["mat"]), "--figure", str(files["png"])]
    drawn = tmp_path / "study.png"
    arguments += ["--study", "front-stiffness=1,1.5", "--study-figure", str(drawn)]
    arguments += ["--report", str(tmp_path / "h.html")]
    assert main(arguments) == 0
    page = (tmp_path / "h.html").read_text()
    assert all(page.count(f">{run.id}</td>") == 1 for run in read_campaign(CLEAN).runs)
    assert page.count("<svg") == 1 + len(read_campaign(CLEAN).runs)
    printed = capsys.readouterr().out
    assert "H itself symmetric (thesis)" in printed and "chassis-twist" in printed
    result = json.loads(files["json"].read_text())
    assert result["error_validate"] < 1.15 * result["floor"]
    thesis = result["physics"]["H itself symmetric (thesis)"]
    assert thesis["error_validate"] > 2 * result["error_validate"]
    mat = loadmat(files["mat"])
    h = mat["C"] @ np.linalg.solve(S[0] * np.eye(len(mat["A"])) - mat["A"], mat["B"]) + mat["D"]
    by_ratio = np.polyval(mat["num"][0, 0], S[0]) / np.polyval(mat["den"].ravel(), S[0])
    assert h[0, 0] == pytest.approx(by_ratio, rel=1e-6)
    for picture in (files["png"], drawn):
        assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("words", "line"),
    [
        (["--start", "2:0.3,5:-0.1"], "the start is unstable: 5 Hz has damping ratio -0.1"),
        (["--order", "4", "--study", "colour=1"], 'a study cannot vary "colour"'),
        (["--json", "nowhere/x.json"], "there is no folder nowhere"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(words, line, capsys):
    assert main(["identify", str(CLEAN), *words]) == 2
    error = capsys.readouterr().err
    assert line in error and error.count("\n") == 1


def test_more_poles_than_any_band_holds_are_refused(capsys):
    with pytest.raises(SystemExit) as left:
        main(["identify", str(CLEAN), "--order", "400"])
    assert left.value.code == 2
    assert "400 poles: take at most 100" in capsys.readouterr().err


def test_more_poles_than_the_runs_need_are_said_to_be(tmp_path, capsys):
    file = tmp_path / "h.json"
    assert main(["identify", str(CLEAN), "--order", "8", "--json", str(file)]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "8 poles were asked for; the runs do not need more than 6" in printed
    (row,) = json.loads(file.read_text())["orders"]
    assert (row["order"], row["kept"]) == (8, 6) and row["bic"] > row["aicc"]


@pytest.mark.parametrize(("zeta", "remark"), [(0.4, ""), (0.99, ""), (1.4, "overdamped")])
def test_a_pair_of_real_poles_is_said_to_be_overdamped(zeta, remark, capsys, monkeypatch):
    """From a damping ratio of 1 on nothing oscillates."""
    table = [(5.0, 0.1, zeta, 0.01)]
    monkeypatch.setattr(TransferMatrix, "poles_table", lambda self: table)
    assert main(["identify", str(CLEAN), "--order", "4"]) == 0
    (row,) = [line for line in capsys.readouterr().out.splitlines() if "5.000" in line]
    assert row.split() == ["1", "5.000", "0.100", f"{zeta:.4f}", "0.0100", *remark.split()]


def test_frequency_responses_without_a_model(tmp_path, capsys):
    """The numbers, the same for MATLAB, and a picture."""
    files = [tmp_path / name for name in ("frf.json", "frf.mat", "frf.png")]
    options = [f"--{file.suffix[1:]}".replace("png", "figure") for file in files]
    arguments = [str(x) for pair in zip(options, files, strict=True) for x in pair]
    assert main(["identify", str(CLEAN), "--frf", "H1", *arguments]) == 0
    assert "coherence" in capsys.readouterr().out
    found = json.loads(files[0].read_text())
    matrix = np.array(found["real"]) + 1j * np.array(found["imag"])
    frequency, coherence = np.array(found["frequency_hz"]), np.array(found["coherence"])
    assert (found["inputs"], found["outputs"]) == (
        ["A1", "A2", "A3", "A4"], ["B1", "B2", "B3", "B4"],
    )  # fmt: skip
    assert ((coherence >= 0.0) & (coherence <= 1.0)).all() and frequency[-1] <= 30.0
    exported = loadmat(files[1])
    assert exported["H"].transpose(2, 0, 1) == pytest.approx(matrix)
    assert files[2].stat().st_size > 20_000


def test_a_dead_sensor_is_no_input(tmp_path, capsys):
    """Its noise would be taken for motion of the axle, and the body for moved by nothing."""
    folder, file = with_a_dead_axle(tmp_path / "c"), tmp_path / "x.json"
    assert main(["identify", str(folder), "--order", "6", "--json", str(file)]) == 0
    assert "left out: the channel A3" in capsys.readouterr().out
    assert json.loads(file.read_text())["inputs"] == ["A1", "A2", "A4"]


def test_frf_of_too_few_lines(capsys):
    assert main(["identify", str(CLEAN), "--frf", "H1", "--frf-lines", "4"]) == 2
    assert "odd number" in capsys.readouterr().err
