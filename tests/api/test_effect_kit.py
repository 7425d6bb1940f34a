"""The test kit passes wheelhop's own effects and says what is wrong with others; packages bring
effects by an entry point."""

import sys
from pathlib import Path

import pytest

import wheelhop as wh
from wheelhop.effects import Amplitude
from wheelhop.effects.dry_friction import DryFriction
from wheelhop.vehicle import struts

TEMPLATE = Path(__file__).parents[2] / "examples/effect-package"
OWN = ("tyre-envelope", "bump-stop", "dry-friction", "driver-seat", "anti-roll-bar", "sensor-gain")


class Spring(wh.Effect):
    """A spring in every strut; its subclasses each do one thing wrong."""

    id, place, title, equation, source = "spring", "suspension", "a spring", "k x", "Hooke"
    names, unit, scale, least, most = ("k_N_m",), "N/m", 2000.0, 0.0, 1e9
    stiffness = staticmethod(lambda theta: theta["k_N_m"])

    def parameters_for(self, vehicle, channels):
        limits = {"lower": self.least, "upper": self.most}
        return tuple(Amplitude(n, self.unit, "stiffness", self.scale, **limits) for n in self.names)

    def modify(self, theta, vehicle, parts):
        for strut in struts(vehicle):
            parts.add_spring(strut.row, self.stiffness(theta))


WRONG = {
    "still changes": {"stiffness": staticmethod(lambda theta: 1000.0 + theta["k_N_m"])},
    "nothing changes with k_N_m": {"stiffness": staticmethod(lambda theta: 0.0)},
    "two parameters are called k_N_m": {"names": ("k_N_m", "k_N_m")},
    "its name ends in N/m": {"unit": "N"},
    "has scale 0": {"scale": 0.0},
    "outside its bounds": {"least": 1.0},
    "derive it from wheelhop.effects.WheelShape": {"wheel_path": lambda *_: None},
    "no equation": {"equation": None},
    'place = "strut"': {"place": "strut"},
    "does not apply to this vehicle": {"on_vehicle": False},
}


@pytest.mark.parametrize("name", OWN)
def test_wheelhop_s_own_effects_pass(name):
    table = wh.check_effect(wh.load_effects()[name])
    assert table["change"].dropna().gt(0).any()


def test_a_spring_passes_and_changes_as_much_as_it_is_stiff():
    soft, stiff = (
        wh.check_effect(type("S", (Spring,), {"scale": scale}))["change"].iloc[0]
        for scale in (20.0, 40.0)
    )
    assert stiff == pytest.approx(2 * soft, rel=0.02)


@pytest.mark.parametrize("what", WRONG)
def test_what_an_effect_does_wrong_is_one_line(what):
    with pytest.raises(wh.InputError, match=what):
        wh.check_effect(type("Wrong", (Spring,), WRONG[what]))


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Install a package by what pip would write: its code, and a dist-info with the entry point."""

    def install(code, value):
        (tmp_path / "brought.py").write_text(code)
        info = tmp_path / "brought-1.0.dist-info"
        info.mkdir()
        (info / "METADATA").write_text("Metadata-Version: 2.1\nName: brought\nVersion: 1.0\n")
        (info / "entry_points.txt").write_text(f"[wheelhop.effects]\nx = {value}\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, "brought", raising=False)

    return install


CODE = """
from wheelhop.effects.dry_friction import DryFriction

class First(DryFriction):
    id = "first"

class Second(DryFriction):
    id = "second"

both = [First, Second()]
"""


@pytest.mark.parametrize(
    ("value", "ids"),
    [
        ("brought:First", {"first"}),
        ("brought", {"first", "second"}),
        ("brought:both", {"first", "second"}),
    ],
)
def test_a_package_brings_effects(installed, value, ids):
    before = set(wh.load_effects())
    installed(CODE, value)
    assert set(wh.load_effects()) - before == ids


@pytest.mark.parametrize(
    ("code", "said"),
    [
        ("1 / 0", "package brought: does not load: ZeroDivisionError"),
        ("nothing = 1", "package brought: holds no effect"),
    ],
)
def test_a_package_that_brings_none_is_named(installed, code, said):
    installed(code, "brought")
    with pytest.raises(wh.CampaignError, match=said):
        wh.load_effects()


def test_the_template_passes_its_own_tests(monkeypatch, installed):
    monkeypatch.syspath_prepend(str(TEMPLATE / "src"))
    installed("", "orifice_damper")
    namespace = {}
    exec((TEMPLATE / "tests/test_orifice_damper.py").read_text(), namespace)
    namespace["test_it_does_what_every_effect_must"]()
    namespace["test_it_is_found_once_it_is_installed"]()
    force = namespace["test_the_force_opposes_the_motion_and_grows_with_its_square"]
    force(-0.5)


def test_objects_and_classes_are_libraries_and_ids():
    library = wh.load_effects([Spring, DryFriction()])
    assert isinstance(library["spring"], Spring)
    assert wh.load_effects(Spring()).keys() == wh.load_effects(Spring).keys()
    made = wh.simulate(
        wh.read_vehicle(TEMPLATE.parent / "clean"), "washboard/low", 8.0, Spring, seconds=2
    )
    assert len(made) == 1
    with pytest.raises(wh.CampaignError, match="is no effect"):
        wh.load_effects([int])
