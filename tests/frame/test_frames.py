"""Whole frames: rigid motions, reciprocity, another solver, published rings, reduction, twist."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import linalg

from tests.frame.frames import CORNERS, STEEL, TUBE, chain, ladder, random_frame, rigid_in_shear
from wheelhop.frame import (
    Material,
    PointMass,
    assemble,
    dofs_of,
    floating,
    frame_twist,
    free_modes,
    mass_properties,
    reduce,
    rigid_modes,
    rigid_motions,
    round_tube,
    solve_static,
    torsional_stiffness,
    warp,
)

seeds = st.integers(0, 2**32 - 1)
few = settings(max_examples=15, deadline=None)
DEGREE = np.pi / 180


@given(seed=seeds)
@few
def test_a_rigid_motion_strains_nothing_and_the_rest_is_positive(seed):
    elements = assemble(random_frame(seed))
    strain = elements.stiffness @ rigid_motions(elements.position)
    assert np.abs(strain).max() < 1e-9 * abs(elements.stiffness).max()
    squares = linalg.eigvalsh(elements.stiffness.toarray(), elements.mass.toarray())
    assert np.abs(squares[:6]).max() < 1e-6 * squares[6]
    rigid = rigid_modes(elements)
    assert rigid.T @ (elements.mass @ rigid) == pytest.approx(np.eye(6), abs=1e-9)


def test_mass_properties_are_those_of_rods_and_points():
    """Thin rods: mL²/12 about the middle; the rest by Steiner."""
    thin = round_tube(0.002, 0.001, 0.3)
    weights = [PointMass("MC", 2.0, (0.1, 0.0, 0.3)), PointMass("MC", 3.0, (0.0, 0.2, 0.0))]
    frame = ladder(section=thin, masses=weights, length=2.0, width=1.0)
    found = mass_properties(assemble(frame))
    line = STEEL.density_kg_m3 * thin.area_m2
    assert found.mass_kg == pytest.approx(7 * line + 5.0)
    assert found.centre_m == pytest.approx(np.zeros(3), abs=1e-12)
    roll = line * (3 * 1 / 12 + 2 * 2.0 * 0.25) + 0.1
    pitch = line * (2 * 8 / 12 + 2 * 1.0 * 1.0) + 0.2
    yaw = line * (3 * 1 / 12 + 2 * 2.0 * 0.25 + 2 * 8 / 12 + 2 * 1.0 * 1.0) + 0.3
    wanted = np.diag([roll, pitch, yaw])
    assert found.inertia_kg_m2 == pytest.approx(wanted, rel=1e-4, abs=1e-9)


@given(seed=seeds)
@few
def test_inertia_off_the_origin_is_that_of_the_points(seed):
    """Heavy points on light tubes, their products of inertia with the sign of a tensor."""
    random = np.random.default_rng(seed)
    light = Material(STEEL.young_Pa, STEEL.shear_Pa, 1e-6)
    points = random.uniform(-2, 2, (4, 3))
    kilos = random.uniform(1, 9, 4)
    frame = random_frame(seed, nodes=4, extra=2)
    nodes = dict(zip(frame.nodes, map(tuple, points), strict=True))
    masses = tuple(PointMass(n, float(m)) for n, m in zip(nodes, kilos, strict=True))
    frame = type(frame)(**{**vars(frame), "material": light, "nodes": nodes, "masses": masses})
    found = mass_properties(assemble(frame))
    centre = kilos @ points / kilos.sum()
    arm = points - centre
    wanted = (kilos * (arm**2).sum(axis=1)).sum() * np.eye(3) - (arm.T * kilos) @ arm
    assert found.centre_m == pytest.approx(centre, rel=1e-5, abs=1e-6)
    assert found.inertia_kg_m2 == pytest.approx(wanted, rel=1e-5, abs=1e-5)


@given(seed=seeds)
@few
def test_a_force_here_moves_there_as_a_force_there_moves_here(seed):
    random = np.random.default_rng(seed)
    elements = assemble(random_frame(seed, element_m=0.5))
    a, b = random.standard_normal((2, elements.mass.shape[0]))
    held = dofs_of([0])
    one, two = (solve_static(elements, load, held).displacement for load in (a, b))
    assert a @ two == pytest.approx(b @ one, rel=1e-8)
    flexibility = floating(elements)
    assert a @ flexibility(b) == pytest.approx(b @ flexibility(a), rel=1e-7)
    assert a @ flexibility(a) > 0


def test_statics_agree_with_another_program():
    """PyNite, Euler–Bernoulli's beams: three space frames under forces and moments."""
    from Pynite import FEModel3D

    section = rigid_in_shear(TUBE)
    for seed in range(3):
        frame = random_frame(seed, section=section)
        elements = assemble(frame)
        other = FEModel3D()
        other.add_material("m", STEEL.young_Pa, STEEL.shear_Pa, STEEL.poisson, 0.0)
        other.add_section("s", section.area_m2, section.Iy_m4, section.Iz_m4, section.J_m4)
        for name, place in frame.nodes.items():
            other.add_node(name, *place)
        for i, tube in enumerate(frame.tubes):
            other.add_member(f"t{i}", tube.start, tube.end, "m", "s")
        other.def_support("n0", *(True,) * 6)
        load = np.zeros(elements.mass.shape[0])
        random = np.random.default_rng(seed)
        for name in list(frame.nodes)[1:]:
            for i, direction in enumerate(("FX", "FY", "FZ", "MX", "MY", "MZ")):
                value = float(random.standard_normal())
                other.add_node_load(name, direction, value)
                load[6 * elements.node[name] + i] = value
        other.analyze_linear()
        ours = solve_static(elements, load, dofs_of([0]))
        theirs = np.array(
            [
                [
                    getattr(other.nodes[n], d)["Combo 1"]
                    for d in ("DX", "DY", "DZ", "RX", "RY", "RZ")
                ]
                for n in frame.nodes
            ]
        )
        assert ours.displacement.reshape(-1, 6) == pytest.approx(
            theirs, abs=1e-6 * np.abs(theirs).max()
        )
        supports = other.nodes["n0"]
        forces = [getattr(supports, f"Rxn{d}")["Combo 1"] for d in ("FX", "FY", "FZ")]
        assert ours.reaction[:3] == pytest.approx(forces, rel=1e-6, abs=1e-6)


