"""Quarter and half cars: closed forms, and what the full car does where it moves as they do."""

from dataclasses import replace

import numpy as np
import pytest

from tests.truth import PRESETS
from wheelhop.campaign import Campaign, CampaignError, Channel
from wheelhop.effects import load_effects
from wheelhop.simulate import Model, frequency_response
from wheelhop.vehicle import read_nominal, read_vehicle, struts
from wheelhop.vehicle.layout import MODELS, behind_m, static_tyre_load, wheels

FREQUENCY_HZ = np.geomspace(0.3, 40.0, 60)
ATV = dict(PRESETS["atv"].vehicle)
GONE = {
    "half-car": ("track_width", "roll_inertia"),
    "half-car-roll": ("wheelbase", "cg_to_front", "pitch_inertia", ".rear."),
}
GONE["quarter-car"] = (*GONE["half-car"], *GONE["half-car-roll"], "geometry.")
SHARE = {"half-car": 2, "half-car-roll": 2, "quarter-car": 4}


def alike_fore_and_aft():
    values = dict(ATV)
    values["geometry.cg_to_front_axle_m"] = values["geometry.wheelbase_m"] / 2
    return {key: values[key.replace(".rear.", ".front.")] for key in values}


def part_of(values, model):
    """The numbers of a smaller model that carries its share of the full car's body."""
    kept = {k: v for k, v in values.items() if not any(word in k for word in GONE[model])}
    return {k: v / SHARE[model] if k.startswith("body.") else v for k, v in kept.items()}


def response(values, corner=0):
    channels = [Channel(f"B{corner + 1}", f"B{corner + 1}"), Channel(f"A{corner + 1}", "A1")]
    channels[1] = replace(channels[1], point=f"A{corner + 1}")
    return frequency_response(Model(values).system(channels, "road"), FREQUENCY_HZ)


def test_quarter_car_closed_form():
    values = part_of(ATV, "quarter-car")
    s = 2j * np.pi * FREQUENCY_HZ
    m, mu = values["body.mass_kg"], values["wheel.front.unsprung_mass_kg"]
    strut = values["suspension.front.stiffness_N_m"] + s * values["suspension.front.damping_N_s_m"]
    tyre = values["wheel.front.tyre_stiffness_N_m"] + s * values["wheel.front.tyre_damping_N_s_m"]
    below = (m * s**2 + strut) * (mu * s**2 + strut + tyre) - strut**2
    found = response(values)
    np.testing.assert_allclose(found[:, 0, 0], s**2 * tyre * strut / below, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1, 0], s**2 * tyre * (m * s**2 + strut) / below, rtol=1e-9)


