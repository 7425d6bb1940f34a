"""What is taken away repeats the session: the user's own effects come along."""

import shlex

import pytest

import wheelhop as wh
from wheelhop.cli.parser import make_parser
from wheelhop.workbench.session import Choice
from wheelhop.workbench.shown import Number
from wheelhop.workbench.takeaway import commands, script
from wheelhop.workbench.vehicle_view import fitted


@pytest.fixture(scope="module")
def campaign(small):
    return wh.read(small)


def test_commands_and_script_load_the_user_s_effects(campaign, tmp_path):
    file = tmp_path / "my 'own' effects.py"
    choice = Choice(added=("dry-friction", "quintic spring"))
    lines = commands(campaign, choice, file)
    assert len(lines) == 3
    for line in lines:
        given = make_parser().parse_args(shlex.split(line)[1:])
        effects = given.effects_file if given.command == "add" else given.effects
        assert effects == file, line
    text = script(campaign, choice, file)
    compile(text, "repeat.py", "exec")
    assert f"effects={str(file)!r}" in text
    assert "effects" not in " ".join(commands(campaign, choice, None))
    assert "effects=" not in script(campaign, choice, None)


def test_what_if_begins_at_the_fitted_vehicle():
    nominal = {"body.mass_kg": 228.0, "geometry.cg_height_m": 0.52}
    numbers = {"body.mass_kg": Number(228.0, 20.0, 250.0, 1.0)}
    assert fitted(nominal, numbers) == {"body.mass_kg": 250.0, "geometry.cg_height_m": 0.52}
    assert fitted(nominal, {}) == nominal
