"""The full car on a frame that bends, beside the same car with all of the frame's elements."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from tests.frame.frames import CORNERS, STEEL, TUBE, ladder
from tests.truth import PRESETS
from wheelhop.campaign import Channel
from wheelhop.effects import load_effects
from wheelhop.files import InputError
from wheelhop.frame import (
    Material,
    PointMass,
    assemble,
    dofs_of,
    frame_twist,
    free_modes,
    read_frame,
    torsional_stiffness,
)
from wheelhop.simulate import Model, frequency_response
from wheelhop.vehicle import baseline, car_on_frame, frame_values, read_vehicle
from wheelhop.vehicle.layout import body_inertia

BODY = [Channel(name, name) for name in ("B1", "B2", "B3", "B4")]
MASSES = [PointMass(c, 35.0) for c in CORNERS] + [PointMass("ML", 40.0), PointMass("MR", 40.0)]
FREQUENCIES = (0.5, 3.0, 8.0, 14.0, 25.0)


def frame_of(material=STEEL):
    return assemble(ladder(material, masses=MASSES, width=1.1))


def values_of(elements):
    size = {"geometry.wheelbase_m": 1.4, "geometry.track_width_m": 1.1}
    return {**PRESETS["atv"].vehicle, **size, **frame_values(elements)}


def suspension_N_m(values, end, omega):
    return (
        values[f"suspension.{end}.stiffness_N_m"]
        + 1j * omega * values[f"suspension.{end}.damping_N_s_m"]
    )


def whole(elements, values, frequency_hz):
    """Accelerations of the corners per ground motion, (4, 4): every element, four wheels."""
    omega = 2 * np.pi * frequency_hz
    size = elements.mass.shape[0]
    corners = dofs_of(elements.corners, (2,))
    tyre_force = np.zeros((size + 4, 4), dtype=complex)
    link = sparse.lil_matrix((size + 4, size + 4), dtype=complex)
    for i, corner in enumerate(corners):
        end = ("front", "rear")[i // 2]
        spring = suspension_N_m(values, end, omega)
        tyre = values[f"wheel.{end}.tyre_stiffness_N_m"]
        tyre = tyre + 1j * omega * values[f"wheel.{end}.tyre_damping_N_s_m"]
        wheel = size + i
        link[corner, corner] += spring
        link[corner, wheel] -= spring
        link[wheel, corner] -= spring
        link[wheel, wheel] += spring + tyre - omega**2 * values[f"wheel.{end}.unsprung_mass_kg"]
        tyre_force[wheel, i] = tyre
    frame = elements.stiffness - omega**2 * elements.mass
    dynamic = sparse.block_diag([frame, sparse.csc_matrix((4, 4))]) + link
    return -(omega**2) * spsolve(dynamic.tocsc(), tyre_force)[corners]


def test_it_answers_as_the_car_with_every_element_of_the_frame():
    elements = frame_of()
    values = values_of(elements)
    system = car_on_frame(values, elements, BODY, "road", zeta=0.0)
    for frequency in FREQUENCIES:
        wanted = whole(elements, values, frequency)
        found = frequency_response(system, frequency)[0]
        assert found == pytest.approx(wanted, abs=1e-4 * np.abs(wanted).max()), frequency


def test_a_stiff_frame_is_the_rigid_car_and_a_soft_one_is_not():
    hard = Material(1e5 * STEEL.young_Pa, 1e5 * STEEL.shear_Pa, STEEL.density_kg_m3)
    off = []
    for material in (hard, STEEL):
        elements = frame_of(material)
        values = values_of(elements)
        rigid = baseline(values, BODY, "road").system(body_inertia(values))
        one, two = (
            frequency_response(system, FREQUENCIES)
            for system in (rigid, car_on_frame(values, elements, BODY, "road"))
        )
        off.append(np.abs(one - two).max() / np.abs(one).max())
    assert off[0] < 1e-3 < 0.05 < off[1]


def test_it_is_reciprocal_and_loses_energy():
    """With the axles driven, H over the suspensions' dynamic stiffness is symmetric, and no corner
    gives back more than it takes."""
    elements = frame_of()
    values = values_of(elements)
    system = car_on_frame(values, elements, BODY, "axles")
    for frequency in FREQUENCIES:
        omega = 2 * np.pi * frequency
        driven = [suspension_N_m(values, end, omega) for end in ("front", "front", "rear", "rear")]
        receptance = frequency_response(system, frequency)[0] / driven / -(omega**2)
        assert receptance == pytest.approx(receptance.T, rel=1e-9, abs=1e-15)
        loss = -(receptance - receptance.conj().T) / 2j
        assert np.linalg.eigvalsh(loss).min() > 0
    assert system.poles().real.max() < 1e-6
    for matrix in (system.mass, system.stiffness, system.damping):
        assert matrix == pytest.approx(matrix.T, rel=1e-12)
        assert np.linalg.eigvalsh(matrix).min() > -1e-9 * np.abs(matrix).max()


def test_a_twisted_road_twists_the_frame_by_its_torsional_stiffness():
    """Standing on a warped road: springs, tyres and frame in series."""
    elements = frame_of()
    values = values_of(elements)
    system = car_on_frame(values, elements, BODY, "road")
    warp = np.array([1.0, -1.0, -1.0, 1.0])
    body = system.output @ np.linalg.solve(system.stiffness, system.input_stiffness @ warp)
    # Corner heights (a, −a, −b, b) on a road (1, −1, −1, 1): the least of
    # f (1 − a)² + r (1 − b)² + k (a + b)² / 2h², h half the track.
    frame = torsional_stiffness(elements) / (values["geometry.track_width_m"] / 2) ** 2 / 2
    front, rear = (
        1
        / (
            1 / values[f"suspension.{end}.stiffness_N_m"]
            + 1 / values[f"wheel.{end}.tyre_stiffness_N_m"]
        )
        for end in ("front", "rear")
    )
    heights = np.linalg.solve([[front + frame, frame], [frame, rear + frame]], [front, rear])
    assert body == pytest.approx(np.repeat(heights, 2) * warp, rel=1e-5)


def test_frame_values_are_those_of_the_frame():
    elements = frame_of()
    found = frame_values(elements)
    assert found["geometry.cg_to_front_axle_m"] == pytest.approx(0.7)
    tubes = (2 * 1.4 + 3 * 1.1) * STEEL.density_kg_m3 * TUBE.area_m2
    assert found["body.mass_kg"] == pytest.approx(220.0 + tubes)


def test_the_effect_frame_twist_with_the_frames_parameters_twists_as_that_car():
    """On a warped road. The car's front is as its rear, so that the frame's other modes, which the
    effect does not have, take no part."""
    elements = frame_of()
    values = values_of(elements)
    values |= {k.replace("rear", "front"): v for k, v in values.items() if ".rear." in k}
    twist = frame_twist(elements, free_modes(elements, 10))
    theta = {
        "freq_hz": twist.freq_hz[twist.first],
        "participation_1_kg": twist.participation_1_kg[twist.first],
        "zeta": 0.02,
    }
    parts = baseline(values, BODY, "road")
    load_effects()["frame-twist"].modify(theta, values, parts)
    effect = parts.system(body_inertia(values))
    car = car_on_frame(values, elements, BODY, "road")
    warp = np.array([1.0, -1.0, -1.0, 1.0])
    one, other = (frequency_response(system, FREQUENCIES) @ warp for system in (effect, car))
    assert one == pytest.approx(other, abs=1e-3 * np.abs(other).max())


def test_vehicle_toml_names_a_frame_and_the_car_bends_as_it_does(tmp_path):
    shutil.copy("examples/frame/baja.toml", tmp_path / "frame.toml")
    text = Path("examples/clean/vehicle.toml").read_text(encoding="utf-8")
    file = tmp_path / "vehicle.toml"
    responses = []
    for modes in (2, 10, 20):
        named = f'\n[frame]\nfile = "frame.toml"\nmodes = {modes}\ndamping_ratio = 0.03\n'
        file.write_text(text + named, encoding="utf-8")
        vehicle = read_vehicle(file)
        system = Model(vehicle.values).system(BODY, "road")
        responses.append(frequency_response(system, FREQUENCIES))
    elements = assemble(read_frame(tmp_path / "frame.toml"))
    rigid = read_vehicle(Path("examples/clean/vehicle.toml")).values
    bending = car_on_frame(rigid, elements, BODY, "road", zeta=0.03)
    wanted = frequency_response(bending, FREQUENCIES)
    off = [np.abs(found - wanted).max() / np.abs(wanted).max() for found in responses]
    assert off[2] < off[1] < off[0]
    assert off[1] < 0.02
    assert off[2] < 0.005
    assert all(vehicle.uncertainty[key] == 0.0 for key in vehicle.values if "frame." in key)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('file = "frame.toml"\nmodes = 2.5', "modes = 2.5 must be a whole number"),
        ('file = "frame.toml"\nmodes = 0', "modes = 0 must not be below 1"),
        ('file = "frame.toml"\nzeta = 0.1', "unknown key"),
        ('file = "other.toml"', "other.toml"),
    ],
)
def test_a_mistake_in_the_frame_is_a_line(tmp_path, table, said):
    shutil.copy("examples/frame/baja.toml", tmp_path / "frame.toml")
    text = Path("examples/clean/vehicle.toml").read_text(encoding="utf-8")
    (tmp_path / "vehicle.toml").write_text(f"{text}\n[frame]\n{table}\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        read_vehicle(tmp_path / "vehicle.toml")
    assert said in str(error.value)
    assert "\n" not in str(error.value)
