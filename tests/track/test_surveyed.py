"""Measured tracks: CSV wheel paths and OpenCRG grids, good ones and damaged ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError, TrackSpec
from wheelhop.track import Track, make_track, wheel_envelope
from wheelhop.track.opencrg import read_opencrg

BELGIAN_BLOCK = Path(__file__).parents[1] / "data/belgian-block/belgian_block.crg"


def survey(file: Path) -> Track:
    return make_track(TrackSpec("profile", {"file": str(file)}))


def csv(folder: Path, text: str) -> Path:
    file = folder / "paths.csv"
    file.write_text(text)
    return file


# ---------------------------------------------------------------------------------- CSV


def test_each_side_has_its_own_wheel_path(tmp_path: Path) -> None:
    ground = survey(csv(tmp_path, "x_m,left_m,right_m\n3,0.01,0.05\n3.5,0.02,0.06\n4,0.03,0.07\n"))
    assert (ground.start_m, ground.end_m) == (0.0, 1.0)  # x counts from the first station
    for y, expected in ((0.6, [-0.02, -0.01, 0.0]), (-0.6, [0.02, 0.03, 0.04])):
        np.testing.assert_allclose(ground.elevation([0.0, 0.5, 1.0], y), expected, atol=1e-15)
        outside = ground.elevation([-9.0, 9.0], y)
        np.testing.assert_allclose(outside, [expected[0], expected[-1]], atol=1e-15)
    assert ground.elevation(0.5, 0.0) == pytest.approx(0.01)


def test_columns_may_stand_in_any_order_beside_others(tmp_path: Path) -> None:
    ground = survey(csv(tmp_path, "right_m,note,x_m,left_m\n0.1,a,0,0.2\n0.3,b,1,0.4\n"))
    np.testing.assert_allclose(ground.elevation([0.0, 1.0], 0.5), [0.05, 0.25])
    np.testing.assert_allclose(ground.elevation([0.0, 1.0], -0.5), [-0.05, 0.15])


def test_a_finely_surveyed_wave_comes_back(tmp_path: Path) -> None:
    x = np.arange(0, 4, 0.02)
    z = 0.02 * np.sin(2 * np.pi * x / 0.6)
    rows = "\n".join(f"{a:.4f},{b:.9f},{b:.9f}" for a, b in zip(x, z, strict=True))
    ground = survey(csv(tmp_path, "x_m,left_m,right_m\n" + rows))
    fine = np.linspace(0, 3.9, 4001)
    error = ground.elevation(fine, 0.5) - 0.02 * np.sin(2 * np.pi * fine / 0.6)
    assert np.abs(error).max() < 0.01 * 0.02


def test_a_surveyed_kerb_is_not_overshot(tmp_path: Path) -> None:
    ground = survey(csv(tmp_path, "x_m,left_m,right_m\n0,0,0\n1,0,0\n1.01,0.1,0.1\n2,0.1,0.1\n"))
    z = ground.elevation(np.linspace(-1, 3, 4001), 0.5)
    assert (z.min(), z.max()) == (0.0, pytest.approx(0.1))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "no column x_m"),
        ("x_m,left_m\n0,0\n1,0\n", "no column right_m"),
        ("x_m,left_m,right_m\n0,0,0\n", "1 station"),
        ("x_m,left_m,right_m\n0,0,0\n1,zero,0\n", "line 3 "),
        ("x_m,left_m,right_m\n0,0,0\n1,nan,0\n", "line 3 "),
        ("x_m,left_m,right_m\n0,0,0\n1,0\n", "line 3 "),
        ("x_m,left_m,right_m\n0,0,0\n1,0,0\n1,0,0\n", "line 4: x_m must increase"),
        ("x_m,left_m,right_m\n0,0,0\n1,250,0\n", "must be in metres"),
        ("x_m,left_m,right_m\n0,0,0\n1e-320,1,0\n", "station 2: x, m, must increase by 1e-06"),
        ("x_m,left_m,right_m\n-1e308,0,0\n0,1,0\n1e308,1,0\n", "station 3: x, m, must increase"),
    ],
)
def test_a_csv_that_makes_no_sense_is_refused(tmp_path: Path, text: str, complaint: str) -> None:
    file = csv(tmp_path, text)
    with pytest.raises(CampaignError) as error:
        survey(file)
    assert complaint in str(error.value)
    assert str(file) in str(error.value)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there_or_not_text_is_named(tmp_path: Path) -> None:
    with pytest.raises(CampaignError, match=r"missing\.csv: no such file"):
        survey(tmp_path / "missing.csv")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00x_m" * 20)
    with pytest.raises(CampaignError, match=r"binary\.csv"):
        survey(binary)


# ------------------------------------------------------------------------------ OpenCRG


def test_the_belgian_block_is_what_its_owner_says() -> None:
    grid = read_opencrg(BELGIAN_BLOCK)
    assert grid.height_m.shape == (1001, 341)
    np.testing.assert_allclose(grid.u_m[[0, -1]], [730.0, 740.0])
    np.testing.assert_allclose(grid.v_m[[0, -1]], [-1.7, 1.7])
    np.testing.assert_allclose(np.diff(grid.u_m), 0.01)
    assert np.isnan(grid.height_m).mean() == pytest.approx(0.065, abs=0.0005)
    u, centre = grid.u_m - 735.0, grid.height_m[:, 170]
    assert np.std(centre - np.polyval(np.polyfit(u, centre, 2), u)) == pytest.approx(
        0.024, abs=0.0005
    )


def test_a_wheel_runs_over_the_belgian_block() -> None:
    ground = survey(BELGIAN_BLOCK)
    assert (ground.start_m, ground.end_m) == (0.0, 10.0)
    x = np.linspace(0.0, 10.0, 3001)
    profile = ground.elevation(x, 0.59)
    height = wheel_envelope(ground, 0.59, 0.279, -5.0, 20.0).height(x)
    assert (height >= profile - 1e-5).all()
    assert np.abs(height - profile).max() < 0.05
    assert np.std(np.diff(height, 2)) < 0.5 * np.std(np.diff(profile, 2))  # joints are bridged
    left, right = (ground.elevation(x, y) for y in (0.59, -0.59))
    assert not np.allclose(left, right)


def test_missing_edges_go_on_as_the_last_measured_height() -> None:
    grid = read_opencrg(BELGIAN_BLOCK)
    ground = survey(BELGIAN_BLOCK)
    row = int(np.flatnonzero(np.isnan(grid.height_m[:, 0]))[0])
    edge = int(np.flatnonzero(np.isfinite(grid.height_m[row]))[0])
    beyond, at_edge = ground.elevation(grid.u_m[row] - grid.u_m[0], [-1.7, grid.v_m[edge]])
    assert beyond == pytest.approx(at_edge, abs=1e-9)


def test_a_path_beside_the_surveyed_strip_is_refused() -> None:
    with pytest.raises(CampaignError, match=r"y = 2\.00 m leaves the surveyed strip"):
        survey(BELGIAN_BLOCK).elevation(0.0, 2.0)


HEADER = """$CT
made for a test
$
$ROAD_CRG                      ! remarks may follow
REFERENCE_LINE_START_U   = 10.0
REFERENCE_LINE_END_U     = 12.0
reference_line_increment =  0.5
{lines}$
$KD_DEFINITION
#:{code}
U:reference line u,m,10,0.5
D:reference line phi,rad
{sections}$
$$$$$$$$$$$$$$$$$$
"""
HEIGHTS = np.round(0.02 * np.sin(np.arange(45.0).reshape(5, 9)), 4)
HEIGHTS[1, 0] = HEIGHTS[4, 8] = np.nan


def crg(
    folder: Path, code: str, lines: str = "long_section_v_right = -2\nlong_section_v_left = 2\n"
) -> Path:
    sections = "".join(f"D:long section {i + 1},m\n" for i in range(9))
    table = np.column_stack([[np.nan, 0.1, 0.1, 0.2, 0.2], HEIGHTS])
    head = HEADER.format(code=code, lines=lines, sections=sections).encode()
    if code in ("KRBI", "KDBI"):
        data = table.astype(">f4" if code == "KRBI" else ">f8").tobytes()
        data += b"\x7f\xc0\x00\x00" * 5
    else:
        width, per_line = (10, 8) if code == "LRFI" else (20, 4)
        data = b""
        for row in table:
            fields = ["*" * width if np.isnan(v) else f"{v:{width}.6f}" for v in row]
            for first in range(0, 10, per_line):
                data += "".join(fields[first : first + per_line]).encode() + b"\n"
    file = folder / f"{code}.crg"
    file.write_bytes(head + data)
    return file


@pytest.mark.parametrize("code", ["KRBI", "KDBI", "LRFI", "LDFI"])
def test_all_four_codes_are_read(tmp_path: Path, code: str) -> None:
    grid = read_opencrg(crg(tmp_path, code))
    np.testing.assert_allclose(grid.u_m, [10.0, 10.5, 11.0, 11.5, 12.0])
    np.testing.assert_allclose(grid.v_m, np.linspace(-2, 2, 9))
    np.testing.assert_allclose(grid.height_m, HEIGHTS, rtol=1e-6)


def test_a_surveyed_surface_is_linear_across(tmp_path: Path) -> None:
    ground = survey(crg(tmp_path, "KDBI"))
    between, right, left = ground.elevation(1.0, [0.875, 0.5, 1.0])
    assert between == pytest.approx(0.25 * right + 0.75 * left)
    assert left - right == pytest.approx(HEIGHTS[2, 6] - HEIGHTS[2, 5])


def test_long_sections_may_be_centred_or_stated_one_by_one(tmp_path: Path) -> None:
    file = crg(tmp_path, "LRFI", "LONG_SECTION_V_INCREMENT = 0.25\n")
    np.testing.assert_allclose(read_opencrg(file).v_m, np.linspace(-1, 1, 9))
    text = file.read_text()
    for i in range(9):  # from left to right: columns come back from right to left
        text = text.replace(f"long section {i + 1},m", f"long section at v = {2.0 - 0.3 * i:.2f},m")
    file.write_text(text)
    grid = read_opencrg(file)
    np.testing.assert_allclose(grid.v_m, np.linspace(-0.4, 2.0, 9))
    np.testing.assert_allclose(grid.height_m, HEIGHTS[:, ::-1])


def damaged(data: bytes) -> dict[str, bytes]:
    return {
        "truncated": data[: len(data) // 2],
        "end-of-line": data.replace(b"\n", b"\r\n"),
        "not an OpenCRG file": b"x_m,left_m\n0,0\n",
        "no data code": data.replace(b"#:KRBI", b"#:XXXX"),
        "at least two are needed": data.replace(b"D:long section", b"D:something"),
        "$ROAD_CRG_MODS is not supported": data.replace(
            b"$KD_DEFINITION", b"$ROAD_CRG_MODS\nscale_z_grid = 2\n$KD_DEFINITION"
        ),
        "reference_line_increment": data.replace(
            b"reference_line_increment =  1", b"reference_line_increment = -1"
        ),
        "where the long sections lie": data.replace(b"long_section_v_", b"other_section_v_"),
    }


@pytest.mark.parametrize("complaint", list(damaged(b"")))
def test_a_damaged_grid_is_refused_in_one_line(tmp_path: Path, complaint: str) -> None:
    file = tmp_path / "damaged.crg"
    file.write_bytes(damaged(BELGIAN_BLOCK.read_bytes())[complaint])
    with pytest.raises(CampaignError) as error:
        survey(file)
    assert complaint in str(error.value)
    assert str(error.value).startswith(str(file))
    assert "\n" not in str(error.value)


def test_a_row_without_any_height_is_refused(tmp_path: Path) -> None:
    file = crg(tmp_path, "LRFI")
    fields = ["*" * 10] * 10
    lines = file.read_text().splitlines()
    lines[-4:-2] = ["".join(fields[:8]), "".join(fields[8:])]
    file.write_text("\n".join(lines) + "\n")
    with pytest.raises(CampaignError, match="grid row 4 has no height"):
        survey(file)
