"""One beam: static deflections and frequencies of textbooks."""

import numpy as np
import pytest

from tests.frame.frames import STEEL, TUBE, chain, rigid_in_shear
from wheelhop.frame import Section, dofs_of, free_modes, round_tube, solve_static
from wheelhop.frame.beam import Beams, element_matrices
from wheelhop.frame.modes import held_modes

LENGTH = 1.3
E, G, RHO = STEEL.young_Pa, STEEL.shear_Pa, STEEL.density_kg_m3


def cantilever(section=TUBE, element_m=10.0, along=(1.0, 0.0, 0.0), up=None):
    return chain([(0, 0, 0), LENGTH * np.array(along)], section, element_m=element_m, up=up)


def tip_load(elements, direction):
    load = np.zeros(elements.mass.shape[0])
    load[dofs_of([1], [direction])] = 1.0
    return solve_static(elements, load, dofs_of([0]))


def test_a_round_tube_has_the_area_and_moments_of_a_ring():
    outer, inner = 0.030, 0.026
    assert TUBE.area_m2 == pytest.approx(np.pi * (outer**2 - inner**2) / 4)
    assert TUBE.Iy_m4 == TUBE.Iz_m4 == pytest.approx(np.pi * (outer**4 - inner**4) / 64)
    assert TUBE.J_m4 == pytest.approx(2 * TUBE.Iy_m4)


@pytest.mark.parametrize(
    ("wall_m", "kappa"), [(0.01, 6 * 1.3 / (7 + 6 * 0.3)), (1e-9, 2 * 1.3 / (4 + 3 * 0.3))]
)
def test_the_shear_coefficient_has_cowpers_limits_of_a_bar_and_a_thin_tube(wall_m, kappa):
    assert round_tube(0.02, wall_m, 0.3).shear_coefficient == pytest.approx(kappa, rel=1e-6)


@pytest.mark.parametrize("element_m", [10.0, 0.2])
def test_a_cantilever_bends_by_bending_and_by_shear(element_m):
    """PL³/3EI + PL/κGA, whatever the number of elements."""
    bending = LENGTH**3 / (3 * E * TUBE.Iy_m4)
    shear = LENGTH / (TUBE.shear_coefficient * G * TUBE.area_m2)
    for direction in (1, 2):
        found = tip_load(cantilever(element_m=element_m), direction).displacement
        assert found[6 + direction] == pytest.approx(bending + shear, rel=1e-9)


def test_a_cantilever_stretches_twists_and_tilts():
    elements = cantilever()
    assert tip_load(elements, 0).displacement[6] == pytest.approx(LENGTH / (E * TUBE.area_m2))
    assert tip_load(elements, 3).displacement[9] == pytest.approx(LENGTH / (G * TUBE.J_m4))
    slope = LENGTH**2 / (2 * E * TUBE.Iy_m4)
    assert tip_load(elements, 1).displacement[11] == pytest.approx(slope)
    assert tip_load(elements, 2).displacement[10] == pytest.approx(-slope)


def test_each_second_moment_resists_its_own_direction():
    flat = Section(4e-4, Iy_m4=2e-8, Iz_m4=9e-8, J_m4=1e-8, shear_coefficient=1e6)
    sideways, upward = (tip_load(cantilever(flat), d).displacement[6 + d] for d in (1, 2))
    assert sideways == pytest.approx(LENGTH**3 / (3 * E * 9e-8), rel=1e-5)
    assert upward == pytest.approx(LENGTH**3 / (3 * E * 2e-8), rel=1e-5)


def test_the_section_of_an_upright_tube_points_ahead_and_any_can_be_turned():
    flat = Section(4e-4, Iy_m4=2e-8, Iz_m4=9e-8, J_m4=1e-8, shear_coefficient=1e6)
    upright = cantilever(flat, along=(0.0, 0.0, 1.0))
    ahead, sideways = (tip_load(upright, d).displacement[6 + d] for d in (0, 1))
    assert ahead == pytest.approx(LENGTH**3 / (3 * E * 2e-8), rel=1e-5)
    assert sideways == pytest.approx(LENGTH**3 / (3 * E * 9e-8), rel=1e-5)
    turned = cantilever(flat, up=(0.0, 1.0, 0.0))
    sideways, upward = (tip_load(turned, d).displacement[6 + d] for d in (1, 2))
    assert sideways == pytest.approx(ahead) and upward == pytest.approx(
        LENGTH**3 / (3 * E * 9e-8), rel=1e-5
    )


def test_reactions_balance_all_loads_those_on_the_supports_too():
    elements = cantilever(element_m=0.3)
    load = np.zeros(elements.mass.shape[0])
    load[dofs_of([0, 1], [2])] = 5.0, 1.0
    found = solve_static(elements, load, dofs_of([0]))
    assert found.reaction[:6] == pytest.approx([0, 0, -6, 0, LENGTH, 0], abs=1e-8)
    assert not found.reaction[6:].any()


def test_supports_that_leave_the_frame_loose_are_refused():
    elements = cantilever()
    with pytest.raises(ValueError, match="free to move"):
        solve_static(elements, np.zeros(12), dofs_of([0], (0, 1, 2)))


