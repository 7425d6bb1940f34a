"""Modes, their energy and sensitivities, and transmissibility: closed forms, balances, scaling."""

import json
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from tests.truth import PRESETS
from tests.vehicle.test_aboard import BATTERY, SEAT
from tests.vehicle.test_layout import part_of
from wheelhop.campaign import CampaignError, Channel
from wheelhop.cli.main import main
from wheelhop.effects import load_effects
from wheelhop.predict.modal import modes, transmissibility
from wheelhop.report.modes import modes_figure
from wheelhop.simulate import Model, frequency_response
from wheelhop.vehicle import axle_name, static_tyre_load, wheels

ATV = dict(PRESETS["atv"].vehicle)
CAR = ATV | BATTERY | SEAT
VEHICLE = Path(__file__).parents[2] / "examples/clean/vehicle.toml"
HZ = np.geomspace(0.2, 40.0, 30)


def modes_of(values, **options):
    return modes(Model(values), "car", {}, **options)


def undamped(values):
    return {k: 0.0 if k.endswith("_N_s_m") else v for k, v in values.items()}


def test_a_quarter_car_s_frequencies_in_closed_form():
    values = undamped(part_of(ATV, "quarter-car"))
    m, mu = values["body.mass_kg"], values["wheel.front.unsprung_mass_kg"]
    k, kt = values["suspension.front.stiffness_N_m"], values["wheel.front.tyre_stiffness_N_m"]
    middle, product = (k / m + (k + kt) / mu) / 2, k * kt / (m * mu)
    squares = np.array(
        [middle - np.sqrt(middle**2 - product), middle + np.sqrt(middle**2 - product)]
    )
    found = modes_of(values)
    np.testing.assert_allclose(found.frequency_hz, np.sqrt(squares) / (2 * np.pi), rtol=1e-10)
    np.testing.assert_allclose(found.damping_ratio, 0.0, atol=1e-10)


@pytest.mark.parametrize("values", [part_of(ATV, "half-car"), CAR], ids=["half car", "mounts"])
def test_energies_are_shared_out_in_full(values):
    found = modes_of(values)
    for shares in (found.kinetic, found.strain, found.dissipated):
        np.testing.assert_allclose(shares.sum(axis=1), 1.0, atol=1e-6)
    assert found.strain.min() > -1e-9 and found.dissipated.min() > -1e-9


def test_without_damping_kinetic_and_strain_energy_are_equal():
    """Rayleigh: ω² xᵀMx = xᵀKx; what the numbers have of either adds up to the same."""
    values = undamped(CAR)
    found = modes_of(values)
    stiff = [i for i, name in enumerate(found.numbers) if name.endswith("stiffness_N_m")]
    heavy = [i for i, name in enumerate(found.numbers) if name.endswith(("_kg", "_kg_m2"))]
    np.testing.assert_allclose(found.frequency_by[:, stiff].sum(axis=1), 0.5, rtol=1e-6)
    np.testing.assert_allclose(found.frequency_by[:, heavy].sum(axis=1), -0.5, rtol=1e-6)
    np.testing.assert_allclose(found.frequency_by[:, stiff], found.strain[:, stiff] / 2, atol=1e-7)


def test_sensitivities_are_those_of_vehicles_that_differ():
    found = modes_of(CAR)
    for number in ("body.mass_kg", "suspension.rear.damping_N_s_m", "battery.x_m"):
        more, less = (modes_of(CAR | {number: CAR[number] * c}) for c in (1.0001, 0.9999))
        p = found.numbers.index(number)
        for mine, values in (
            (found.frequency_by, (less.frequency_hz, more.frequency_hz)),
            (found.damping_by, (less.damping_ratio, more.damping_ratio)),
        ):
            ratio = np.log(values[1] / values[0]) / np.log(1.0001 / 0.9999)
            np.testing.assert_allclose(mine[:, p], ratio, atol=1e-4)


def test_uncertain_numbers_make_uncertain_frequencies():
    values = undamped(part_of(ATV, "quarter-car"))
    springs = {k: 0.1 * v for k, v in values.items() if k.endswith("stiffness_N_m")}
    found = modes(Model(values), "car", springs)
    each = found.strain @ np.diag([n.endswith("stiffness_N_m") for n in found.numbers])
    expected = found.frequency_hz * 0.05 * np.sqrt((each**2).sum(axis=1))
    np.testing.assert_allclose(found.frequency_sd_hz, expected, rtol=1e-5)


def test_an_effect_s_mode_is_there_and_its_force_laws_are_not():
    library = load_effects()
    seat, friction = library["driver-seat"], library["dry-friction"]
    model = Model(ATV)
    for effect in (seat, friction):
        parameters = effect.parameters_for(ATV, ())
        model = model.with_effect(effect, parameters)
    model = model.with_values({"driver-seat.mass_kg": 60.0, "driver-seat.freq_hz": 4.0})
    found = modes(model, "car", {})
    assert found.left_out == ("dry-friction",)
    np.testing.assert_allclose(found.strain.sum(axis=1), 1.0, atol=1e-6)
    assert len(found.frequency_hz) == 8 and "driver" in found.coordinates


