"""Modes that Nastran has found, printed as pyNastran 1.4.1 prints them (data/nastran/make_f06.py),
beside those of the same beams."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import Channel
from wheelhop.cli.main import main
from wheelhop.files import InputError
from wheelhop.frame import FrameError, read_corner_modes
from wheelhop.simulate import Model, frequency_response
from wheelhop.vehicle import read_vehicle

ROOT = Path(__file__).parents[2]
DATA = ROOT / "tests/data/nastran"
FRAME = """format = 1
name = "a frame"
bdf = "small.bdf"
bdf_units = "mm-t-s"
{}
[interface]
FL = "40"
FR = "60"
RL = "50"
RR = "20"
"""


HZ = (0.5, 2.0, 5.0)


@pytest.fixture
def folder(tmp_path):
    for name in ("small.bdf", "modes.f06"):
        shutil.copy(DATA / name, tmp_path / name)
    (tmp_path / "printed.toml").write_text(FRAME.format('f06 = "modes.f06"'))
    (tmp_path / "beams.toml").write_text(FRAME.format(""))
    return tmp_path


def test_printed_modes_are_those_of_the_beams(folder):
    printed, beams = (read_corner_modes(folder / f"{name}.toml") for name in ("printed", "beams"))
    np.testing.assert_allclose(printed.position, beams.position, atol=1e-9)
    np.testing.assert_allclose(printed.frequency_hz[:8], beams.frequency_hz[:8], rtol=3e-3)
    assert len(printed.frequency_hz) == 44  # without the six at 0 Hz
    for k in range(4):  # the fourth is printed at another scale, with its generalised mass
        one, other = printed.height[:, k], beams.height[:, k]
        assert abs(one @ other) == pytest.approx(other @ other, rel=0.03)
        assert one @ one == pytest.approx(other @ other, rel=0.03)


def test_a_car_on_printed_modes_is_the_car_on_the_beams(folder):
    """As far as modes beyond the 44th, which are not printed, give way little."""
    text = (ROOT / "examples/clean/vehicle.toml").read_text(encoding="utf-8")
    corners = [Channel(name, name) for name in ("B1", "B2", "B3", "B4")]
    found = []
    for name in ("printed", "beams"):
        file = folder / "vehicle.toml"
        file.write_text(f'{text}\n[frame]\nfile = "{name}.toml"\nmodes = 8\n', encoding="utf-8")
        values = read_vehicle(file).values
        found.append(frequency_response(Model(values).system(corners, "road"), HZ))
    rigid = read_vehicle(ROOT / "examples/clean/vehicle.toml").values
    still = frequency_response(Model(rigid).system(corners, "road"), HZ)
    assert np.abs(found[0] - found[1]).max() < 0.1 * np.abs(found[1] - still).max()


def test_elements_that_are_no_beams_do_not_matter(folder):
    bdf = folder / "small.bdf"
    bdf.write_text(bdf.read_text().replace("CBAR   ", "CROD   ") + "CQUAD4,900,1,10,20,30,40\n")
    assert len(read_corner_modes(folder / "printed.toml").frequency_hz) == 44
    with pytest.raises(FrameError, match=r"CQUAD4|CROD"):
        read_corner_modes(folder / "beams.toml")


def test_a_campaign_takes_the_print_out_along(folder):
    text = (ROOT / "examples/clean/vehicle.toml").read_text(encoding="utf-8")
    file = folder / "vehicle.toml"
    file.write_text(f'{text}\n[frame]\nfile = "printed.toml"\n', encoding="utf-8")
    words = ["--tracks", "flat", "--speed", "8", "--seconds", "2", "--out", str(folder / "made")]
    assert main(["simulate", str(file), *words]) == 0
    assert (folder / "made/modes.f06").read_bytes() == (folder / "modes.f06").read_bytes()


VALUE = "1.646333E+02        2.620221E+01        1.0000"  # radians, cycles, mass of the seventh
RIGID = "E-05        1.000000E+00"


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: "", "no table of real eigenvalues"),
        (lambda text: text.partition("1    A FRAME")[0], "no table of real eigenvectors"),
        (lambda text: text.replace("            60      G", "            61      G"), "point 60"),
        (lambda text: text.replace(RIGID, RIGID.replace("-", "+", 1), 1), "5 modes"),
        (lambda text: text.replace(VALUE, VALUE.replace("1.0000", "-1.000")), "mass of -1"),
        (lambda text: text.replace("2.620221E+01", "2.6202x1E+01"), "'2.6202x1E[+]01' is not a"),
        (lambda text: text + text, "twice"),
    ],
)  # fmt: skip
def test_a_print_out_that_cannot_be_used_is_a_line(change, said, folder):
    file = folder / "modes.f06"
    text = file.read_text()
    assert change(text) != text
    file.write_text(change(text))
    with pytest.raises(FrameError, match=said) as error:
        read_corner_modes(folder / "printed.toml")
    assert "\n" not in str(error.value) and "modes.f06" in str(error.value)


def test_the_frame_command_says_where_such_modes_go(folder, capsys):
    assert main(["frame", str(folder / "printed.toml")]) == 2
    assert "wheelhop modes" in capsys.readouterr().err


def test_a_print_out_that_is_not_there_is_a_line(folder):
    (folder / "modes.f06").unlink()
    with pytest.raises(InputError, match=r"modes\.f06"):
        read_corner_modes(folder / "printed.toml")
