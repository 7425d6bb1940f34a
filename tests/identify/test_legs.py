"""What stands between ground and body: bushings, second masses, half cars (thesis 2.12)."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.identify import (
    Bushings,
    Car,
    Part,
    Struts,
    Wheels,
    compliance,
    on_wheels,
    rigid_inertia,
    study,
)
from wheelhop.identify.published import TABLE_5_3, TABLE_5_4
from wheelhop.identify.statespace import StateSpace
from wheelhop.identify.synthetic import thesis_matrix
from wheelhop.material import approximate, read_specimen
from wheelhop.material.rational import Elements

OLD, NEW = Struts(*TABLE_5_4["old"]), Struts(*TABLE_5_4["new"])
WHEELS = Wheels(*zip(TABLE_5_3["front"], TABLE_5_3["rear"], strict=True))
BODY = compliance(thesis_matrix(), OLD)
POINTS = 2j * np.pi * np.array([0.01, 1.0, 3.0, 10.0, 25.0])
RUBBER = Elements(60e3, 40.0, np.array([20e3, 15e3]), np.array([0.1, 0.01]))
EXAMPLES = Path(__file__).parents[2] / "examples"


def ground_by_matrices(s, d_n, wheel_u, wheel_y):
    """(2.25) at one s: D_n and the wheels' T, F_t = −wheel_u U + wheel_y Y, as they may be."""
    old = np.diag(OLD.stiffness + s * OLD.damping)
    free = np.linalg.inv(np.linalg.inv(BODY(s)[0]) - old + d_n)
    wheel = np.linalg.inv(wheel_y + d_n)
    eye = np.eye(4)
    return np.linalg.solve(eye - free @ d_n @ wheel @ d_n, free @ d_n @ wheel @ wheel_u)


def of_wheels(s):
    m, kt, ct = (np.repeat(pair, 2) for pair in vars(WHEELS).values())
    return np.diag(kt + ct * s), np.diag(m * s**2 + kt + ct * s)


def test_a_bushing_in_line_makes_d_n_what_two_in_line_are():
    """D M / (D + M) in (2.16), with M of the specimen."""
    ground = on_wheels(BODY, OLD, NEW, WHEELS, Bushings(RUBBER, (1.0, 2.0)))
    for s in POINTS:
        strut = NEW.stiffness + s * NEW.damping
        rubber = RUBBER.modulus(np.array([s.imag]))[0] * np.array([1.0, 1.0, 2.0, 2.0])
        d_n = np.diag(strut * rubber / (strut + rubber))
        wanted = ground_by_matrices(s, d_n, *of_wheels(s))
        assert ground(s)[0] == pytest.approx(wanted, rel=1e-7, abs=1e-9)


def test_a_bushing_of_steel_is_none_and_a_soft_one_is_all():
    """Far stiffer than the strut it changes nothing; far softer the body hangs on it alone."""
    bare = on_wheels(BODY, OLD, NEW, WHEELS)(POINTS)
    steel = on_wheels(BODY, OLD, NEW, WHEELS, Bushings(RUBBER, (1e5, 1e5)))(POINTS)
    assert steel == pytest.approx(bare, rel=1e-3, abs=1e-5)
    rubber = replace(RUBBER, strengths_N_m=np.zeros(0), times_s=np.zeros(0))
    alone = Struts(600.0, 600.0, 0.4, 0.4)
    soft = on_wheels(BODY, OLD, replace(NEW, front_N_m=1e9, rear_N_m=1e9), WHEELS,
                     Bushings(rubber, (0.01, 0.01)))  # fmt: skip
    assert soft(POINTS) == pytest.approx(on_wheels(BODY, OLD, alone, WHEELS)(POINTS), rel=1e-4)


@pytest.mark.parametrize("on_ground", [False, True])
def test_a_second_mass_is_in_the_wheels_t(on_ground):
    """(2.19) of two masses: the middle one eliminated by hand."""
    part = Part((6.0, 4.0), (90e3, 70e3), (80.0, 60.0), on_ground)
    ground = on_wheels(BODY, OLD, NEW, WHEELS, None, part)
    m, kt, ct = (np.repeat(pair, 2) for pair in vars(WHEELS).values())
    m2, k2, c2 = (np.repeat(pair, 2) for pair in vars(part).values() if pair is not on_ground)
    for s in POINTS:
        tyre, spring = kt + ct * s, k2 + c2 * s
        if on_ground:
            belt = m2 * s**2 + spring + tyre
            from_u, from_y = tyre * spring / belt, m * s**2 + spring - spring**2 / belt
        else:
            hung = m2 * s**2 * spring / (m2 * s**2 + spring)
            from_u, from_y = tyre, m * s**2 + tyre + hung
        d_n = np.diag(NEW.stiffness + s * NEW.damping)
        wanted = ground_by_matrices(s, d_n, np.diag(from_u), np.diag(from_y))
        assert ground(s)[0] == pytest.approx(wanted, rel=1e-7, abs=1e-9)


def test_a_part_that_is_bolted_on_is_unsprung_mass():
    bolted = Part((6.0, 4.0), (1e9, 1e9), (1e4, 1e4))
    heavy = replace(WHEELS, mass_kg=tuple(np.add(WHEELS.mass_kg, bolted.mass_kg)))
    found = on_wheels(BODY, OLD, NEW, WHEELS, None, bolted)(POINTS)
    assert found == pytest.approx(on_wheels(BODY, OLD, NEW, heavy)(POINTS), rel=1e-3, abs=1e-6)


