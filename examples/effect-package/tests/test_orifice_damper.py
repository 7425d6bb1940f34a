"""The effect does what every effect must, and follows its law."""

import numpy as np
import pytest
from orifice_damper import OrificeDamper, orifice

import wheelhop as wh


def test_it_does_what_every_effect_must():
    """The kit raises what is wrong."""
    table = wh.check_effect(OrificeDamper)
    assert (table["kind"] == "amplitude").all()
    assert table["change"].between(0.001, 1.0).all()


def test_it_is_found_once_it_is_installed():
    """By its entry point."""
    assert "orifice-damper" in wh.load_effects()


@pytest.mark.parametrize("speed", [-2.0, -0.5, 0.0, 0.5, 2.0])
def test_the_force_opposes_the_motion_and_grows_with_its_square(speed):
    """Opposite signs, alike in size."""
    force, memory = orifice(0.0, speed, 0.0, 0.0, 0.0, np.array([300.0]))
    assert force == pytest.approx(300.0 * speed * abs(speed)) and memory == 0.0