def test_a_thin_ring_vibrates_as_love_says():
    """In its plane ω² = (EI/ρAR⁴) n²(n²−1)²/(n²+1), across it n²(n²−1)²/(n²+1+ν)
    (A. E. H. Love, Mathematical Theory of Elasticity, section 293), each twice."""
    radius, count = 1.0, 96
    angle = 2 * np.pi * np.arange(count) / count
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), 0 * angle], axis=1)
    section = round_tube(0.01, 0.005, STEEL.poisson)
    found = free_modes(chain(points.tolist(), section, element_m=9.0, closed=True), 8).frequency_hz
    bending = STEEL.young_Pa * section.Iy_m4 / (STEEL.density_kg_m3 * section.area_m2)
    wanted = sorted(
        np.sqrt(bending * n**2 * (n**2 - 1) ** 2 / (n**2 + 1 + nu)) / (2 * np.pi * radius**2)
        for n in (2, 3)
        for nu in (0.0, STEEL.poisson)
        for _ in range(2)
    )
    assert found == pytest.approx(wanted, rel=2e-3)


@pytest.mark.parametrize("count", [4, 30])
def test_lanczos_finds_what_a_dense_solver_finds(count):
    elements = assemble(ladder())
    squares = linalg.eigvalsh(elements.stiffness.toarray(), elements.mass.toarray())
    wanted = np.sqrt(squares[6 : 6 + count]) / (2 * np.pi)
    found = free_modes(elements, count)
    assert found.frequency_hz == pytest.approx(wanted, rel=1e-7)
    gram = found.shape.T @ (elements.mass @ found.shape)
    assert gram == pytest.approx(np.eye(count), abs=1e-8)
    assert np.abs(rigid_modes(elements).T @ (elements.mass @ found.shape)).max() < 1e-8


