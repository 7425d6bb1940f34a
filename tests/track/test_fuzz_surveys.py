"""Damaged surveys: whatever a file holds, it is a track of finite heights or one line that says
which file and what is wrong, never a traceback."""

from __future__ import annotations

import warnings
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.track.test_formats import ADAMS, LINES
from tests.track.test_opencrg_header import CRG, crg_text
from wheelhop.campaign import CampaignError
from wheelhop.cli.main import main
from wheelhop.track.surveyed import SurveyedGrid, read_survey

BINARY = CRG.replace(b"LRFI", b"KDBI") + np.linspace(0.0, 0.1, 30).astype(">f8").tobytes()
PATHS = b"x_m,left_m,right_m\n0,0,0\n0.5,0.01,0.02\n1.0,0.02,0.01\n"
GRID = b"x_m,-0.5,0,0.5\n0,0,0,0\n0.5,0.01,,0.02\n1.0,0.02,0.01,0\n"
WHOLE = {
    "text.crg": crg_text(),
    "binary.crg": BINARY,
    "surface.rdf": ADAMS.encode(),
    "lines.rdf": LINES.encode(),
    "paths.csv": PATHS,
    "grid.csv": GRID,
}
TOKENS = (
    *(b"$", b"$$$$", b"\n$$$$\n", b"!", b"*", b"#:", b"D:", b"U:", b"=", b",", b":", b"\n", b"\r"),
    *(b"nan", b"inf", b"-1", b"0", b"1e999", b"1e308", b"1e-320", b"-1e308", b"1_0", b"9" * 5000),
    *(b"\0", b"\xff", b"\xb2", b"\x85", b'"', b"'", b"mm", b"LDFI", b"KRBI", b"{", b"[", b"]"),
    *(b"[OFFSET]\nX = a\n", b"(XZ_DATA)", b"[NODES]", b"$ROAD_CRG\n", b"at v = ", b"\xef\xbb\xbf"),
)
NEW = st.one_of(st.sampled_from(TOKENS), st.binary(max_size=8))
CHANGES = st.lists(st.tuples(st.floats(0.0, 1.0), st.integers(0, 40), NEW), min_size=1, max_size=4)
"""Where in the file, how much of it goes, and what comes there."""


def changed(whole: bytes, changes: list[tuple[float, int, bytes]]) -> bytes:
    for share, gone, new in changes:
        at = round(share * len(whole))
        whole = whole[:at] + new + whole[at + gone :]
    return whole


@pytest.mark.parametrize("name", WHOLE)
@settings(max_examples=200)
@given(changes=CHANGES)
def test_a_survey_that_is_damaged_is_read_or_refused_in_one_line(name, changes):
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        file = Path(folder) / name
        file.write_bytes(changed(WHOLE[name], changes))
        try:
            track = read_survey(str(file))
            left, right = (track.elevation(track.x_m, y) for y in ends(track))
        except CampaignError as error:
            assert str(error).startswith(str(file)), error
            assert "\n" not in str(error)
        else:
            assert np.isfinite([left, right]).all()


def ends(track) -> tuple[float, float]:
    if isinstance(track, SurveyedGrid):
        return float(track.y_m[-1]), float(track.y_m[0])
    return 0.5, -0.5


@pytest.mark.parametrize("name", WHOLE)
@settings(max_examples=20)
@given(changes=CHANGES, step=st.sampled_from(["0.001", "0.01", "1e-9", "nan", "1"]))
def test_the_roughness_of_a_damaged_survey_is_printed_or_refused(name, changes, step):
    with TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        Path(name).write_bytes(changed(WHOLE[name], changes))
        words = ["road", f"profile:file={name}", "--step", step, "--out", "out.csv", "--grid"]
        assert main(words) in (0, 2)
        assert Path("out.csv").exists() or main(words) == 2