def test_the_consistent_mass_is_that_of_archer_without_shear():
    """ρAL/420 (156, 22L, 54, −13L; 4L², 13L, −3L²; …), and rotary inertia ρI/30L (36, 3L, …)."""
    one = np.ones(1)
    length, line, rotary = 0.7, 2.0, 0.3
    beams = Beams(length * one, one, one, one, one, 1e12 * one, line * one, 0 * one, rotary * one)
    found = element_matrices(beams)[1][0][np.ix_((1, 5, 7, 11), (1, 5, 7, 11))]
    a, b = length, length**2
    translation = np.array(
        [
            [156, 22 * a, 54, -13 * a],
            [22 * a, 4 * b, 13 * a, -3 * b],
            [54, 13 * a, 156, -22 * a],
            [-13 * a, -3 * b, -22 * a, 4 * b],
        ]
    )
    rotation = np.array(
        [
            [36, 3 * a, -36, 3 * a],
            [3 * a, 4 * b, -3 * a, -b],
            [-36, -3 * a, 36, -3 * a],
            [3 * a, -b, -3 * a, 4 * b],
        ]
    )
    wanted = line * length / 420 * translation + rotary / (30 * length) * rotation
    assert found == pytest.approx(wanted, rel=1e-6)


def euler_hz(beta_l, section=TUBE):
    """(βL)² √(EI/ρA) / 2πL²."""
    bending = np.sqrt(E * section.Iy_m4 / (RHO * section.area_m2))
    return np.asarray(beta_l) ** 2 * bending / (2 * np.pi * LENGTH**2)


def test_a_slender_cantilever_has_the_frequencies_of_textbooks():
    slim = rigid_in_shear(round_tube(0.004, 0.002, 0.3))
    elements = cantilever(slim, element_m=0.06)
    inner = slice(6, None)
    found = held_modes(elements.stiffness[inner, inner], elements.mass[inner, inner], 6)
    wanted = np.repeat(euler_hz([1.875104, 4.694091, 7.854757], slim), 2)
    assert found.frequency_hz == pytest.approx(wanted, rel=1e-4)


def test_a_slender_free_beam_has_the_frequencies_of_textbooks():
    slim = rigid_in_shear(round_tube(0.004, 0.002, 0.3))
    found = free_modes(cantilever(slim, element_m=0.05), 8)
    wanted = np.repeat(euler_hz([4.730041, 7.853205, 10.995608, 14.137165], slim), 2)
    assert found.frequency_hz == pytest.approx(wanted, rel=2e-4)


def test_torsion_and_stretching_of_a_free_beam():
    """n c / 2L with c = √(G/ρ) and √(E/ρ)."""
    short = chain([(0, 0, 0), (0.2, 0, 0)], element_m=0.005)
    found = free_modes(short, 14)
    turns = np.linalg.norm(found.shape[3::6], axis=0)
    moves = [np.linalg.norm(found.shape[i::6], axis=0) for i in range(3)]
    torsion = found.frequency_hz[turns > 10 * np.sqrt(sum(m**2 for m in moves))]
    stretch = found.frequency_hz[moves[0] > 10 * np.hypot(moves[1], moves[2])]
    assert torsion[:2] == pytest.approx(np.array([1, 2]) * np.sqrt(G / RHO) / 0.4, rel=2e-3)
    assert stretch[0] == pytest.approx(np.sqrt(E / RHO) / 0.4, rel=2e-3)


def timoshenko_pinned_hz(n, section, length):
    """S. Timoshenko, Phil. Mag. 41 (1921) 744, with r² = I/A and k = nπ/L:
    (ρr²/κG) ω⁴ − (1 + r²k² (1 + E/κG)) ω² + (E/ρ) r²k⁴ = 0, the lower root."""
    k = n * np.pi / length
    r2, modulus = section.Iy_m4 / section.area_m2, section.shear_coefficient * G
    squares = np.roots(
        [RHO * r2 / modulus, -1 - r2 * k**2 * (1 + E / modulus), E / RHO * r2 * k**4]
    )
    return np.sqrt(squares.min()) / (2 * np.pi)


@pytest.mark.parametrize(("n", "most"), [(1, 0.95), (2, 0.83), (3, 0.7)])
def test_a_stubby_beam_vibrates_as_timoshenko_says(n, most):
    """On pins; Euler and Bernoulli's beam is far too fast."""
    section, length = round_tube(0.06, 0.005, STEEL.poisson), 0.4
    elements = chain([(0, 0, 0), (length, 0, 0)], section, element_m=0.005)
    held = np.concatenate([dofs_of([0], (0, 1, 2, 3)), dofs_of([1], (1, 2))])
    free = np.setdiff1d(np.arange(elements.mass.shape[0]), held)
    found = held_modes(elements.stiffness[free][:, free], elements.mass[free][:, free], 14)
    wanted = timoshenko_pinned_hz(n, section, length)
    assert np.abs(found.frequency_hz / wanted - 1).min() < 1e-3
    euler = n**2 * np.pi / 2 * np.sqrt(E * section.Iy_m4 / (RHO * section.area_m2)) / length**2
    assert wanted < most * euler