@pytest.mark.parametrize(("element_m", "points"), [(1e6, 2), (0.5, 3), (0.25, 5), (0.24, 6)])
def test_elements_are_no_longer_than_asked_and_no_more_than_needed(element_m, points):
    elements = chain([(0, 0, 0), (0, 1e-3 if element_m > 1 else 1, 0)], element_m=element_m)
    assert len(elements.position) == points


def test_asking_for_more_modes_than_there_are_gives_all_of_them():
    assert len(free_modes(chain([(0, 0, 0), (1, 0, 0)], element_m=9.0), 99).frequency_hz) == 6


def test_a_turned_frame_has_the_same_frequencies():
    frame = ladder()
    turn = linalg.expm(np.cross(np.eye(3), [0.3, -0.8, 0.5]))
    nodes = {name: tuple(turn @ place) for name, place in frame.nodes.items()}
    turned = type(frame)(**{**vars(frame), "nodes": nodes})
    one, two = (free_modes(assemble(f), 8).frequency_hz for f in (frame, turned))
    assert one == pytest.approx(two, rel=1e-7)


def test_frequencies_go_with_the_root_of_the_stiffness():
    stiff = Material(4 * STEEL.young_Pa, 4 * STEEL.shear_Pa, STEEL.density_kg_m3)
    one, two = (free_modes(assemble(ladder(m)), 5).frequency_hz for m in (STEEL, stiff))
    assert two == pytest.approx(2 * one, rel=1e-7)


MASSES = [PointMass("ML", 40.0), PointMass("MR", 40.0), PointMass("RC", 30.0)]


def test_a_reduced_frame_keeps_low_frequencies_and_exact_statics():
    elements = assemble(ladder(masses=MASSES))
    full = free_modes(elements, 8)
    errors = [
        np.abs(reduce(elements, count).free_modes()[0][:8] / full.frequency_hz - 1).max()
        for count in (0, 10, 30)
    ]
    assert errors[2] < 1e-3
    assert errors[0] > errors[1] > errors[2]
    # Rayleigh: a reduction never lowers a frequency.
    assert (reduce(elements, 10).free_modes()[0][:8] > full.frequency_hz * (1 - 1e-9)).all()

    reduced = reduce(elements, 3)
    load = np.zeros(elements.mass.shape[0])
    load[dofs_of(elements.corners[1:], (2,))] = (1.0, -2.0, 3.0)
    exact = solve_static(elements, load, dofs_of(elements.corners[:1])).displacement
    q = np.zeros(len(reduced.mass))
    q[6:] = np.linalg.solve(reduced.stiffness[6:, 6:], (reduced.basis.T @ load)[6:])
    assert reduced.basis @ q == pytest.approx(exact, abs=1e-9 * np.abs(exact).max())


def test_a_reduced_frame_has_the_mass_and_the_rigid_motions_of_the_whole():
    elements = assemble(ladder(masses=MASSES))
    reduced = reduce(elements, 5)
    motions = rigid_motions(elements.position)
    q = np.zeros((len(reduced.mass), 6))
    q[:24] = motions[dofs_of(elements.corners)]
    assert np.abs(reduced.stiffness @ q).max() < 1e-7 * np.abs(reduced.stiffness).max()
    whole = motions.T @ (elements.mass @ motions)
    assert q.T @ reduced.mass @ q == pytest.approx(whole, abs=1e-8 * whole.max())


