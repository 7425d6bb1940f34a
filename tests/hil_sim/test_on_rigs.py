"""A calibration and a synchronicity check on an emulated logger, as the documents tell them."""

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from tests.patience import wait_until
from wheelhop.calibration import read_constants
from wheelhop.cli.emulate import run as emulate
from wheelhop.cli.main import main
from wheelhop.hil_sim.day import drive_lines, read_day
from wheelhop.hil_sim.emulated import emulated_logger
from wheelhop.hil_sim.on_rigs import on_rig, shaker
from wheelhop.logger import LoggerError

DOCS = Path(__file__).parents[2] / "docs"
FACTOR = 25.0


def rehearsed(page, rig, monkeypatch, folder):
    """Type what a page says behind `wheelhop emulate --on RIG`; the exit status of the last."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
    monkeypatch.chdir(folder)
    text = (DOCS / page).read_text(encoding="utf-8")
    lines = re.findall(r"^ {4}wheelhop (.*)$", text.partition(f"emulate --on {rig}")[2], re.M)
    with emulated_logger(None, FACTOR, (on_rig(rig, folder / "rehearsal"),)) as (double, _):
        assert main(shlex.split(lines[0], comments=True)) == 0
        wait_until(lambda: double.totals["due"] > 0)
    return main(shlex.split(lines[1], comments=True))


@pytest.mark.slow
def test_the_shakers_constants_are_those_that_nobody_was_told(tmp_path, monkeypatch, capsys):
    assert rehearsed("calibration.md", "shaker", monkeypatch, tmp_path) == 0
    found = read_constants(tmp_path / "rehearsal/calibration.toml")
    errors = []
    for sensor in shaker().sensors:
        gain = found.of(sensor.name).gain
        true = sensor.gain_m_s2_per_code / np.cos(sensor.tilt_rad)
        errors.append(abs(gain.value - true) / gain.expanded)
    assert np.median(errors) < 1.0 and max(errors) < 2.5
    assert "clocks" in capsys.readouterr().out


def test_the_beams_channels_are_in_step(tmp_path, monkeypatch, capsys):
    assert rehearsed("synchronicity.md", "beam", monkeypatch, tmp_path) == 0
    assert "in step: all channels" in capsys.readouterr().out


def test_files_that_are_there_stay_as_they_are(tmp_path):
    on_rig("beam", tmp_path)
    own = (tmp_path / "beam.toml").read_text().replace("34.0", "33.0")
    (tmp_path / "beam.toml").write_text(own)
    words, _ = on_rig("beam", tmp_path)
    assert "15 and 33 Hz" in words and (tmp_path / "beam.toml").read_text() == own


@pytest.mark.parametrize(
    ("on", "files", "campaign"),
    [("beam", None, None), (None, Path("x"), None), ("shaker", Path("x"), Path("y"))],
)
def test_a_rig_needs_a_folder_and_no_campaign(arguments, on, files, campaign):
    with pytest.raises(LoggerError, match="--files"):
        emulate(arguments(on=on, files=files, campaign=campaign))


@pytest.fixture
def arguments():
    from argparse import Namespace

    return lambda **given: Namespace(**{"factor": 10.0, "card": None, "run": None, **given})


def test_drives_are_told_as_campaign_add_asks_for_them():
    lines = drive_lines(read_day().drives)
    assert len(lines) == 8
    assert lines[3] == (
        "herringbone-low-fast (fit): --track herringbone amplitude_mm=10 pitch_mm=500"
        " angle_deg=20 --speed-kmph 14"
    )
