"""`wheelhop frame`."""

import json

import pytest

from tests.frame.frames import CORNERS, ladder
from tests.frame.test_read import EXAMPLE, write
from wheelhop.cli.main import main
from wheelhop.frame import assemble, free_modes, read_frame


def test_it_prints_and_writes_mass_stiffness_modes_and_a_figure(tmp_path, capsys):
    result, figure = tmp_path / "f.json", tmp_path / "f.png"
    arguments = ["--modes", "7", "--json", str(result), "--figure", str(figure)]
    assert main(["frame", str(EXAMPLE), *arguments]) == 0
    out = capsys.readouterr().out
    for words in ("N m/deg", "first torsional mode", "frame-twist", "centre of gravity"):
        assert words in out
    found = json.loads(result.read_text(encoding="utf-8"))
    assert 25 <= found["mass_kg"] - found["carried_kg"] <= 40
    frequencies = [mode["freq_hz"] for mode in found["frame_twist"]]
    wanted = free_modes(assemble(read_frame(EXAMPLE)), 7).frequency_hz
    assert frequencies == pytest.approx(wanted)
    assert figure.read_bytes().startswith(b"\x89PNG")


def test_a_mode_that_twists_nothing_is_not_called_torsional(tmp_path, capsys):
    """The ladder's first mode bends it in its plane."""
    result = tmp_path / "f.json"
    lines = ["format = 1", 'name = "ladder"', "[material]", "E_GPa = 200", "G_GPa = 77"]
    lines += ["density_kg_m3 = 7800", "[section.s]", "outer_diameter_mm = 30"]
    lines += ["wall_thickness_mm = 2", "[node]"]
    frame = ladder()
    lines += [f"{name} = {list(place)}" for name, place in frame.nodes.items()]
    for tube in frame.tubes:
        lines += ["[[tube]]", f'nodes = ["{tube.start}", "{tube.end}"]', 'section = "s"']
    lines += ["[interface]", *(f'{corner} = "{corner}"' for corner in CORNERS)]
    file = tmp_path / "ladder.toml"
    file.write_text("\n".join(lines), encoding="utf-8")
    assert main(["frame", str(file), "--modes", "1", "--json", str(result)]) == 0
    assert "None of these modes makes a tenth of the twist" in capsys.readouterr().out
    assert json.loads(result.read_text(encoding="utf-8"))["first_torsional_mode"] is None
    assert main(["frame", str(file), "--modes", "2", "--json", str(result)]) == 0
    assert json.loads(result.read_text(encoding="utf-8"))["first_torsional_mode"] == 2


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["nowhere.toml"], "no such file"),
        ([str(EXAMPLE), "--modes", "0"], "--modes 0: give a number from 1 to 200"),
        ([str(EXAMPLE), "--figure", "nowhere/f.png"], "there is no folder"),
    ],
)
def test_a_mistake_is_one_line(arguments, says, capsys):
    assert main(["frame", *arguments]) == 2
    error = capsys.readouterr().err
    assert says in error and error.count("\n") == 1


def test_elements_too_small_are_refused_and_not_computed(tmp_path, capsys):
    file = write(
        tmp_path, ("a = [1.4,", "a = [999,"), ('name = "box"', 'name = "box"\nelement_mm = 10')
    )
    assert main(["frame", str(file)]) == 2
    assert "element_mm" in capsys.readouterr().err