def test_every_mode_of_a_reduction_makes_it_exact():
    elements = assemble(ladder(element_m=0.35))
    count = elements.mass.shape[0] - 24
    found = reduce(elements, count).free_modes()[0]
    assert found[:20] == pytest.approx(free_modes(elements, 20).frequency_hz, rel=1e-6)


def test_a_frame_of_interface_points_alone_is_not_reduced_at_all():
    square = [(0.7, 0.5, 0), (0.7, -0.5, 0), (-0.7, 0.5, 0), (-0.7, -0.5, 0)]
    elements = chain(square, element_m=9.0)
    reduced = reduce(elements, 5)
    assert reduced.stiffness == pytest.approx(elements.stiffness.toarray())
    assert reduced.free_modes()[0] == pytest.approx(free_modes(elements, 18).frequency_hz)


def test_one_tube_between_stout_bars_has_its_own_torsional_stiffness():
    """GJ/L: the bars across, at the front and at the rear, hardly bend."""
    length, half = 1.6, 0.3
    frame = ladder()
    nodes = {
        "FL": (length, half, 0.0), "FC": (length, 0.0, 0.0), "FR": (length, -half, 0.0),
        "RL": (0.0, half, 0.0), "RC": (0.0, 0.0, 0.0), "RR": (0.0, -half, 0.0),
    }  # fmt: skip
    stout = round_tube(0.5, 0.25, STEEL.poisson)
    tube = type(frame.tubes[0])
    tubes = (
        tube("FC", "RC", "s"),
        *(tube(f"{end}C", end + side, "stout") for end in "FR" for side in "LR"),
    )
    sections = {"s": TUBE, "stout": stout}
    found = assemble(
        type(frame)(**{**vars(frame), "nodes": nodes, "tubes": tubes, "sections": sections})
    )
    wanted = STEEL.shear_Pa * TUBE.J_m4 / length
    assert torsional_stiffness(found) == pytest.approx(wanted, rel=1e-3)
    assert warp(found) == pytest.approx([1, -1, -1, 1])


def test_torsional_stiffness_is_that_of_a_pair_at_the_front_with_the_rear_held():
    elements = assemble(ladder(masses=MASSES))
    front, rear, middle = elements.corners[:2], elements.corners[2:], elements.node["FC"]
    load = np.zeros(elements.mass.shape[0])
    load[dofs_of(front, (2,))] = (1.0, -1.0)
    held = np.concatenate([dofs_of(rear, (0, 2)), dofs_of(rear[:1], (1,)), dofs_of([middle], (2,))])
    left, right = solve_static(elements, load, held).displacement[dofs_of(front, (2,))]
    assert torsional_stiffness(elements) == pytest.approx(0.6 / ((left - right) / 0.6), rel=1e-7)


def test_all_modes_together_are_the_static_twist():
    elements = assemble(ladder(masses=MASSES, element_m=0.35))
    twist = frame_twist(elements, free_modes(elements, 10**6))
    assert twist.share.sum() == pytest.approx(1.0, rel=1e-6)


def test_a_heavy_twisting_frame_has_the_modal_mass_of_its_corners():
    """Four masses m at the corners on light rails: shape ±1, so 1/m_τ = 1/4m."""
    light = Material(STEEL.young_Pa, STEEL.shear_Pa, 1.0)
    elements = assemble(ladder(light, masses=[PointMass(c, 10.0) for c in CORNERS]))
    twist = frame_twist(elements, free_modes(elements, 6))
    assert twist.participation_1_kg[twist.first] == pytest.approx(1 / 40, rel=2e-3)
    assert twist.share[twist.first] == pytest.approx(1.0, rel=2e-3)
    # One spring between: K_τ τ = Σ sᵢFᵢ, and T = K θ with forces ±T/t, heights ±τ.
    stiffness = torsional_stiffness(elements)
    spring = 4 * 4 * stiffness / 0.6**2
    assert twist.freq_hz[twist.first] == pytest.approx(np.sqrt(spring / 40) / (2 * np.pi), rel=2e-3)