AHEAD, BEHIND, HALF_M, MASS, PITCH, ROLL = 0.7, 0.9, 0.6, 200.0, 70.0, 30.0


def rigid_car():
    """A rigid body on struts alike left and right, as chapter 2 has it: force to motion."""
    x, y = np.array([AHEAD, AHEAD, -BEHIND, -BEHIND]), np.array([1, -1, 1, -1]) * HALF_M
    shape = np.column_stack([np.ones(4), -x, y])
    k, c = (shape.T @ np.diag(values) @ shape for values in (OLD.stiffness, OLD.damping))
    inverse = np.diag(1 / np.array([MASS, PITCH, ROLL]))
    a = np.block([[np.zeros((3, 3)), np.eye(3)], [-inverse @ k, -inverse @ c]])
    b = np.vstack([np.zeros((3, 4)), inverse @ shape.T])
    system = StateSpace(a, b, np.hstack([shape, np.zeros((4, 3))]), np.zeros((4, 4)))
    places = np.column_stack([x, y])
    return Car(system, OLD, WHEELS, rigid_inertia(places, (MASS, PITCH, ROLL)))


def test_with_both_sides_alike_a_half_car_is_the_usual_one():
    """Left from left plus left from right: a beam of half the mass on two wheels."""
    car = rigid_car()
    half, whole = car.half_car("left"), car.ground_to_body()
    other = whole(POINTS)[:, [0, 2]][:, :, [1, 3]]
    m, kt, ct = (np.array(pair) for pair in vars(WHEELS).values())
    arm = np.column_stack([np.ones(2), [-AHEAD, BEHIND]])
    inertia = np.linalg.inv(arm).T @ np.diag([MASS / 2, PITCH / 2]) @ np.linalg.inv(arm)
    for i, s in enumerate(POINTS):
        strut = np.diag(OLD.stiffness[[0, 2]] + s * OLD.damping[[0, 2]])
        tyre = np.diag(kt + ct * s)
        matrix = np.block([[inertia * s**2 + strut, -strut],
                           [-strut, np.diag(m) * s**2 + strut + tyre]])  # fmt: skip
        usual = np.linalg.solve(matrix, np.vstack([np.zeros((2, 2)), tyre]))[:2]
        assert half(s)[0] + other[i] == pytest.approx(usual, rel=1e-7, abs=1e-9)


def test_a_half_car_settles_where_the_usual_one_does_and_a_quarter_car_does_not():
    """Two grounds and two at rest are a plane, which a rigid body follows: 1. One ground warps the
    four, and the other three hold the body: less."""
    car = rigid_car()
    for which in ("left", "right", "front", "rear"):
        assert car.half_car(which).static().sum(axis=1) == pytest.approx([1.0, 1.0])
    assert car.ground_to_body().static()[0, 0] < 0.95


def test_a_bushing_is_varied_and_softens_what_the_body_feels():
    car = replace(rigid_car(), bushings=Bushings(RUBBER))
    soft, hard = study(car, "bushing", (0.5, 50.0))
    s = 2j * np.pi * np.array([20.0])
    assert np.abs(soft.system(s)).item() < 0.8 * np.abs(hard.system(s)).item()
    front, rear = (car.varied(f"{end}-bushing", 3.0).bushings.factor for end in ("front", "rear"))
    assert (front, rear) == ((3.0, 1.0), (1.0, 3.0))
    with pytest.raises(CampaignError, match="--bushing"):
        study(rigid_car(), "bushing", (1.0,))
    dry = Bushings(replace(RUBBER, damping_N_s_m=0.0))
    with pytest.raises(CampaignError, match="needs damping"):
        study(replace(car, struts=Struts(1e4, 1e4, 0.0, 0.0), bushings=dry), "bushing", (1.0,))


def test_hops_of_a_hung_hub_motor_are_two_to_a_wheel():
    """A motor of 6 kg tuned to the hop of its wheel splits it, as an absorber does."""
    car = rigid_car()
    (one, *_) = car.wheel_hops("front")
    omega = 2 * np.pi * one.frequency_hz
    part = Part((6.0, 6.0), (6 * omega**2,) * 2, (20.0, 20.0))
    hops = [hop.frequency_hz for hop in replace(car, part=part).wheel_hops("front")]
    assert min(hops) < 0.9 * one.frequency_hz and max(hops) > 1.1 * one.frequency_hz


def test_the_command_puts_a_specimen_in_line_and_prints_a_half_car(tmp_path, capsys):
    data = EXAMPLES / "bushings/bushing-1-specimen-1.csv"
    assert main(["bushing", "fit", str(data), "--out", str(tmp_path)]) == 0
    (specimen,) = tmp_path.glob("*.toml")
    assert approximate(read_specimen(specimen).modulus).stiffness_N_m > 5e5
    alone = ["identify", str(EXAMPLES / "clean"), "--bushing", str(specimen)]
    assert main(alone) == 2 and "--half-car" in capsys.readouterr().err
    words = ["--order", "6", "--study", "bushing=0.01,1", "--bushing", str(specimen)]
    assert main(["identify", str(EXAMPLES / "clean"), *words, "--half-car", "left"]) == 0
    said = capsys.readouterr().out
    assert "generalized half car, left" in said and "bushing varied" in said
