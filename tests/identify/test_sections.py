"""Sections and fractions are the rational functions they stand for."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wheelhop.identify.published import D2_DENOMINATOR, D2_NUMERATORS, TABLE_5_2
from wheelhop.identify.sections import Sections, from_parameters, from_poles
from wheelhop.identify.synthetic import over_fractions

S = 1j * np.geomspace(0.3, 300, 40)

frequencies = st.lists(st.floats(1.0, 200.0), min_size=1, max_size=4, unique=True)


@st.composite
def sections(draw):
    omega = np.array(draw(frequencies))
    zeta = np.array([draw(st.floats(0.01, 3.0)) for _ in omega])
    return Sections(omega, zeta, draw(st.none() | st.floats(1.0, 100.0)))


@settings(max_examples=40, deadline=None)
@given(sections())
def test_slopes_are_the_derivatives_of_the_fractions(some):
    numbers, step = some.parameters(), 1e-6
    for k in range(some.order):
        up, down = (numbers + sign * step * np.eye(some.order)[k] for sign in (1, -1))
        by_difference = (from_parameters(up).basis(S) - from_parameters(down).basis(S)) / (2 * step)
        assert np.allclose(some.basis_slopes(S)[k], by_difference, rtol=1e-4, atol=1e-6)


@settings(max_examples=40, deadline=None)
@given(sections())
def test_states_give_the_fractions_and_the_poles_the_denominator(some):
    a, b, c = some.state_matrix()
    by_states = np.array([c @ np.linalg.solve(s * np.eye(some.order) - a, b) for s in S])
    assert np.allclose(by_states, some.basis(S))
    by_poles = np.prod(S[:, None] - some.poles(), axis=1)
    assert np.allclose(np.polyval(some.denominator(), S), by_poles)
    value, slope = some.at_zero()
    assert np.allclose(some.basis([1e-5])[0].real, value + 1e-5 * slope, atol=1e-9)


@settings(max_examples=40, deadline=None)
@given(sections())
def test_sections_come_back_from_their_poles(some):
    again = from_poles(some.poles())
    assert again.order == some.order
    assert np.allclose(again.denominator(), some.denominator(), rtol=1e-6)


def test_an_unstable_pole_is_mirrored():
    mirrored = from_poles(np.array([0.5 + 3j, 0.5 - 3j]))
    assert (mirrored.poles().real < 0).all()
    assert np.allclose(np.sort(mirrored.poles().imag), [-3, 3])


def test_table_5_2_multiplies_out_to_the_printed_denominator():
    """305.1 is rounded, the others are cut off after one or two digits."""
    ours = TABLE_5_2.denominator()
    unit = np.array([1, 0.1, 1e4, 1e5, 1e7, 1e8, 1e11, 1e12, 1e12])
    assert (np.abs(ours - D2_DENOMINATOR) < unit).all()


def test_printed_numerators_are_the_same_functions_over_fractions():
    theta = over_fractions(D2_NUMERATORS, TABLE_5_2)
    printed = np.array([np.polyval(n, S) for n in D2_NUMERATORS])
    printed = printed / np.polyval(TABLE_5_2.denominator(), S)
    assert theta @ TABLE_5_2.basis(S).T == pytest.approx(printed, rel=1e-6, abs=1e-9)
