"""Measured grids from one format to the others: OpenCRG, CSV, Adams road data."""

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.track.rdf import write_rdf
from wheelhop.track.surveyed import read_survey
from wheelhop.track.write import write_grid, write_opencrg

BELGIAN_BLOCK = Path(__file__).parents[1] / "data/belgian-block/belgian_block.crg"
X, Y = 0.15 * np.arange(6), np.array([-0.75, -0.5, 0.0, 0.5])
HEIGHT = np.random.default_rng(5).normal(0.0, 0.02, (6, 4))
ADAMS = """$ a road
[MDI_HEADER]
FILE_TYPE = 'rdf'   ! a comment
[UNITS]
LENGTH = 'meter'
[MODEL]
METHOD = '3D'
[NODES]
NUMBER_OF_NODES = 4
{ node x_value y_value z_value }
1 0 -1 0.0
2 1 -1 0.1
3 0  1 0.2
4 1  1 0.3
[ELEMENTS]
NUMBER_OF_ELEMENTS = 2
{ node_1 node_2 node_3 mu }
1 2 3 1.0
2 4 3 1.0
"""
LINES = """[UNITS]
LENGTH = 'mm'
[MODEL]
METHOD = '2D'
ROAD_TYPE = 'poly_line'
[PARAMETERS]
MU = 0.9
(XZ_DATA)
{ x z_left z_right }
0     0  10
1000 20  30
"""


@pytest.fixture(scope="module")
def block(tmp_path_factory):
    """Every tenth line of the Belgian block, along all of it."""
    whole = read_survey(str(BELGIAN_BLOCK))
    file = tmp_path_factory.mktemp("block") / "block.crg"
    write_opencrg(file, whole.x_m, whole.y_m[::10], whole.height_m[:, ::10])
    return file


@pytest.mark.parametrize("suffix", [".csv", ".crg", ".rdf"])
def test_the_belgian_block_is_the_same_in_every_format(suffix, block, tmp_path, capsys):
    file = tmp_path / f"block{suffix}"
    words = ["road", f"profile:file={block}", "--out", str(file), "--grid"]
    assert main(words) == 0
    there, back = read_survey(str(block)), read_survey(str(file))
    np.testing.assert_allclose(back.y_m, there.y_m, atol=1e-9)
    np.testing.assert_allclose(back.x_m, there.x_m, atol=1e-9)
    np.testing.assert_allclose(back.height_m, there.height_m, atol=1e-9)
    assert f"{len(there.x_m)} stations" in capsys.readouterr().out  # its own 1 cm, not the usual 2


@pytest.mark.parametrize("write", [write_grid, write_rdf], ids=["csv", "rdf"])
def test_uneven_grids_with_holes_come_back(write, tmp_path):
    holes = HEIGHT.copy()
    holes[1, 0] = holes[4, 2] = np.nan
    file = tmp_path / ("grid.csv" if write is write_grid else "grid.rdf")
    write(file, X, Y, holes)
    found = read_survey(str(file))
    np.testing.assert_allclose(found.y_m, Y, atol=1e-9)
    known = np.isfinite(holes)
    expected = holes - holes[0].mean()
    np.testing.assert_allclose(found.height_m[known], expected[known], atol=1e-9)
    assert found.height_m[1, 0] == pytest.approx(expected[1, 1])  # an edge goes on
    assert found.height_m[4, 2] == pytest.approx((expected[4, 1] + expected[4, 3]) / 2)


def test_triangles_cover_the_grid_once_and_face_upwards(tmp_path):
    write_rdf(tmp_path / "grid.rdf", X, Y, HEIGHT)
    nodes, _, elements = (tmp_path / "grid.rdf").read_text().partition("[ELEMENTS]")
    rows = [line.split() for line in nodes.partition("z_value }\n")[2].splitlines()]
    place = {int(n): np.array([float(x), float(y)]) for n, x, y, _ in rows}
    area = 0.0
    for line in elements.partition("mu }\n")[2].splitlines():
        a, b, c = (place[int(node)] for node in line.split()[:3])
        (u, v), (p, q) = b - a, c - a
        assert u * q - v * p > 0.0
        area += (u * q - v * p) / 2
    assert area == pytest.approx(750.0 * 1250.0)


def test_adams_surfaces_and_lines_are_read(tmp_path):
    surface, lines = tmp_path / "surface.rdf", tmp_path / "lines.rdf"
    surface.write_text(ADAMS)
    lines.write_text(LINES)
    ground = read_survey(str(surface))
    assert ground.elevation(1.0, 1.0) == pytest.approx(0.2)  # the mean at the first station is 0
    tracks = read_survey(str(lines))
    left, right = (float(tracks.elevation(1.0, y)) for y in (0.6, -0.6))
    assert (left, right) == pytest.approx((0.015, 0.025))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("'meter'", "'furlong'", "LENGTH = 'furlong'"),
        ("'3D'", "'3D_SPLINE'", "METHOD = '3D_SPLINE'"),
        ("4 1  1 0.3\n", "", r"\[NODES\] has 3 rows, and NUMBER_OF_NODES = 4: cut off"),
        ("2 1 -1 0.1", "2 1 -1", "line 12: 4 numbers"),
        ("2 1 -1 0.1", "2 1 -1 low", "line 12: '2 1 -1 low' is no row of numbers"),
        ("2 1 -1 0.1", "2 1 -1 nan", "line 12: 4 numbers"),
        ("0.3", "3000", "look at LENGTH"),
        ("[NODES]", "[REFSYS]\nX = 1\n[NODES]", "REFSYS"),
        ("[MODEL]\n", "", "METHOD = ''"),
        ("[NODES]", "[OFFSET]\nX = far\n[NODES]", r"\[OFFSET\] X = far: must be a number"),
        ("NODES = 4", "NODES = ²", "NUMBER_OF_NODES = ²: cut off"),
        ("2 1 -1 0.1", "2 0 -1 0.1", "line 11: another node at this x and y has another z"),
    ],
)
def test_a_road_of_another_kind_or_damaged_is_a_line(old, new, said, tmp_path):
    file = tmp_path / "road.rdf"
    file.write_text(ADAMS.replace(old, new))
    with pytest.raises(CampaignError, match=said) as error:
        read_survey(str(file))
    assert "\n" not in str(error.value)


def test_scattered_nodes_are_no_grid(tmp_path):
    rng = np.random.default_rng(1)
    rows = "".join(f"{i} {x} {y} 0\n" for i, (x, y) in enumerate(rng.normal(size=(40, 2))))
    head, _, _ = ADAMS.partition("[NODES]")
    file = tmp_path / "road.rdf"
    file.write_text(f"{head}[NODES]\n{rows}")
    with pytest.raises(CampaignError, match="40 nodes are no grid"):
        read_survey(str(file))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x_m,-0.5,-0.5\n0,0,0\n1,0,0\n", "must differ"),
        ("x_m,-0.5,0.5\n0,0,0\n1,,\n", "line 3 needs a number"),
        ("x_m,-0.5,0.5\n0,0,0\n,1,1\n", "line 3 needs a number"),
        ("x_m,-0.5,0.5\n0,0,0\n1,0,high\n", "line 3 needs a number"),
        ("x_m,-0.5,0.5\n0,0,0\n0,0,0\n", "x_m must increase"),
    ],
)
def test_a_grid_that_makes_no_sense_is_a_line(text, said, tmp_path):
    file = tmp_path / "grid.csv"
    file.write_text(text)
    with pytest.raises(CampaignError, match=said):
        read_survey(str(file))
