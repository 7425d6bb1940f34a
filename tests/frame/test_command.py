"""`wheelhop frame`."""

import json

import pytest

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
