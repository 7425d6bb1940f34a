"""A frame's first torsional mode is what the effect frame-twist finds in runs of the car on it."""

from dataclasses import replace

import pytest

from tests.frame.frames import STEEL, ladder
from tests.vehicle.test_flexible_frame import MASSES, values_of
from wheelhop.effects import load_effects
from wheelhop.fit import Workshop, fit, vehicle_parameters
from wheelhop.fit.parameters import effect_parameters
from wheelhop.frame import Material, assemble, corner_modes, frame_twist, free_modes
from wheelhop.predict import Case, read_drives
from wheelhop.vehicle import Vehicle
from wheelhop.vehicle.frame_modes import mode_values

TRACKS = [
    "one-sided-washboard/high",
    "chassis-twist/medium:lateral_offset_mm=0",  # on the middle: torsion and little else
    "herringbone/medium",
]


def test_a_fit_finds_the_first_torsion_of_the_frame_s_elements():
    hard = Material(9 * STEEL.young_Pa, 9 * STEEL.shear_Pa, STEEL.density_kg_m3)
    elements = assemble(ladder(hard, masses=MASSES, width=1.1))
    rigid = values_of(elements)
    bending = rigid | mode_values(corner_modes(elements), 10, 0.02)
    case = Case(
        Vehicle("on its frame", bending, dict.fromkeys(bending, 0.0)),
        (),
        read_drives(TRACKS, [12.0, 20.0]),
        seconds=5.0,
    )
    campaign, model = case.campaign(0.05)
    effect = load_effects()["frame-twist"]
    parameters = effect.parameters_for(rigid, campaign.channels)
    start = replace(model, values=rigid).with_effect(effect, parameters)
    start = start.with_values({"frame-twist.participation_1_kg": 5.0 / rigid["body.mass_kg"]})
    believed = Vehicle("rigid", rigid, {k: 0.02 * abs(v) + 1e-4 for k, v in rigid.items()})
    free = [*vehicle_parameters(campaign, believed), *effect_parameters(parameters, start, effect)]
    workshop = Workshop(campaign, start, jobs=1)
    found = fit(workshop, start, free, workshop.of_role("fit")).model.values
    known = frame_twist(elements, free_modes(elements, 10))
    first = known.first
    assert found["frame-twist.freq_hz"] == pytest.approx(known.freq_hz[first], rel=0.01)
    participation = known.participation_1_kg[first]
    assert found["frame-twist.participation_1_kg"] == pytest.approx(participation, rel=0.03)
    assert found["frame-twist.zeta"] == pytest.approx(0.02, rel=0.05)
