"""Wheel hop is told by its shape: the wheels have more of the kinetic energy than the body."""

import re
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import Channel
from wheelhop.cli.main import main
from wheelhop.identify import Car, StateSpace, Struts, Wheels, rigid_inertia, study, wheel_hop_hz
from wheelhop.identify.published import TABLE_2_4
from wheelhop.identify.thesis_cars import racing_car
from wheelhop.predict.modal import modes
from wheelhop.predict.modal_words import by_place
from wheelhop.simulate import Model
from wheelhop.vehicle import body_inertia, corner_position, read_vehicle

CLEAN = Path(__file__).parents[2] / "examples/clean"
VALUES = read_vehicle(CLEAN / "vehicle.toml").values
BODY_POINTS = [Channel(name, name) for name in ("B1", "B2", "B3", "B4")]
ENDS = ("front", "rear")


def pairs(key):
    return tuple(VALUES[f"wheel.{end}.{key}"] for end in ENDS)


def physical_car():
    """The ATV with its rigid body as S, which no fit has touched."""
    held = Model(VALUES).system(BODY_POINTS, "axles")
    inverse, n = np.linalg.inv(held.mass), len(held.mass)
    a = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-inverse @ held.stiffness, -inverse @ held.damping]]
    )
    b = np.vstack([np.zeros((n, 4)), inverse @ held.output.T])
    c = np.hstack([held.output, np.zeros((4, n))])
    struts = [
        VALUES[f"suspension.{end}.{key}"]
        for key in ("stiffness_N_m", "damping_N_s_m")
        for end in ENDS
    ]
    positions = np.array([corner_position(VALUES, corner) for corner in range(4)])
    return Car(
        StateSpace(a, b, c, np.zeros((4, 4))),
        Struts(*struts),
        Wheels(pairs("unsprung_mass_kg"), pairs("tyre_stiffness_N_m"), pairs("tyre_damping_N_s_m")),
        rigid_inertia(positions, body_inertia(VALUES)),
    )


@pytest.mark.parametrize("factor", [0.2, 0.5, 1.0, 1.2, 1.5, 2.0, 3.0])
def test_wheel_hops_are_those_of_the_physical_model(factor):
    """Seven coordinates and their mass matrix say where the kinetic energy of a mode is."""
    damping = {f"suspension.{end}.damping_N_s_m": factor for end in ENDS}
    changed = {key: value * damping.get(key, 1.0) for key, value in VALUES.items()}
    found = modes(Model(changed), "", {})
    car = physical_car().varied("damping", factor)
    told = 0
    for end, other in (ENDS, ENDS[::-1]):
        truth = []
        for k in range(len(found.pole)):
            share = {end: by_place(found, k)[f"{end} wheels"] for end in ENDS}
            if sum(share.values()) > 0.5 and share[end] > share[other] and found.pole[k].imag > 0:
                truth.append([found.frequency_hz[k], found.damping_ratio[k]])
        ours = [[hop.frequency_hz, hop.damping_ratio] for hop in car.wheel_hops(end)]
        assert np.array(ours) == pytest.approx(np.array(truth), rel=1e-6)
        told += len(ours)
    assert told == {0.2: 4, 0.5: 4, 1.0: 3, 1.2: 3, 1.5: 2, 2.0: 1, 3.0: 0}[factor]


