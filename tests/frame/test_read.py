"""Frame files: what they say, and one line for each mistake."""

from pathlib import Path

import pytest

from wheelhop.frame import FrameError, read_frame

EXAMPLE = Path(__file__).parents[2] / "examples/frame/baja.toml"

TEXT = """
format = 1
name = "box"
[material]
E_GPa = 205
nu = 0.29
density_kg_m3 = 7850
[section.main]
outer_diameter_mm = 25
wall_thickness_mm = 2
[section.bar]
A_mm2 = 100
Iy_mm4 = 800
Iz_mm4 = 900
J_mm4 = 1500
[node]
a = [1.4, 0.5, 0]
b = [1.4, -0.5, 0]
c = [0, -0.5, 0]
d = [0, 0.5, 0]
[[tube]]
nodes = ["a", "b", "c", "d", "a"]
section = "main"
[[tube]]
from = "a"
to = "c"
section = "bar"
up = [0, 1, 0]
[[mass]]
node = "a"
mass_kg = 10
inertia_kg_m2 = [0.1, 0.2, 0.3]
[interface]
FL = "a"
FR = "b"
RL = "d"
RR = "c"
steering = "b"
"""


def write(folder, *changes):
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    file = folder / "box.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_a_file_says_what_it_says(tmp_path):
    frame = read_frame(write(tmp_path))
    assert [(t.start, t.end, t.section) for t in frame.tubes] == [
        ("a", "b", "main"), ("b", "c", "main"), ("c", "d", "main"), ("d", "a", "main"),
        ("a", "c", "bar"),
    ]  # fmt: skip
    assert frame.tubes[4].up == (0, 1, 0)
    assert frame.material.shear_Pa == pytest.approx(205e9 / 2.58)
    assert frame.sections["bar"].Iz_m4 == pytest.approx(9e-10)
    assert frame.sections["main"].area_m2 == pytest.approx(144.5e-6, rel=1e-3)
    assert frame.masses[0].inertia_kg_m2 == (0.1, 0.2, 0.3)
    assert frame.interface["steering"] == "b"


def test_the_shear_modulus_may_stand_for_poissons_ratio(tmp_path):
    by_nu = read_frame(write(tmp_path)).material
    by_g = read_frame(write(tmp_path, ("nu = 0.29", f"G_GPa = {205 / 2.58}"))).material
    assert by_g.shear_Pa == pytest.approx(by_nu.shear_Pa)
    assert by_g.poisson == pytest.approx(0.29)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("d = [0, 0.5, 0]", "d = [0, 0.5, 0]\ne = [1, 1, 1]", "[node]: e is not connected"),
        ("b = [1.4, -0.5, 0]", "b = [1.4, 0.5, 0]", "b lies where a lies"),
        ("b = [1.4, -0.5, 0]", "b = [1.4, 0.49999, 0]", "from a to b has no length"),
        ("mass_kg = 10", "mass_kg = -10", '[[mass]] "a": mass_kg = -10 must'),
        ("[0.1, 0.2", "[0.1, -0.2", "must not be negative"),
        ("wall_thickness_mm = 2", "wall_thickness_mm = -2", "[section.main]: wall_thickness_mm"),
        ("wall_thickness_mm = 2", "wall_thickness_mm = 13", "more than the radius, 12.5 mm"),
        ('"c", "d", "a"]', '"c", "x", "a"]', 'there is no node "x"'),
        ('node = "a"', 'node = "z"', '[[mass]] "z": there is no node "z"'),
        ('FR = "b"', 'FR = "q"', '[interface]: there is no node "q"'),
        ('section = "bar"', 'section = "bat"', "no [section.bat], did you mean 'bar'?"),
        ('to = "c"', 'to = "b"', "from a to b is listed twice"),
        ('to = "c"', 'to = "a"', "from a to a has no length"),
        ("[material]", "[materials]", "unknown key 'materials', did you mean 'material'?"),
        ("[material]\nE_GPa = 205\nnu = 0.29\ndensity_kg_m3 = 7850", "", "'material' is missing"),
        ("E_GPa = 205", "E_MPa = 205000", "write E_GPa = 205"),
        ("nu = 0.29", "nu = 0.6", "nu = 0.6 must be less than 0.5"),
        ("nu = 0.29", "nu = 0.29\nG_GPa = 79", "give either nu or G_GPa"),
        ("nu = 0.29", "G_GPa = 20", "must lie between E/3 and E/2"),
        ("A_mm2 = 100", "A_mm2 = 0", "[section.bar]: A_mm2 = 0 must not be below"),
        ("J_mm4 = 1500", "", "[section.bar]: 'J_mm4' is missing"),
        ("a = [1.4, 0.5, 0]", "a = [1.4, 0.5]", "[node]: a must be three numbers"),
        ("a = [1.4, 0.5, 0]", "a = [1e300, 0.5, 0]", "[node]: a lies more than 1000 m away"),
        ("A_mm2 = 100", "A_mm2 = 1e300", "A_mm2 = 1e+300 must be less than"),
        ('FL = "a"', "", "[interface]: 'FL' is missing"),
        ('FL = "a"', 'FL = "c"', "must be four different nodes"),
        ('FL = "a"\nFR = "b"\nRL = "d"', 'FL = "d"\nFR = "b"\nRL = "a"', "FL must lie ahead"),
        ('FL = "a"\nFR = "b"', 'FL = "b"\nFR = "a"', "FL must lie to the left of FR"),
        ("up = [0, 1, 0]", "up = [0, 0, 0]", "up is a direction, such as up = [0, 0, 1]"),
        ("up = [0, 1, 0]", "up = [1.4, 1, 0]", "up must not point along the tube"),
        ('from = "a"', 'nodes = ["a", "b"]', "give either nodes, or from and to"),
        ('name = "box"', 'name = "box"\nelement_mm = 0', "element_mm"),
    ],
)  # fmt: skip
def test_each_mistake_is_one_line_with_file_and_key(tmp_path, old, new, says):
    file = write(tmp_path, (old, new))
    with pytest.raises(FrameError) as caught:
        read_frame(file)
    assert str(caught.value).startswith(f"{file}: ")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_frame_in_two_pieces_is_none(tmp_path):
    apart = 'd = [0, 0.5, 0]\ne = [0, 0, 1]\nf = [1, 0, 1]\n[[tube]]\nfrom = "e"\nto = "f"'
    file = write(tmp_path, ("d = [0, 0.5, 0]", f'{apart}\nsection = "main"'))
    with pytest.raises(FrameError, match="e is not connected with a"):
        read_frame(file)


def test_a_frame_without_nodes_is_none(tmp_path):
    file = write(tmp_path)
    text = file.read_text(encoding="utf-8")
    empty = text[: text.index("[node]")] + "[node]\n" + text[text.index("[[tube]]") :]
    file.write_text(empty, encoding="utf-8")
    with pytest.raises(FrameError, match="there are no nodes"):
        read_frame(file)


def test_the_example_is_a_plausible_frame():
    frame = read_frame(EXAMPLE)
    assert 25 <= len(frame.nodes) <= 40
    assert "Illustrative" in EXAMPLE.read_text(encoding="utf-8")
