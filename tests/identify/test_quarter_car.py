"""Loops closed in state space are the thesis's formulas; reduction is that of other programs."""

import control
import numpy as np
import pytest

from wheelhop.identify import (
    Car,
    Struts,
    Wheels,
    balanced_reduction,
    compliance,
    on_wheels,
    other_suspensions,
    study,
    wheel_hop_hz,
)
from wheelhop.identify.equivalent import EquivalentVehicle, equivalent_vehicle, ground_to_body
from wheelhop.identify.published import (
    H_RED,
    TABLE_2_2,
    TABLE_2_4,
    TABLE_5_3,
    TABLE_5_4,
)
from wheelhop.identify.statespace import StateSpace
from wheelhop.identify.synthetic import thesis_matrix
from wheelhop.identify.thesis_cars import racing_car, stiffened
from wheelhop.report.transfer_figures import draw_thesis

OLD, NEW = Struts(*TABLE_5_4["old"]), Struts(*TABLE_5_4["new"])
WHEELS = Wheels(*zip(TABLE_5_3["front"], TABLE_5_3["rear"], strict=True))
POINTS = 2j * np.pi * np.array([0.01, 1.0, 3.0, 10.0, 25.0])
EYE = np.eye(4)
RACING = EquivalentVehicle(0.45, 0.4, 0.4, 4.0, 60.0, 0.05).body()


def force_per_motion(struts, s):
    return np.diag(struts.stiffness + s * struts.damping)


def test_chapter_5_by_states_is_chapter_5_by_matrices():
    """5.16, 5.21 and 5.23, the last with chapter 2's sign of B."""
    body = compliance(thesis_matrix(), OLD)
    free, ground = other_suspensions(body, OLD, NEW), on_wheels(body, OLD, NEW, WHEELS)
    assert ground.order == 44
    m, kt, ct = (np.repeat(pair, 2) for pair in vars(WHEELS).values())
    for s in POINTS:
        h = thesis_matrix()(s)[0]
        h_b = h @ np.linalg.inv(EYE - h) @ np.linalg.inv(force_per_motion(OLD, s))
        d_n = force_per_motion(NEW, s)
        h_f = EYE - np.linalg.inv(EYE + h_b @ d_n)
        wheel = np.linalg.inv(np.diag(m * s**2 + kt + ct * s) + d_n)
        h_n = np.linalg.inv(EYE - h_f @ wheel @ d_n) @ h_f @ wheel @ np.diag(kt + ct * s)
        assert free(s)[0] == pytest.approx(h_f, rel=1e-8, abs=1e-10)
        assert ground(s)[0] == pytest.approx(h_n, rel=1e-8, abs=1e-10)


def test_chapter_2_by_states_is_chapter_2_by_matrices():
    """2.18: forces in, struts changed."""
    old, new = (Struts(*TABLE_2_2[key]) for key in ("old", "new"))
    moved = other_suspensions(RACING, old, new)
    for s in POINTS:
        d_o, d_n = force_per_motion(old, s), force_per_motion(new, s)
        wanted = np.linalg.inv(np.linalg.inv(RACING(s)[0]) - d_o + d_n) @ d_n
        assert moved(s)[0] == pytest.approx(wanted, rel=1e-8, abs=1e-10)


def test_the_old_suspensions_give_back_what_was_identified():
    again = other_suspensions(compliance(thesis_matrix(), OLD), OLD, OLD)
    assert again(POINTS) == pytest.approx(thesis_matrix()(POINTS), rel=1e-8, abs=1e-10)


def test_a_stiff_tyre_under_a_light_wheel_is_no_wheel():
    old = Struts(*TABLE_2_2["old"])
    stiff = on_wheels(RACING, old, old, Wheels((1e-3, 1e-3), (1e9, 1e9), (0.0, 0.0)))
    bare = other_suspensions(RACING, old, old)
    assert stiff(POINTS) == pytest.approx(bare(POINTS), rel=1e-3, abs=1e-4)


def test_raising_the_ground_raises_the_body():
    """The published H_n,11(0) is -0.53; a rigid body follows any plane."""
    assert on_wheels(compliance(thesis_matrix(), OLD), OLD, NEW, WHEELS).static()[0, 0] > 0
    static = ground_to_body(RACING).static()
    assert static.sum(axis=1) == pytest.approx(np.ones(4), abs=1e-9)


def test_wheel_hop_of_a_body_held_still_is_table_2_4():
    for mass, printed, _ in TABLE_2_4:
        assert wheel_hop_hz(mass, 250e3, 23.6e3) == pytest.approx(printed, abs=0.05)


def random_system(order, seed):
    rng = np.random.default_rng(seed)
    a = rng.standard_normal((order, order))
    a -= (np.linalg.eigvals(a).real.max() + 0.5) * np.eye(order)
    return StateSpace(
        a, rng.standard_normal((order, 2)), rng.standard_normal((2, order)), np.zeros((2, 2))
    )