@pytest.mark.parametrize("model", SHARE)
@pytest.mark.parametrize("corner", [0, 1, 2])
def test_smaller_models_are_the_full_car_in_their_own_motion(model, corner):
    """Wheels that the smaller model lacks do as their neighbours do, and the body the rest."""
    full = dict(ATV) if model == "half-car" else alike_fore_and_aft()
    small = part_of(full, model)
    if corner not in wheels(small):
        return
    assert set(MODELS[model]) < set(MODELS["full-car"])
    alike = np.zeros((4, len(wheels(small))))
    for i in range(4):
        side, end = i % 2 if model == "half-car-roll" else 0, 2 if i >= 2 else 0
        alike[i, wheels(small).index(side + (end if model == "half-car" else 0))] = 1.0
    np.testing.assert_allclose(
        response(full, corner) @ alike, response(small, corner), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("model", [*SHARE, "full-car"])
def test_tyres_carry_the_vehicle(model):
    values = ATV if model == "full-car" else part_of(ATV, model)
    mass = values["body.mass_kg"] + sum(
        values[f"wheel.{'front' if i < 2 else 'rear'}.unsprung_mass_kg"] for i in wheels(values)
    )
    load = sum(static_tyre_load(values, i) for i in wheels(values))
    assert load == pytest.approx(9.80665 * mass)
    assert len(struts(values)) == len(wheels(values))
    if "geometry.wheelbase_m" in values:  # moments about the front axle balance
        rear = sum(static_tyre_load(values, i) * behind_m(values, i) for i in wheels(values))
        behind = values["body.mass_kg"] * values["geometry.cg_to_front_axle_m"]
        behind += values["geometry.wheelbase_m"] * sum(
            values["wheel.rear.unsprung_mass_kg"] for i in wheels(values) if i >= 2
        )
        assert rear == pytest.approx(9.80665 * behind)


@pytest.mark.parametrize("model", SHARE)
def test_every_effect_that_applies_can_be_added(model):
    values = part_of(ATV | {"geometry.cg_height_m": 0.5}, model)
    channels = [Channel(p, p) for i in wheels(values) for p in (f"A{i + 1}", f"B{i + 1}")]
    applied = []
    for effect in load_effects().values():
        for choice in effect.choices(channels):
            form = effect.with_choice(choice) if choice else effect
            if form.applies_to(values):
                base = Model(values)
                parameters = form.parameters_for(values, channels)
                shown = {f"{form.id}.{p.name}": p.typical for p in parameters}
                system = (
                    base.with_effect(form, parameters).with_values(shown).system(channels, "road")
                )
                assert np.isfinite(system.stiffness).all()
                applied.append(form.id)
    assert {"dry-friction", "driver-seat", "tyre-lift-off", "sensor-gain"} <= set(applied)
    assert "frame-twist" not in applied
    assert ("anti-roll-bar" in applied) == ("roll" in MODELS[model])
    assert ("longitudinal-pitch" in applied) == ("pitch" in MODELS[model])


QUARTER = """format = 1
name = "one corner"
model = "quarter-car"
relative_uncertainty = 0.1
[body]
mass_kg = 60.0
[suspension.front]
stiffness_N_m = 10500.0
damping_N_s_m = 630.0
[wheel.front]
unsprung_mass_kg = 15.0
tyre_stiffness_N_m = 40000.0
tyre_damping_N_s_m = 200.0
radius_m = 0.279
"""


def test_a_quarter_car_has_no_more_numbers_than_it_needs(tmp_path):
    file = tmp_path / "vehicle.toml"
    file.write_text(QUARTER)
    vehicle = read_vehicle(file)
    assert wheels(vehicle.values) == (0,)
    assert len(vehicle.values) == 7


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"quarter-car"', '"eighth-car"', "quarter-car, half-car"),
        ("[body]", "[body]\nroll_inertia_kg_m2 = 20.0", "a quarter-car has none"),
        ("[body]", "[geometry]\ncg_height_m = 0.5\n[body]", "a quarter-car has none"),
        ("[wheel.front]", "[wheel.rear]\nradius_m = 0.3\n[wheel.front]", "a quarter-car has none"),
        ('"quarter-car"', '"half-car"', "missing: [geometry]"),
    ],
)
def test_a_key_the_model_does_not_have_is_a_line(tmp_path, old, new, said):
    file = tmp_path / "vehicle.toml"
    file.write_text(QUARTER.replace(old, new))
    with pytest.raises(CampaignError) as error:
        read_vehicle(file)
    assert str(file) in str(error.value)
    assert said in str(error.value)
    assert "\n" not in str(error.value)


def test_a_channel_where_the_vehicle_has_no_wheel_is_a_line(tmp_path):
    file = tmp_path / "vehicle.toml"
    file.write_text(QUARTER)
    channels = (Channel("A1", "A1"), Channel("rear", "B3"))
    campaign = Campaign(tmp_path, "", file, 100.0, (0.5, 30.0), 0.0, None, channels, ())
    with pytest.raises(CampaignError, match=r"channel rear sits at B3.*has only A1, B1"):
        read_nominal(campaign)
