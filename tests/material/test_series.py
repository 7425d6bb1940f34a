"""A strut on a mount: modes against the formula, and both against a body that stands on them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.material.table import ROWS, power_law
from wheelhop.effects.mount_bushing import relaxing
from wheelhop.material import approximate
from wheelhop.material.series import exactly_in_series, in_series
from wheelhop.simulate import frequency_response
from wheelhop.vehicle.assembly import Assembly, Coordinate, between

HZ = np.geomspace(0.1, 50.0, 60)
OMEGA = 2 * np.pi * HZ
MASS_KG = 80.0


def on_strut(share_of_spring):
    """A mass on a strut on a prescribed axle: port 0 takes all but a share of the spring."""
    parts = Assembly(prescribed=("axle",), body=())
    body = parts.add_coordinate("body")
    strut = between(body, Coordinate("axle"))
    parts.add_mass(((1.0, body),), MASS_KG)
    parts.add_spring(strut, share_of_spring)
    parts.add_law(strut, relaxing, ())
    parts.add_output(((1.0, body),))
    return parts.system()


@settings(deadline=None, max_examples=40)
@given(
    st.integers(0, len(ROWS) - 1), st.floats(1e3, 1e6), st.floats(10.0, 1e4), st.floats(0.0, 5.0)
)
def test_the_modes_are_the_elements_in_series(i, stiffness, damping, share):
    """But for the damper that no mount is without: 0.06 % of the mount at 50 Hz."""
    elements = approximate(lambda omega: power_law(i, omega))
    series = in_series(stiffness, damping, elements, share)
    exact = exactly_in_series(stiffness + 1j * OMEGA * damping, elements.modulus(OMEGA), share)
    assert np.abs(series.modulus(OMEGA) / exact - 1).max() < 1e-3
    assert (series.rates_1_s > 0).all()


@pytest.mark.parametrize("aside", [0.0, 5e3])
def test_the_frequency_response_takes_any_dynamic_stiffness(aside):
    """Z/(Z − ω² m) times −ω², with Z wherever it is written."""
    stiffness = exactly_in_series(2e4 + 1.5e3j * OMEGA, power_law(2, OMEGA), 1.0)
    found = frequency_response(on_strut(aside), HZ, (stiffness - aside)[:, None])[:, 0, 0]
    whole = -(OMEGA**2) * stiffness / (stiffness - OMEGA**2 * MASS_KG)
    assert np.allclose(found, whole, rtol=1e-12)


@pytest.mark.parametrize("i", range(len(ROWS)))
def test_elements_instead_of_the_modulus_change_the_response_little(i):
    """Elements within 0.2 %, as a vehicle takes them, change the body's acceleration by less than
    0.2 % at every frequency; without the mount it would be off by more than ten times that."""
    elements = approximate(lambda omega: power_law(i, omega), tolerance=2e-3)
    strut = 4e4 + 2e3j * OMEGA
    with_mount = [
        exactly_in_series(strut, mount, 1.0)
        for mount in (power_law(i, OMEGA), elements.modulus(OMEGA))
    ]
    exact, near, without = (
        frequency_response(on_strut(0.0), HZ, z[:, None])[:, 0, 0] for z in (*with_mount, strut)
    )
    off = np.abs(near / exact - 1).max()
    assert off < 2e-3 and np.abs(without / exact - 1).max() > 10 * off
