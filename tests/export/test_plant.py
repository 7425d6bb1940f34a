"""A car as a state space: against its frequency response, and with its laws closed by another
integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.io import loadmat

import wheelhop as wh
from tests.export.cars import FOLDER, ROUGH, ground, model, ours
from wheelhop.api.exporting import export
from wheelhop.campaign import CampaignError
from wheelhop.export.plant import longest_step, plant_of
from wheelhop.simulate import frequency_response


def test_the_linear_part_has_the_frequency_response_of_the_car():
    plant = plant_of(model(()))
    linear, frequency = plant.linear, np.array([0.7, 2.1, 9.8, 25.0])
    expected = frequency_response(plant.system, frequency)
    count = len(plant.corners)
    for f, truth in zip(frequency, expected, strict=True):
        s = 2j * np.pi * f
        through = np.linalg.solve(s * np.eye(len(linear.a)) - linear.a, linear.b)
        response = linear.c @ through + linear.d
        found = response[:, :count] + s * response[:, count : 2 * count]
        assert found == pytest.approx(truth[: len(found)], rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("effects", [ROUGH[1:], ROUGH[1:2]], ids=len)
def test_laws_closed_from_outside_make_the_whole_car(effects):
    """scipy integrates the linear part; the laws, without memory, are called at its outputs."""
    plant = plant_of(model(effects))
    linear, laws = plant.linear, plant.system.laws
    count, ports = len(plant.laws), len(plant.inputs)
    rows = linear.c[-2 * count :], linear.d[-2 * count :]

    def inputs(t, state):
        u = np.zeros(len(linear.inputs))
        height, rate = ground([t], plant.corners)[:2]
        u[: 2 * len(plant.corners)] = np.concatenate([height[0], rate[0]])
        x, v = np.split(rows[0] @ state + rows[1] @ u, 2)
        for i, one in enumerate(plant.system.port_law):
            u[ports + i] = laws[one](x[i], v[i], 0.0, 0.0, 0.0, linear.laws[i][1])[0]
        return u

    step_s, steps = 2e-4, 2500
    time_s, truth = ours(plant, step_s, steps)
    solved = solve_ivp(
        lambda t, state: linear.a @ state + linear.b @ inputs(t, state),
        (0.0, time_s[-1]), np.zeros(len(linear.a)), t_eval=time_s[1:-1], rtol=1e-8, atol=1e-10,
        max_step=1e-3,
    )  # fmt: skip
    states = dict(zip(plant.states, solved.y, strict=True))
    heave = truth[:, plant.outputs.index("body_heave_m")]
    assert states["heave_m"] == pytest.approx(heave, abs=1e-5 * np.abs(heave).max())
    travel = [i for i, name in enumerate(plant.outputs) if name.endswith("travel_m")]
    shown = (linear.c[travel] @ solved.y).T
    assert shown == pytest.approx(truth[:, travel], abs=1e-5 * np.abs(truth[:, travel]).max())


def test_python_control_takes_it_by_its_names():
    control = pytest.importorskip("control")
    plant = wh.export(FOLDER / "clean/vehicle.toml", add="dry-friction")
    space = plant.linear.to_control()
    assert isinstance(space, control.StateSpace)
    assert "elastic_slip_1_force_N" in space.input_labels
    assert "elastic_slip_1_rate_m_s" in space.output_labels
    slowest, expected = (np.sort(np.abs(p)) for p in (space.poles(), plant.system.poles()))
    assert slowest == pytest.approx(expected, rel=1e-6)


def test_a_file_for_matlab_holds_matrices_names_and_laws(tmp_path):
    plant = export(FOLDER / "clean/vehicle.toml", tmp_path / "car.mat", ["dry-friction:front_N=73"])
    found = loadmat(tmp_path / "car.mat", squeeze_me=True)
    for name in "ABCD":
        assert np.array_equal(found[name], getattr(plant.linear, name.lower()))
    for name in ("states", "inputs", "outputs"):
        assert tuple(found[name]) == getattr(plant.linear, name)
    assert tuple(found["laws"]) == plant.laws and found["law_numbers"][0, 0] == 73.0


def test_what_no_port_can_hold_is_refused():
    with pytest.raises(CampaignError, match="upright"):
        export(FOLDER / "clean/vehicle.toml", add="driver-rocking")
    with pytest.raises(CampaignError, match="must end in"):
        export(FOLDER / "clean/vehicle.toml", "car.xyz")


def test_the_step_is_the_one_its_effects_ask_for():
    assert longest_step(model(())) == 0.0025
    assert longest_step(model(["dry-friction"])) == 0.00125
