"""What the header of an OpenCRG file may hold (ASAM OpenCRG 1.2, sections 3.2 to 3.4)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.track.opencrg import read_opencrg
from wheelhop.track.write import write_opencrg

CRG = b"""$CT                                 ! free text
made for a test
$!*********************************
$ROAD_CRG
REFERENCE_LINE_START_U   = 0.0
REFERENCE_LINE_END_U     = 9.0
REFERENCE_LINE_INCREMENT = 1.0
LONG_SECTION_V_RIGHT     =-0.50
LONG_SECTION_V_LEFT      = 0.50
LONG_SECTION_V_INCREMENT = 0.50
$!*********************************
$KD_Definition
#:LRFI
U:reference line u,m,0,1.0
D:long section 1,m
D:long section 2,m
D:long section 3,m      ! $$$$ in a remark
$!*********************************
* Data begin after the $$$$ line below.
$$$$$$$$10$$$$$$$$20$$$$$$$$30$$$$$$$$40$$$$$$$$50$$$$$$$$60$$$$$$$$70$$$$$$$$80
"""
HEIGHT = np.round(0.01 * np.sin(0.4 * np.arange(10.0))[:, None] * [1.0, 2.0, 3.0], 7)


def crg_text() -> bytes:
    rows = ["".join(f"{value:10.7f}" for value in row) for row in HEIGHT]
    return CRG + "\n".join(rows).encode() + b"\n"


def written(folder: Path, content: bytes) -> Path:
    file = folder / "road.crg"
    file.write_bytes(content)
    return file


def test_only_a_line_that_begins_with_dollars_ends_the_header(tmp_path):
    """As in ASAM's handmade_straight.crg, whose comment speaks of "the $$$$ separator line"."""
    grid = read_opencrg(written(tmp_path, crg_text()))
    np.testing.assert_array_equal(grid.height_m, HEIGHT)
    np.testing.assert_array_equal(grid.v_m, [-0.5, 0.0, 0.5])
    np.testing.assert_array_equal(grid.u_m, np.arange(10.0))


def test_its_roughness_is_told_and_its_heights_are_written(tmp_path, capsys):
    file, out = written(tmp_path, crg_text()), tmp_path / "grid.csv"
    words = ["road", f"profile:file={file}", "--step", "0.1", "--grid", "--out", str(out)]
    assert main(words) == 0
    head, *rows = out.read_text().splitlines()
    assert head == "x_m,-0.5,0,0.5" and len(rows) == 91
    at_1_m = dict(row.split(",", 1) for row in rows)["1"]
    np.testing.assert_allclose([float(z) for z in at_1_m.split(",")], HEIGHT[1], atol=1e-12)


def test_line_ends_of_another_system_change_nothing_in_text(tmp_path):
    grid = read_opencrg(written(tmp_path, crg_text().replace(b"\n", b"\r\n")))
    np.testing.assert_array_equal(grid.height_m, HEIGHT)


def test_where_no_data_code_is_said_numbers_are_of_four_bytes(tmp_path):
    """Section 3.4.3: "If no data format is defined, road data is considered to use KRBI"."""
    content = CRG.replace(b"#:LRFI\n", b"") + HEIGHT.astype(">f4").tobytes()
    np.testing.assert_allclose(read_opencrg(written(tmp_path, content)).height_m, HEIGHT, rtol=1e-6)


def test_stations_that_only_fill_the_last_record_are_none(tmp_path):
    """Section 3.4.7: the last record of 80 bytes is padded with NaN: here three stations."""
    content = CRG.replace(b"#:LRFI", b"#:KRBI").replace(
        b"REFERENCE_LINE_END_U", b"* it is not said"
    )
    data = HEIGHT[:7].astype(">f4").tobytes()  # 84 bytes
    data += np.full((160 - len(data)) // 4, np.nan, ">f4").tobytes()
    assert read_opencrg(written(tmp_path, content + data)).height_m.shape == (7, 3)


def test_what_is_written_is_padded_with_nan(tmp_path):
    write_opencrg(tmp_path / "out.crg", np.arange(10.0), np.array([-0.5, 0.0, 0.5]), HEIGHT)
    content = (tmp_path / "out.crg").read_bytes()
    data = np.frombuffer(content[content.rindex(b"$\n") + 2 :], ">f8")
    assert len(data) % 10 == 0 and np.isnan(data[30:]).all()
    np.testing.assert_array_equal(read_opencrg(tmp_path / "out.crg").height_m, HEIGHT)


def test_long_sections_are_placed_by_their_numbers(tmp_path):
    content = crg_text().replace(b"section 1", b"section x").replace(b"section 3", b"section 1")
    grid = read_opencrg(written(tmp_path, content.replace(b"section x", b"section 3")))
    np.testing.assert_array_equal(grid.height_m, HEIGHT[:, ::-1])


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (b" 0.0116826", b" 0.01l6826", "line 22: column 21: '0.01l6826' is no number"),
        (b" 0.0116826", b"          ", "line 22: column 21: '' is no number"),
        (b" 0.0116826", b" 0.0116826 0.1", "line 22: goes beyond column 30"),
        (b"END_U     = 9.0", b"END_U     = 8.0", "holds 10 stations, and its header says 9"),
        (b"END_U     = 9.0", b"END_U     = 1e99", "holds 10 stations, and its header says 1e+99"),
        (b"END_U     = 9.0", b"END_U     =-9.0", "holds 10 stations, and its header says -8"),
        (b"END_U     = 9.0", b"END_U     = nan", "line 6: reference_line_end_u = 'nan' is no"),
        (b"INCREMENT = 1.0", b"INCREMENT = 1 m", "line 7: reference_line_increment = '1 m' is no"),
        (b"V_LEFT      = 0.50", b"V_LEFT      = 1.50", "3 long sections do not fit"),
        (b"section 3,m", b"section 4,m", "line 15: number long sections from 1 to 3"),
        (b"section 3,m", b"section at v = 0.5,m", "line 17: number all long sections, or place"),
        (b"section 2,m", b"section 2,mm", "line 16: the unit of 'long section 2' is 'mm'"),
        (b"#:LRFI", b"#:LRBI", "line 13: '#:LRBI': no data code"),
        (b"\n$$$$", b"\n$!$$$$", "no line of $$$$ ends the header"),
        (b"$ROAD_CRG\n", b"$ROAD_CRG_FILE\nother.crg\n$\n$ROAD_CRG\n", "line 5: $ROAD_CRG_FILE is"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_line_that_says_where(old, new, said, tmp_path):
    content = crg_text()
    assert content.count(old) == 1
    file = written(tmp_path, content.replace(old, new))
    with pytest.raises(CampaignError) as error:
        read_opencrg(file)
    assert str(error.value).startswith(f"{file}: {said}")
    assert "\n" not in str(error.value)