@pytest.mark.parametrize("seed", range(4))
def test_reduction_is_that_of_pymor(seed):
    """Hankel singular values, and the truncated states' error bound 2 Σ σ."""
    from pymor.models.iosys import LTIModel

    system = random_system(12, seed)
    reduced, hankel = balanced_reduction(system, 5)
    model = LTIModel.from_matrices(system.a, system.b, system.c, system.d)
    assert hankel == pytest.approx(model.hsv(), rel=1e-6)
    gap = np.abs(np.linalg.svd(reduced(POINTS) - system(POINTS), compute_uv=False)).max()
    assert gap <= 2 * hankel[5:].sum() * (1 + 1e-9)


def test_static_response_is_kept_as_python_control_does_in_matchdc():
    system = random_system(8, 7)
    balanced, _ = balanced_reduction(system, 8)
    theirs = control.modred(
        control.ss(balanced.a, balanced.b, balanced.c, balanced.d), [5, 6, 7], method="matchdc"
    )
    reduced, _ = balanced_reduction(system, 5)
    assert reduced.static() == pytest.approx(system.static(), rel=1e-8)
    for s in POINTS:
        assert reduced(s)[0] == pytest.approx(theirs(s), rel=1e-6, abs=1e-9)


def test_order_44_is_reduced_where_polynomials_fail():
    ground = on_wheels(compliance(thesis_matrix(), OLD), OLD, NEW, WHEELS).part(0, 0)
    reduced, _ = balanced_reduction(ground, 8)
    whole = ground(POINTS)[:, 0, 0]
    assert np.abs(reduced(POINTS)[:, 0, 0] - whole).max() < 0.02 * np.abs(whole).max()
    # The printed H_red has the same modes, its coefficients rounded to two digits.
    ours, theirs = (np.sort(np.abs(p[p.imag > 0])) for p in (reduced.poles(), np.roots(H_RED[1])))
    assert ours == pytest.approx(theirs, rel=0.04)
    polynomial = np.poly(ground.poles())
    assert np.abs(np.roots(polynomial) - ground.poles()).max() > 0.1  # what this spares


def test_a_reduction_that_cannot_be_says_so():
    with pytest.raises(ValueError, match="give 1 or more"):
        balanced_reduction(random_system(4, 1), 0)
    growing = StateSpace(np.eye(2), np.ones((2, 1)), np.ones((1, 2)), np.zeros((1, 1)))
    with pytest.raises(ValueError, match="decays"):
        balanced_reduction(growing, 1)


def test_the_equivalent_vehicle_reproduces_what_it_was_fitted_to():
    static = ground_to_body(equivalent_vehicle().body()).static()[0, 0]
    assert static == pytest.approx(4.1 / 5.4, abs=0.005)


def test_what_the_thesis_says_of_its_figures_holds():
    """2.10.1: a stiffer front rises higher in a step and at rest; damping leaves rest alone and
    takes the peak down."""
    time_s, car = np.arange(0, 4.0, 0.004), racing_car()
    stiff = study(car, "front-stiffness", (1.0, 1.25, 1.5))
    static = [v.static for v in stiff]
    assert static == sorted(static) and static[-1] == pytest.approx(0.8, abs=0.01)
    overshoot = [v.step(time_s).max() / v.static for v in stiff]
    assert overshoot == sorted(overshoot)
    omega = np.geomspace(3, 60, 300)
    for what in ("front-damping", "rear-damping"):
        damped = study(car, what, (1.0, 1.5, 2.0))
        assert [v.static for v in damped] == pytest.approx([static[0]] * 3, abs=1e-9)
        peaks = [np.abs(v.system(1j * omega)).max() for v in damped]
        assert peaks == sorted(peaks, reverse=True)


def test_figure_5_24_stiffer_springs_let_more_through():
    """Both suspensions 20 % stiffer, dampers as they were: H_n,11 and H_n,33 peak higher, and at
    rest the body follows the wheel more."""
    omega = 2 * np.pi * np.linspace(0.5, 6, 300)
    for end in stiffened().values():
        soft, hard = (np.abs(v.system(1j * omega)).max() for v in end)
        assert hard > 1.05 * soft
        assert end[1].static > end[0].static > 0


def test_both_ends_are_varied_together():
    """Table 5.4: "stiffness" by 1.2 makes the new suspensions of the old."""
    car = Car(compliance(thesis_matrix(), OLD), OLD, WHEELS, np.eye(4))
    stiffer = car.varied("stiffness", 1.2).ground_to_body()
    assert stiffer(POINTS) == pytest.approx(on_wheels(car.body, OLD, NEW, WHEELS)(POINTS))
    light = car.varied("unsprung-mass", 0.5).ground_to_body()
    halved = Wheels((7.5, 6.25), WHEELS.stiffness_N_m, WHEELS.damping_N_s_m)
    assert light(POINTS) == pytest.approx(on_wheels(car.body, OLD, OLD, halved)(POINTS))
    rear = car.varied("rear-tyre", 2.0).ground_to_body()
    tyres = Wheels(WHEELS.mass_kg, (40e3, 80e3), WHEELS.damping_N_s_m)
    assert rear(POINTS) == pytest.approx(on_wheels(car.body, OLD, OLD, tyres)(POINTS))


def test_figures_are_drawn(tmp_path):
    drawn = draw_thesis(tmp_path / "figures")
    assert [p.read_bytes()[:4] for p in drawn] == [b"\x89PNG"] * 6
