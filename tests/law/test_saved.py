"""A formula's file adds the forces that the formula does, at every kind of place."""

import runpy

import pytest

from tests.simulate.setup import ATV
from wheelhop.effects import Shape
from wheelhop.law.along import laws_of
from wheelhop.law.formula import Formula, source_of
from wheelhop.law.places import Where
from wheelhop.law.terms import beyond, slipping, valved

SEAT = {"driver-seat.mass_kg": 70.0, "driver-seat.x_m": -0.1}
TERMS = (beyond(0.012, 0.05), slipping(0.004), valved(0.3, 0.6, 1.2))


@pytest.mark.parametrize(
    ("where", "apart"),
    [
        (Where("all struts", "strut", (0, 1, 2, 3)), False),
        (Where("all struts", "strut", (0, 1, 2, 3)), True),
        (Where("all tyres", "tyre", (0, 1, 2, 3)), True),
        (Where("driver's seat", "mount", (), "driver"), False),
    ],
    ids=["struts", "struts of each axle", "tyres of each axle", "seat"],
)
def test_the_file_adds_the_same_forces(where, apart, tmp_path):
    formula = Formula(where, TERMS, apart).with_free_shapes()
    vehicle = {**ATV, **SEAT}
    gaps = [p for p in formula.parameters_for(vehicle, ()) if isinstance(p, Shape)]
    shapes = {p.name: (1.3 + 0.1 * i) * p.start for i, p in enumerate(gaps)}
    assert len(shapes) == 3 * len(formula.ends())
    forces = [p.name for p in formula.parameters_for(vehicle, ()) if not isinstance(p, Shape)]
    amplitudes = {name: 100.0 + i for i, name in enumerate(forces)}
    fitted = {f"formula.{name}": value for name, value in {**shapes, **amplitudes}.items()}
    file = tmp_path / "kept.py"
    file.write_text(source_of(formula, {**vehicle, **fitted}, "a campaign", "found-law"))
    kept = runpy.run_path(str(file))["FoundLaw"]()
    own = kept.parameters_for(vehicle, ())
    assert [p.scale for p in own] == pytest.approx(list(amplitudes.values()))
    theta = {p.name: p.scale for p in own}

    def told(laws):
        return [(row, law.__name__, pytest.approx(numbers)) for row, law, numbers, _ in laws]

    expected = laws_of(formula, {**shapes, **amplitudes}, vehicle)
    found = laws_of(kept, theta, vehicle)
    assert len(found) == len(expected)
    for row, law, numbers, _ in found:
        assert (row, law.__name__, numbers) in told(expected)


def test_each_axle_s_numbers_begin_as_those_of_both():
    both = Formula(Where("all tyres", "tyre", (0, 1, 2, 3)), TERMS).with_free_shapes()
    apart = both.with_each_axle()
    known = {f"formula.{p.name}" for p in both.parameters_for(ATV, ())}
    own = [f"formula.{p.name}" for p in apart.parameters_for(ATV, ())]
    assert len(own) == 2 * len(known) and {apart.common(name) for name in own} == known
