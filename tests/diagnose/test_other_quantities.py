"""Campaigns of potentiometers, gyros and strain gauges, short_campaign by another simulator."""

import re

import numpy as np
import pytest

from tests import truth
from tests.diagnose.cases import CASES, FRICTION, baseline_of, diagnosed, found_in, short_campaign
from tests.truth import Sensor
from wheelhop.diagnose import to_json
from wheelhop.report.tables import quantity_table

POTS = tuple(sensor for sensor in truth.SENSORS if sensor.quantity == "travel")
RODS = tuple(Sensor(f"rod{i}", "force", str(i), 8.0, -1.4, -30.0) for i in (1, 2, 3, 4))


def made(folder, sensors, hidden):
    return truth.make_campaign(
        folder, seed=101, effects=hidden, short=True, seconds=4.8, draft=True, sensors=sensors
    )


def assert_at_the_floor(diagnosis):
    """As a whole and in every quantity."""
    comparison = diagnosis.ladder[-1].comparison
    assert comparison.error_validate <= 1.15 * comparison.floor.error_validate
    for each in comparison.by_quantity:
        assert each.error_validate <= 1.15 * each.floor_validate, each.quantity


@pytest.mark.parametrize("sensors", [truth.SENSORS, POTS], ids=["all", "pots"])
def test_nothing_is_missing(sensors, tmp_path):
    diagnosis = diagnosed(made(tmp_path, sensors, {}))
    assert diagnosis.verdict == ("none",)
    assert diagnosis.confidence > 0.9
    assert_at_the_floor(diagnosis)


def test_friction_is_named_from_pots_accelerometers_and_gyros(tmp_path):
    diagnosis = diagnosed(made(tmp_path, truth.SENSORS, {"dry-friction": FRICTION}))
    assert diagnosis.verdict == ("dry-friction",)
    assert diagnosis.confidence > 0.9
    assert_at_the_floor(diagnosis)
    plain = to_json(diagnosis)
    assert [each["unit"] for each in plain["quantities"]] == ["m/s²", "m", "rad/s"]
    table = quantity_table(diagnosis.ladder[-1].comparison)
    assert all(words in table for words in ("travel", "0.000200 m", "0.00400 rad/s"))
    found = found_in(diagnosis, "dry-friction")
    assert found["front_N"] == pytest.approx(FRICTION["coulomb_front_N"], rel=0.15)
    assert found["rear_N"] == pytest.approx(FRICTION["coulomb_rear_N"], rel=0.15)


FAULTS = {
    "a pot the wrong way round": ("sensor-polarity", "pot2", lambda record: -record, None),
    "pots exchanged": ("sensor-polarity", "pot1/pot3", None, ("pot1", "pot3")),
    "a pot of another ratio": ("sensor-gain", "pot4", lambda record: 1.15 * record, None),
}


@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(fault, marks=() if fault == "pots exchanged" else pytest.mark.slow)
        for fault in FAULTS
    ],
)
def test_a_sensor_at_fault_is_named(fault, tmp_path):
    effect, form, changed, exchanged = FAULTS[fault]
    folder = made(tmp_path, truth.SENSORS, {})
    for file in (folder / "runs").glob("*.csv"):
        head, table = file.read_text().split("\n")[0], np.loadtxt(file, delimiter=",", skiprows=1)
        names = head.split(",")
        if exchanged:
            columns = [names.index(name) for name in exchanged]
            table[:, columns] = table[:, columns[::-1]]
        else:
            table[:, names.index(form)] = changed(table[:, names.index(form)])
        np.savetxt(file, table, "%.9g", ",", header=head, comments="")
    diagnosis = diagnosed(folder)
    assert diagnosis.verdict == (effect,)
    assert found_in(diagnosis, effect)["form"] == form
    assert_at_the_floor(diagnosis)


def test_measured_forces_tell_the_common_scale_of_masses_and_forces(tmp_path):
    """The owner believes masses that are 10 % off."""
    folder = made(tmp_path, RODS, {})
    fitted = baseline_of(folder).rung.fit
    true = truth.read_truth(folder).vehicle
    nominal = fitted.shared[[free.name for free in fitted.shared].index("body.mass_kg")].mean
    assert abs(nominal / true["body.mass_kg"] - 1.0) > 0.03
    for name in (
        "body.mass_kg",
        "suspension.front.stiffness_N_m",
        "wheel.front.tyre_stiffness_N_m",
    ):
        assert fitted.model.values[name] == pytest.approx(true[name], rel=0.01)
    assert fitted.deviations["body.mass_kg"] < 0.01 * true["body.mass_kg"]


def test_without_forces_that_scale_is_what_is_believed(tmp_path):
    fitted = baseline_of(made(tmp_path, POTS, {})).rung.fit
    assert fitted.deviations["body.mass_kg"] > 0.02 * fitted.model.values["body.mass_kg"]


@pytest.mark.parametrize(
    "name",
    [
        "small-scale-roughness",  # heights nobody knows are heard by every channel
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("bump-stop", "digressive-damper", "engine-vibration", "frame-twist")
        ),
    ],
)
def test_other_physics_is_named_too(name, tmp_path):
    case = CASES[name]
    folder = short_campaign(case, tmp_path, sensors=truth.SENSORS)
    diagnosis = diagnosed(folder)
    assert diagnosis.verdict == case.verdict
    assert_at_the_floor(diagnosis)


def test_a_ratio_that_is_known_roughly_is_estimated(tmp_path):
    """The rocker of pot4 has 6 % more than its drawing says, to 5 %."""
    folder = made(tmp_path, truth.SENSORS, {})
    toml = folder / "campaign.toml"
    text = toml.read_text()
    said = "corner = 4, per_wheel = 0.65"
    toml.write_text(
        text.replace(said, f"corner = 4, per_wheel = {0.65 / 1.06}, scale_uncertainty = 0.05")
    )
    fitted = baseline_of(folder).rung.fit
    assert fitted.model.values["channel.pot4.gain"] == pytest.approx(0.06, abs=0.005)
    assert fitted.deviations["channel.pot4.gain"] < 0.01


@pytest.mark.slow
def test_gyros_judge_what_measured_axles_do(tmp_path):
    """On a road nobody surveyed travel is not compared, and friction is named all the same."""
    hubs = tuple(Sensor(f"A{i}", "acceleration", f"A{i}", 0.1) for i in (1, 2, 3, 4))
    folder = made(tmp_path, (*hubs, *truth.SENSORS), {"dry-friction": FRICTION})
    toml = folder / "campaign.toml"
    lines = [
        line for line in toml.read_text().split("\n") if not re.match(r"track\.(?!kind)", line)
    ]
    text = re.sub(r"track\.kind = .*", 'track.kind = "unknown"', "\n".join(lines))
    toml.write_text(text)
    diagnosis = diagnosed(folder)
    assert diagnosis.verdict == ("dry-friction",)
    compared = [e.quantity for e in diagnosis.ladder[-1].comparison.by_quantity]
    assert compared == ["acceleration", "rate"]