def test_transmissibility_is_the_response_to_ground_that_rises_evenly():
    model = Model(ATV)
    found = transmissibility(model, HZ)
    seat = Channel("seat", "body-xy", ATV["driver.x_m"], ATV["driver.y_m"])
    evenly = frequency_response(model.system([seat], "road"), HZ).sum(axis=2)[:, 0]
    ground = -((2 * np.pi * HZ) ** 2)
    np.testing.assert_allclose(found.driver, evenly / ground, rtol=1e-9)
    assert abs(transmissibility(model, 0.01).driver[0]) == pytest.approx(1.0, abs=1e-3)


@pytest.mark.parametrize("speed_m_s", [None, 4.0])
def test_tyres_push_with_what_accelerates_the_masses(speed_m_s):
    """Newton: the loads of all tyres together are mass times acceleration of all there is."""
    found = transmissibility(Model(CAR), HZ, speed_m_s)
    channels = [Channel(f"A{i + 1}", f"A{i + 1}") for i in range(4)]
    channels.append(Channel("c", "body-xy", 0.0, 0.0))
    system = Model(CAR).system(channels, "road")
    late = [
        0.0 if i < 2 or speed_m_s is None else CAR["geometry.wheelbase_m"] / speed_m_s
        for i in range(4)
    ]
    heights = np.exp(-2j * np.pi * HZ[:, None] * np.array(late))
    force = sum(found.tyre_load[axle_name(i)] * static_tyre_load(CAR, i) for i in wheels(CAR))
    omega = 2 * np.pi * HZ
    dynamic = system.stiffness - omega[:, None, None] ** 2 * system.mass
    dynamic = dynamic + 1j * omega[:, None, None] * system.damping
    driven = system.input_stiffness + 1j * omega[:, None, None] * system.input_damping
    moved = np.linalg.solve(dynamic, driven @ heights[:, :, None])[:, :, 0]
    rigid = np.array([name not in ("pitch", "roll") for name in system.coordinates], float)
    momentum = -(omega**2) * (moved @ system.mass @ rigid)
    np.testing.assert_allclose(force, momentum, rtol=1e-8, atol=1e-8)


def test_at_the_right_speed_front_and_rear_meet_the_same_wave():
    hertz = 5.0
    once = transmissibility(Model(ATV), hertz)
    again = transmissibility(Model(ATV), hertz, ATV["geometry.wheelbase_m"] * hertz)
    half = transmissibility(Model(ATV), hertz, 2 * ATV["geometry.wheelbase_m"] * hertz)
    assert again.driver == pytest.approx(once.driver)
    assert abs(half.driver[0]) < abs(once.driver[0])


def test_the_command_compares_vehicles(tmp_path, capsys):
    text = VEHICLE.read_text(encoding="utf-8")
    softer = tmp_path / "softer.toml"
    softer.write_text(text.replace("10500.0", "7000.0"), encoding="utf-8")
    out = [tmp_path / "modes.json", tmp_path / "modes.png", tmp_path / "rides.png"]
    words = [str(VEHICLE), str(softer), "--json", str(out[0]), "--figure", str(out[1])]
    assert main(["modes", *words]) == 0
    said = capsys.readouterr().out
    assert "softer" in said and "rear suspension" in said
    first, second = json.loads(out[0].read_text(encoding="utf-8"))["vehicles"]
    assert second["modes"][0]["frequency_hz"] < first["modes"][0]["frequency_hz"]
    drive = ["--tracks", "washboard/low", "--speed", "8", "--seconds", "2", "--figure", str(out[2])]
    assert main(["simulate", str(VEHICLE), "--against", str(softer), *drive]) == 0
    assert "softer" in capsys.readouterr().out
    assert all(file.stat().st_size > 1000 for file in out)


def test_no_two_names_of_modes_overlap():
    """Of a quad, alone and with its driver and battery on mounts, wheels of both ends hop alike."""
    figure = modes_figure([(modes_of(car), transmissibility(Model(car), HZ)) for car in (ATV, CAR)])
    figure.draw_without_rendering()
    boxes = [text.get_window_extent() for text in figure.axes[-1].texts]
    assert len(boxes) > 6
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--speed", "0"], "--speed 0: must be above 0"),
        (["--with", "frame-twits"], "did you mean 'frame-twist'"),
    ],
)
def test_what_cannot_be_asked_is_a_line(words, said, capsys):
    assert main(["modes", str(VEHICLE), *words]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


def test_what_does_not_stay_in_its_place_has_no_modes():
    with pytest.raises(CampaignError, match="not stable"):
        modes_of(ATV | {"suspension.front.stiffness_N_m": -5e4})
