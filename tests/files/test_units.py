"""Units have the size they are defined to have: BIPM, The International System of Units, 2019;
inch, foot, mile and pound by the agreement of 1959."""

from math import pi

import pytest

from wheelhop.files.units import SECONDS, STANDARD_GRAVITY_M_S2, UNITS, beyond, split_unit, to_si
from wheelhop.files.words import ending_of, unit_of

DEFINED = {
    **{"m/s²": 1.0, "cm/s²": 0.01, "Gal": 0.01, "mm/s2": 1e-3, "g": 9.80665, "mg": 9.80665e-3},
    **{
        "ft/s²": 0.3048,
        "in/s^2": 0.0254,
        "km/h": 1000 / 3600,
        "mph": 1609.344 / 3600,
        "mm/s": 1e-3,
    },
    **{"cm": 0.01, "mm": 1e-3, "µm": 1e-6, "inch": 0.0254, "kN": 1e3, "lbf": 0.45359237 * 9.80665},
    **{"V": 1.0, "mV": 1e-3, "uV": 1e-6},
    **{"rad/s": 1.0, "deg/s": pi / 180, "°/s": pi / 180, "dps": pi / 180, "rpm": 2 * pi / 60},
}


@pytest.mark.parametrize(("unit", "size"), DEFINED.items())
def test_as_recorders_spell_them(unit, size):
    assert to_si(unit)[1] == pytest.approx(size, rel=1e-12)


def test_units_of_time_have_their_size():
    sizes = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
    assert {unit: SECONDS[unit] for unit in sizes} == sizes


KEYS = {
    **{"m": 1.0, "cm": 0.01, "mm": 1e-3, "km": 1e3, "in": 0.0254, "ft": 0.3048},
    **{"m_s": 1.0, "mps": 1.0, "kmph": 1 / 3.6, "km_h": 1 / 3.6, "mph": 0.44704},
    **{"m_s2": 1.0, "mm_s2": 1e-3, "deg": pi / 180, "rad": 1.0, "s": 1.0, "ms": 1e-3, "us": 1e-6},
    **{"rad_s": 1.0, "deg_s": pi / 180, "rpm": 2 * pi / 60},
    **{"Hz": 1.0, "hz": 1.0, "kHz": 1e3, "kg": 1.0, "g": 1e-3, "t": 1e3, "lb": 0.45359237},
    **{"kg_m": 1.0, "kg_m2": 1.0, "kg_m3": 1.0, "g_cm3": 1e3, "1_kg": 1.0, "1_m": 1.0, "1_m2": 1.0},
    **{"Pa": 1.0, "MPa": 1e6, "GPa": 1e9, "m3": 1.0, "cm3": 1e-6, "N": 1.0, "m_N": 1.0},
    **{"N_m": 1.0, "N_mm": 1e3, "kN_m": 1e3, "kN_mm": 1e6, "N_m3": 1.0},
    **{"N_s_m": 1.0, "Ns_m": 1.0, "N_s_mm": 1e3, "Ns_mm": 1e3, "kN_s_m": 1e3},
}


def test_as_keys_of_files_end_in_them():
    others = {"kmh": 1 / 3.6, "kph": 1 / 3.6, "khz": 1e3}
    assert {key: unit.in_si for key, unit in UNITS.items()} == pytest.approx(KEYS | others)


@pytest.mark.parametrize(
    ("ending", "unit"),
    [
        ("_m", "m"),
        ("_m_s", "m/s"),
        ("_m_s2", "m/s²"),
        ("_rad_s", "rad/s"),
        ("_N", "N"),
        ("_N_m", "N/m"),
        ("_N_s_m", "N s/m"),
        ("_kg_m2", "kg m²"),
        ("_m_N", "m/N"),
        ("_N_m3", "N/m³"),
        ("_N_s2_m2", "N s²/m²"),
        ("_kg_m3", "kg/m³"),
        ("_m3", "m³"),
    ],
)
def test_names_in_si_end_in_their_unit(ending, unit):
    assert unit_of(f"quantity{ending}") == unit
    assert ending_of(unit) == ending


def test_what_is_not_in_si_is_no_unit_of_ours():
    """Whoever reads a name would take millimetres for metres."""
    assert [unit_of(name) for name in ("gap_mm", "mass_t", "rate_kN_mm", "shape")] == [""] * 4


def test_gravity_is_what_was_defined():
    assert STANDARD_GRAVITY_M_S2 == 9.80665


@pytest.mark.parametrize(
    ("key", "name", "unit"),
    [
        ("rear_damping_N_s_m", "rear_damping", "N_s_m"),  # not metres, and not "N_s" of anything
        ("tyre_stiffness_N_mm", "tyre_stiffness", "N_mm"),
        ("pitch_inertia_kg_m2_uncertainty", "pitch_inertia_uncertainty", "kg_m2"),
        ("gap_m", "gap", "m"),
        ("front_left_gap_mm", "front_left_gap", "mm"),
        ("speed_kmph", "speed", "kmph"),
        ("rebound_ratio", "rebound_ratio", None),
        ("shape_uncertainty", "shape_uncertainty", None),
        ("m", "m", None),  # a name, not a unit without one
    ],
)
def test_a_key_ends_in_the_longest_unit_that_is_known(key, name, unit):
    assert split_unit(key) == (name, unit)


BELIEVED = {
    **{"gap_m": (1e-6, 1e5), "speed_m_s": (1e-4, 1e3), "caster_rad": (1e-6, 10.0)},
    **{"delay_s": (1e-9, 1e9), "mode_Hz": (1e-6, 1e7), "axle_kg": (1e-4, 1e6)},
    **{"pitch_kg_m2": (1e-6, 1e7), "noise_m_s2": (1e-9, 1e6), "tyre_N_m": (1e-3, 1e10)},
    **{"damper_N_s_m": (1e-4, 1e8), "steel_kg_m3": (1e-3, 1e5), "modulus_Pa": (1e3, 1e15)},
}
"""The least and the largest number of each dimension, in SI: from a micrometre to 100 km, say."""


@pytest.mark.parametrize(("key", "least", "largest"), [(k, *b) for k, b in BELIEVED.items()])
def test_a_number_is_believed_up_to_its_bounds_and_not_beyond(key, least, largest):
    for value in (least, -least, largest, -largest, 0.0):
        assert beyond(key, value) == ""
    assert beyond(key, 0.99 * least).startswith("is too small to be believed")
    assert beyond(key, -1.01 * largest).startswith("is too large to be believed")


def test_bounds_are_told_in_the_unit_of_the_key():
    """Somebody has written newtons per metre under a key that wants newtons per millimetre."""
    assert beyond("stiffness_N_mm", 2e8) == (
        "is too large to be believed: 1e-06 to 1e+07 newtons per millimetre are"
    )
    assert beyond("stiffness_N_mm", 5e6) == ""


def test_what_has_no_unit_or_no_bounds_may_be_any_number():
    assert beyond("rebound_ratio", 1e30) == beyond("load_N", 1e30) == ""
