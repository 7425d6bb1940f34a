"""A law that depends on a recorded input, a coil's voltage: what no motion alone tells."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.component import rig
from tests.component.test_simulate import (
    TIME_S,
    VALUES,
    answer,
    relative,
    rig_numbers,
    simulator,
)
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.cli.main import main
from wheelhop.diagnose import diagnose
from wheelhop.effects import load_effects
from wheelhop.law.formula import Formula
from wheelhop.law.places import Where
from wheelhop.law.terms import candidates
from wheelhop.simulate import Model
from wheelhop.vehicle import read_nominal


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Beside spring and damper 150 N of friction for every volt."""
    folder = tmp_path_factory.mktemp("coil") / "c"
    component = rig.Component(stiffness_N_m=20000.0, damping_N_s_m=1500.0)
    rig.make_campaign(folder, "displacement", component, seed=2, noise=0.005, only="random")
    for i, file in enumerate(sorted((folder / "runs").iterdir())):
        time_s, x, force = np.loadtxt(file, delimiter=",", skiprows=1).T
        volts = 1.0 + np.sin(2 * np.pi * (0.3 + 0.05 * i) * time_s + i)
        force = force + 150.0 * volts * np.tanh(np.gradient(x, time_s) / 0.03)
        table = np.stack([time_s, x, force, volts], axis=1)
        header = "time_s,displacement_m,force_N,input_coil_V"
        np.savetxt(file, table, fmt="%.9g", delimiter=",", header=header, comments="")
    return folder


def test_the_formula_names_the_input_and_its_file_serves_a_diagnosis(folder, tmp_path, capsys):
    kept, result = tmp_path / "my_law.py", tmp_path / "result.json"
    assert main(["law", str(folder), "--save", str(kept)]) == 0
    assert "times input_coil_V" in capsys.readouterr().out
    arguments = ["diagnose", str(folder), "--effects", str(kept), "--json", str(result)]
    assert main([*arguments, "--jobs", "1"]) == 0
    assert '"verdict": [\n    "found-law"' in result.read_text()


def test_an_mr_damper_is_named_by_what_its_coil_does(folder):
    """Its yield force per volt; of the rate the force here follows differences of samples, which
    are a little less than it."""
    campaign = read_campaign(folder)
    library = {"mr-damper": load_effects()["mr-damper"]}
    found = diagnose(campaign, read_nominal(campaign), library, jobs=1, max_effects=1)
    assert found.verdict[0] == "mr-damper"
    parameters = found.ladder[-1].parameters
    assert parameters["mr-damper.input_coil_V_N"][0] == pytest.approx(150.0, rel=0.03)
    assert parameters["mr-damper.creep_m_s"][0] == pytest.approx(0.03, rel=0.12)
    assert abs(parameters["mr-damper.strut_N"][0]) < 5.0
    assert found.ladder[-1].over_floor < 0.1 * found.ladder[0].over_floor


def test_under_a_force_the_input_acts_at_every_moment():
    def force(t):
        return 150.0 * np.sin(2 * np.pi * 8.0 * t) + 60.0 * np.sin(2 * np.pi * 3.1 * t)

    def volts(t):
        return 1.0 + np.sin(2 * np.pi * 0.7 * t)

    def rates(t, state):
        x, v = state
        own = 20000.0 * x + 120.0 * v + 40.0 * volts(t) * np.tanh(v / 0.1)
        return v, (force(t) - own) / 5.0

    solved = solve_ivp(rates, (0.0, TIME_S[-1]), (0.0, 0.0), t_eval=TIME_S, rtol=1e-9, atol=1e-12)
    of = simulator("force", solved.y[0], force(TIME_S))
    of.run = replace(of.run, inputs={"input_coil_V": volts(TIME_S)})
    every = candidates(np.array([-1.0, 1.0]), np.array([-0.1, 0.1]), of.run.inputs)
    term = next(t for t in every if t.by and t.shape == (0.1,) and "friction" in t.words)
    formula = Formula(Where("component", "strut", (0,)), [term])
    values = VALUES | rig_numbers(0.01) | {"rig.input_coil_V": 2.0, f"formula.{term.name}_N": 40.0}
    assert relative(answer(of, Model(values, (formula,))), solved.y[0]) < 1e-3


def test_an_input_belongs_into_all_recordings(tmp_path):
    component = rig.Component()
    other = rig.make_campaign(tmp_path / "c", "displacement", component, seed=2, noise=0.01)
    file = sorted((other / "runs").iterdir())[1]
    lines = file.read_text().splitlines()
    extended = [lines[0] + ",input_oil_degC", *(f"{line},20" for line in lines[1:])]
    file.write_text("\n".join(extended) + "\n")
    with pytest.raises(CampaignError, match="input_oil_degC is a column of some recordings only"):
        read_campaign(other)
