"""The cantilever against closed forms, reciprocity, and an independent finite element model."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.linalg import eigh

from wheelhop.calibration.error import CalibrationError
from wheelhop.calibration.sync.beam import Beam
from wheelhop.calibration.sync.beam_file import read_beam

LENGTH = 0.6096
RULER = Beam.rectangular(LENGTH, 0.0254, 0.000635, 2e11, 7850.0)
BENDING, LINE_MASS = RULER.bending_stiffness_N_m2, RULER.mass_per_length_kg_m
STATIC = 3 * BENDING / LENGTH**3  # N/m at the free end


def roots(frequencies_hz):
    return (LINE_MASS * (2 * np.pi * frequencies_hz) ** 2 / BENDING) ** 0.25 * LENGTH


def test_bare_cantilever_has_the_textbook_frequencies():
    found = roots(RULER.natural_frequencies_hz(120.0))
    known = [1.87510407, 4.69409113, 7.85475744, 10.99554073, 14.13716839, 17.27875953]
    assert found == pytest.approx(known, rel=1e-8)


def test_no_frequency_is_missed_however_the_beam_is_divided():
    cut = RULER
    for at in (0.01, 0.3, 0.3048, 0.6):
        cut = cut.carrying(at)
    whole = RULER.natural_frequencies_hz(1500.0)
    assert cut.natural_frequencies_hz(1500.0) == pytest.approx(whole, rel=1e-7)
    assert len(whole) == 20  # (n - 1/2) π, all but the first two nearly


def test_a_heavy_tip_mass_swings_on_the_static_stiffness():
    mass = 1e4 * LINE_MASS * LENGTH
    first = RULER.carrying(LENGTH, mass).natural_frequencies_hz(1.0)[0]
    assert first == pytest.approx(np.sqrt(STATIC / mass) / (2 * np.pi), rel=1e-4)


def test_a_stiff_tip_spring_makes_a_propped_cantilever():
    propped = RULER.carrying(LENGTH, spring_N_m=1e9 * STATIC)
    assert roots(propped.natural_frequencies_hz(40.0)) == pytest.approx(
        [3.92660231, 7.06858275], rel=1e-6
    )


def test_slow_forces_see_the_static_stiffness():
    assert RULER.receptance(1e-3, LENGTH, LENGTH).real.item() == pytest.approx(1 / STATIC, rel=1e-5)
    middle = RULER.receptance(1e-3, LENGTH, LENGTH / 2).real.item()
    assert middle == pytest.approx(5 / 16 / STATIC, rel=1e-5)  # w(x) = F x² (3 L − x) / 6 E I


@settings(max_examples=50, deadline=None)
@given(
    st.floats(0.05, 1.0), st.floats(0.05, 1.0), st.floats(0.5, 80.0), st.floats(0.0, 0.1),
    st.floats(0.0, 0.05),
)  # fmt: skip
def test_receptance_is_reciprocal_and_takes_power(here, there, frequency_hz, loss, mass):
    # Two points within a thousandth of the length are taken for one, which of them the order says.
    assume(here == there or abs(here - there) > 1e-3)
    beam = RULER.carrying(0.4 * LENGTH, mass)
    one = beam.receptance(frequency_hz, here * LENGTH, there * LENGTH, loss).item()
    other = beam.receptance(frequency_hz, there * LENGTH, here * LENGTH, loss).item()
    assert one == pytest.approx(other, rel=1e-6, abs=1e-12)
    # A driven point cannot give power back: the deflection lags the force.
    assert beam.receptance(frequency_hz, here * LENGTH, here * LENGTH, loss).imag.item() <= 1e-12


def finite_elements(count):
    """Hermite elements with consistent mass (Przemieniecki): K and M of the clamped ruler."""
    h = LENGTH / count
    s = h * h
    stiff = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * s, -6 * h, 2 * s],
             [-12, -6 * h, 12, -6 * h], [6 * h, 2 * s, -6 * h, 4 * s]]  # fmt: skip
    mass = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * s, 13 * h, -3 * s],
            [54, 13 * h, 156, -22 * h], [-13 * h, -3 * s, -22 * h, 4 * s]]  # fmt: skip
    k, m = np.zeros((2 * count + 2,) * 2), np.zeros((2 * count + 2,) * 2)
    for i in range(count):
        block = slice(2 * i, 2 * i + 4)
        k[block, block] += np.array(stiff) * BENDING / h**3
        m[block, block] += np.array(mass) * LINE_MASS * h / 420
    return k, m


def test_beam_with_sensors_agrees_with_finite_elements():
    count, at = 24, (6, 12, 18, 24)
    k, m = finite_elements(count)
    beam = RULER
    for node in at:
        m[2 * node, 2 * node] += 3e-3
        beam = beam.carrying(node / count * LENGTH, 3e-3)
    own = np.sqrt(eigh(k[2:, 2:], m[2:, 2:], eigvals_only=True)[:4]) / (2 * np.pi)
    assert beam.natural_frequencies_hz(60.0)[:4] == pytest.approx(own, rel=1e-4)
    force = np.zeros(2 * count + 2)
    force[-2] = 1.0
    omega = 2 * np.pi * 15.0
    answer = np.linalg.solve((k * (1 + 0.01j) - omega**2 * m)[2:, 2:], force[2:])
    expected = answer[[2 * node - 2 for node in at]]
    places = [node / count * LENGTH for node in at]
    assert beam.receptance(15.0, LENGTH, places, 0.01)[0] == pytest.approx(expected, rel=1e-4)


GOOD = """format = 1
[beam]
length_mm = 609.6
width_mm = 25.4
height_mm = 0.635
youngs_modulus_GPa = 200.0
density_kg_m3 = 7850.0
[drive]
frequencies_hz = [15.0, 34.0]
[[sensor]]
channel = "A0"
position_mm = 152.0
mass_g = 2.0
[[sensor]]
channel = "A1"
position_mm = 609.6
mass_g = 2.0
"""


def test_file_says_the_thesis_ruler(tmp_path):
    file = tmp_path / "beam.toml"
    file.write_text(GOOD, encoding="utf-8")
    session = read_beam(file)
    assert session.channels == ("A0", "A1")
    assert session.positions_m == pytest.approx((0.152, 0.6096))
    assert session.drive_m == pytest.approx(LENGTH)
    assert session.beam.bending_stiffness_N_m2 == pytest.approx(BENDING)
    assert sum(session.beam.masses_kg) == pytest.approx(4e-3)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("height_mm = 0.635", "height_mm = 100", "slender"),
        ("width_mm = 25.4", "", "width_mm"),
        ("position_mm = 609.6", "position_mm = 700", "beyond the free end"),
        ('"A1"', '"A0"', "twice"),
        ("[15.0, 34.0]", "[15.0, 15.1]", "nearer than"),
        ("[15.0, 34.0]", "15.0", "list"),
        ("[15.0, 34.0]", "[]", "list"),
        ("mass_g = 2.0", "mas_g = 2.0", "mass_g"),
        ("mass_g = 2.0", "mass_g = -1", "mass_g"),
        ("format = 1", "format = 2", "format"),
    ],
)
def test_mistakes_in_the_file_are_one_line(tmp_path, old, new, said):
    file = tmp_path / "beam.toml"
    file.write_text(GOOD.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CalibrationError) as caught:
        read_beam(file)
    assert said in str(caught.value) and str(file) in str(caught.value)
    assert "\n" not in str(caught.value)
