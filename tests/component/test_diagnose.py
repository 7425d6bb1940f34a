"""The verdict on components whose law comes from another simulator."""

import json
from dataclasses import replace

import pytest

from tests.component.cases import CASES, DAMPER, LIBRARY, OSCILLATOR, diagnosed
from tests.component.rig import make_campaign
from wheelhop.campaign import read_campaign
from wheelhop.cli.main import main
from wheelhop.diagnose import to_json

DRIVES = ("displacement", "force")
HIDDEN = [
    *((name, "displacement") for name in CASES),
    *((name, "force") for name in ("cubic", "asymmetric-damper")),
    pytest.param("dry-friction", "force", marks=pytest.mark.slow),
]


def made(folder, drive, component, seconds=5.0):
    return make_campaign(folder / "c", drive, component, seed=1, noise=0.01, seconds=seconds)


@pytest.mark.parametrize("drive", DRIVES)
def test_a_linear_component_lacks_nothing(drive, tmp_path):
    linear = DAMPER if drive == "displacement" else OSCILLATOR
    found = diagnosed(made(tmp_path, drive, linear))
    assert found.verdict == ("none",)
    assert found.ladder[0].over_floor < 1.1
    for key in ("stiffness_N_m", "damping_N_s_m"):
        value, _ = found.ladder[-1].parameters[f"component.{key}"]
        assert value == pytest.approx(getattr(linear, key), rel=0.01)


@pytest.mark.parametrize(("name", "drive"), HIDDEN)
def test_every_law_is_named(name, drive, tmp_path):
    """At a strength that nobody overlooks, its numbers to a few per cent."""
    case = CASES[name]
    found = diagnosed(made(tmp_path, drive, case.component(drive)))
    assert found.verdict[0] == case.effect
    assert {*found.verdict[1:]} <= {"unknown"}
    last = found.ladder[-1]
    assert last.over_floor < (1.6 if name == "backlash" else 1.1)
    for key, value in case.parameters[drive].items():
        reached, _ = last.parameters[f"{case.effect}.{key}"]
        assert reached == pytest.approx(value, rel=0.05, abs=5e-5), key


@pytest.mark.parametrize("drive", ["displacement", pytest.param("force", marks=pytest.mark.slow)])
def test_a_law_of_no_library_is_not_called_by_another_name(drive, tmp_path):
    """Damping that grows with the square of the travel, as ports shut."""
    # What a force moves is integrated for every model tried, which takes long.
    base, seconds = (DAMPER, 5.0) if drive == "displacement" else (OSCILLATOR, 2.5)
    numbers = {"share": 2.0, "travel_m": 0.01}
    component = replace(base, hidden="bypass-damper", numbers=numbers)
    found = diagnosed(made(tmp_path, drive, component, seconds))
    assert found.verdict[-1] == "unknown"
    assert found.verdict == ("unknown",) or found.confidence < 0.7
    assert any("what the rig imposes" in line for line in found.explanation)


def test_an_interval_holds_the_rate_of_a_spring_of_another_law(tmp_path):
    """A spring with a fifth power bends the cubic one, and the rate with it: scatter alone would
    have the rate four times as well known as it is, or better."""
    numbers = {"cubic_N_m3": 3e7, "quintic_N_m5": 1e10}
    spring = replace(OSCILLATOR, hidden="cubic-spring", numbers=numbers)
    found = diagnosed(made(tmp_path, "force", spring, seconds=2.0))
    assert found.verdict == ("progressive-spring",)
    last, rate = found.ladder[-1], "component.stiffness_N_m"
    value, deviation = last.parameters[rate]
    assert abs(value - spring.stiffness_N_m) < 2.0 * deviation
    assert deviation < 0.02 * value
    assert abs(value - spring.stiffness_N_m) > 3.0 * last.rung.fit.uncertainty(rate)


def test_effects_of_vehicles_do_not_apply(tmp_path):
    """They are in the ranking, with the reason."""
    component = CASES["dry-friction"].component("displacement")
    document = to_json(diagnosed(made(tmp_path, "displacement", component)))
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    ranked = {item["effect"]: item for item in document["ranking"]}
    assert set(ranked) == set(LIBRARY)
    for name, item in ranked.items():
        applies = item["screened_error"] is not None
        assert applies == LIBRARY[name].on_rig
        assert applies or "component" in item["reason"]
    assert document["floor"]["source"] == "noise_rms_N"
    assert document["next_run"] is None


def test_the_commands(tmp_path, capsys):
    """check, compare, diagnose and add speak of newtons, not of roads and accelerations."""
    component = CASES["dry-friction"].component("displacement")
    folder = str(made(tmp_path, "displacement", component))
    page, result = tmp_path / "page.html", tmp_path / "result.json"
    assert main(["check", folder]) == 0
    assert main(["compare", folder, "--json", str(result)]) == 0
    floor = json.loads(result.read_text())["floor"]
    assert floor["noise_rms_N"]["force"] > 0
    assert main(["diagnose", folder, "--jobs", "1", "--report", str(page)]) == 0
    assert main(["add", folder, "dry-friction"]) == 0
    said = capsys.readouterr().out
    assert "N rms in band" in said and "m/s²" not in said and "the road" not in said
    html = page.read_text()
    assert "The component" in html and "m/s²" not in html and "km/h" not in html
    model = (tmp_path / "c" / "model.toml").read_text()
    assert "[component]" in model and "vehicle" not in model
    assert main(["add", folder, "engine-vibration"]) == 2
    assert "not on one component" in capsys.readouterr().err


def test_friction_from_free_decays_alone(tmp_path):
    """Its mass known to a third, a decaying oscillator shows the friction that stops it; one decay
    is fitted, one judges."""
    numbers = {"coulomb_N": 4.0, "joint_N_m": 4e5}
    component = replace(OSCILLATOR, hidden="dry-friction", numbers=numbers)
    folder = make_campaign(tmp_path / "c", "force", component, seed=2, noise=0.01, only="decay")
    assert not any(run.force.any() for run in read_campaign(folder).runs)
    found = diagnosed(folder)
    assert found.verdict == ("dry-friction",)
    slip, deviation = found.ladder[-1].parameters["dry-friction.strut_N"]
    assert abs(slip - 4.0) < 2 * deviation