def test_under_a_body_that_stays_still_a_wheel_is_an_oscillator_of_its_own():
    """(2.27), with the damping ratio (C + Ct)/(2 √(m (K + Kt))); past 1 it is no oscillation."""
    heavy = 1e9 * np.eye(4)
    b = np.vstack([np.zeros((4, 4)), np.linalg.inv(heavy)])
    a = np.block([[np.zeros((4, 4)), np.eye(4)], [-1e-2 * np.eye(4), -0.2 * np.eye(4)]])
    body = StateSpace(a, b, np.eye(4, 8), np.zeros((4, 4)))
    wheels = Wheels((15.0, 12.5), (40e3, 40e3), (200.0, 200.0))
    car = Car(body, Struts(10.5e3, 6.5e3, 630.0, 590.0), wheels, heavy)
    for end, strut, damper, mass in (("front", 10.5e3, 630, 15.0), ("rear", 6.5e3, 590, 12.5)):
        critical = 2 * np.sqrt(mass * (40e3 + strut))
        hops = car.wheel_hops(end)
        assert len(hops) == 2
        for hop in hops:
            assert hop.frequency_hz == pytest.approx(wheel_hop_hz(mass, 40e3, strut), rel=1e-5)
            assert hop.damping_ratio == pytest.approx((damper + 200) / critical, rel=1e-5)
        to_critical = (critical - 200) / damper
        assert len(car.varied("damping", 0.99 * to_critical).wheel_hops(end)) == 2
        assert car.varied("damping", 1.01 * to_critical).wheel_hops(end) == ()


def test_a_study_of_the_front_tells_the_front_wheels_hop():
    """Chapter 2's car: with 56 kg in front the rear wheels are faster, and none of the study's."""
    factors = [mass / 45.0 for mass, *_ in TABLE_2_4]
    for variant, (mass, *_) in zip(
        study(racing_car(), "front-unsprung-mass", factors), TABLE_2_4, strict=True
    ):
        held_still = wheel_hop_hz(mass, 250e3, 23.6e3)
        for hop in variant.wheel_hops:
            assert 0.99 * held_still < hop.frequency_hz < held_still
        assert len(variant.wheel_hops) == 2
    rear = study(racing_car(), "front-unsprung-mass", factors, corner=2)
    for variant in rear:
        assert {round(hop.frequency_hz, 1) for hop in variant.wheel_hops} <= {12.4, 12.5}


def test_more_damping_does_not_make_a_body_mode_of_wheel_hop(capsys):
    """The ATV's roll, 5.56 Hz, was called wheel hop where that is damped by more than half."""
    study = ["--order", "6", "--study", "damping=1,1.2,3"]
    assert main(["identify", str(CLEAN), *study]) == 0
    printed = capsys.readouterr().out
    rows = [line.split() for line in printed.partition("varied")[2].splitlines()]
    hops = {row[0]: row[3:] for row in rows if row and row[0] in ("1", "1.2", "3")}
    assert hops["3"] == ["none", "oscillates"]
    for factor in ("1", "1.2"):
        hertz = [float(word) for word in hops[factor] if word[0] != "("]
        assert hertz == pytest.approx([8.9, 9.4], rel=0.05)
    assert "more kinetic energy in the wheels than in the body" in printed


def test_a_study_of_steps_wants_a_full_car(tmp_path, capsys):
    time_s = np.arange(40) * 0.05
    body = physical_car().body
    moved = body.step(time_s).reshape(len(time_s), 16)
    names = [f"B{point}/F{force}" for point in range(1, 5) for force in range(1, 5)]
    lines = [",".join(map(repr, row)) for row in np.column_stack([time_s, moved]).tolist()]
    (tmp_path / "steps.csv").write_text("\n".join([",".join(["time_s", *names]), *lines]))
    text = (CLEAN / "vehicle.toml").read_text()
    half = re.sub(r"(?m)^(roll_inertia_kg_m2|track_width_m|y_m) .*$", "", text)
    half = half.replace("format = 1", 'format = 1\nmodel = "half-car"', 1)
    (tmp_path / "half.toml").write_text(half)
    (tmp_path / "full.toml").write_text(text)
    words = ["identify", str(tmp_path / "steps.csv"), "--order", "6", "--study", "damping=1"]
    assert main([*words, "--vehicle", str(tmp_path / "full.toml")]) == 0
    hops = physical_car().wheel_hops("front")
    assert f"{hops[0].frequency_hz:.2f} ({hops[0].damping_ratio:.2f})" in capsys.readouterr().out
    assert main([*words, "--vehicle", str(tmp_path / "half.toml")]) == 2
    assert capsys.readouterr().err == (
        "wheelhop: a study needs a full car: leave `model` out of vehicle.toml\n"
    )
