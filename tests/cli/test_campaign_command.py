"""`wheelhop campaign`: from a recording to a campaign that can be checked, by words alone."""

import re
import tomllib

import numpy as np
import pytest

from wheelhop.campaign import read_campaign
from wheelhop.campaign.sample import VEHICLE
from wheelhop.cli.main import main
from wheelhop.formats import write
from wheelhop.logger.recording import Channel, Recording

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")


@pytest.fixture
def recording(tmp_path):
    """Two drives of 20 and 10 s between rests."""
    rng = np.random.default_rng(3)
    level = np.repeat([0.02, 3.0, 0.02, 1.5, 0.02], [500, 2000, 500, 1000, 500])
    values = rng.normal(size=(len(level), 8)) * level[:, None]
    file = tmp_path / "day.csv"
    write(Recording(values, 100.0, tuple(Channel(n, "m/s²", n) for n in POINTS)), file)
    return file


def test_from_a_recording_to_a_campaign(recording, tmp_path, capsys):
    folder = tmp_path / "car"
    assert main(["campaign", "stretches", str(recording)]) == 0
    out = capsys.readouterr().out
    assert [line.split()[0] for line in out.splitlines() if line.strip()[:1].isdigit()] == [
        "1",
        "2",
    ]
    assert main(["campaign", "new", str(folder), str(recording), "--title", "our car"]) == 0
    assert "replace them by yours" in capsys.readouterr().out
    words = ["--speed-kmph", "7.5", "--track", "washboard", "amplitude_mm=15", "pitch_mm=400"]
    add = ["campaign", "add", str(folder), str(recording)]
    assert main([*add, "--id", "slow", "--stretch", "1", *words]) == 0
    late = ["--from", "31.5", "--to", "38"]
    assert main([*add, "--id", "fast", "--role", "validate", *late, *words]) == 0
    campaign = read_campaign(folder)
    slow, fast = campaign.runs
    assert campaign.title == "our car"
    assert (slow.id, slow.role, fast.id, fast.role) == ("slow", "fit", "fast", "validate")
    assert 17 < len(slow.time_s) / 100 <= 20 and len(fast.time_s) == 651
    assert slow.record.std() == pytest.approx(3.0, rel=0.05)
    assert main(["check", str(folder)]) == 0


def test_the_steady_part_of_a_stretch_is_the_run_on_a_track_that_goes_on_alike(tmp_path, capsys):
    """Rough ground for 6 s, the washboard for 20 s, rough ground for 6 s, between two rests."""
    rng = np.random.default_rng(3)
    rough, time_s = rng.normal(size=(4200, 8)), np.arange(4200) / 100.0
    level = np.repeat([0.02, 1.0, 0.02, 1.0, 0.02], [500, 600, 2000, 600, 500])
    driven = (time_s >= 11.0) & (time_s < 31.0)
    wave = 5.0 * np.sin(2 * np.pi * 5.2 * time_s) * driven
    file, folder = tmp_path / "day.csv", tmp_path / "car"
    channels = tuple(Channel(n, "m/s²", n) for n in POINTS)
    write(Recording(rough * level[:, None] + wave[:, None], 100.0, channels), file)
    assert main(["campaign", "stretches", str(file)]) == 0
    assert "steady" in capsys.readouterr().out
    assert main(["campaign", "new", str(folder), str(file)]) == 0
    add = ["campaign", "add", str(folder), str(file), "--stretch", "1", "--speed-kmph", "7.5"]
    board, bump = ["washboard/low"], ["half-sine-bump", "amplitude_mm=50", "length_mm=500"]
    asked = {
        "steady": ["--track", *board],
        "whole": ["--whole", "--track", *board],
        "bump": ["--track", *bump],
        "no-name": [],
    }
    for name, words in asked.items():
        assert main([*add, "--id", name, *words]) == 0
    out = capsys.readouterr().out
    assert "the steady part of stretch 1" in out and "all of stretch 1" in out
    lengths = {run.id: len(run.time_s) / 100 for run in read_campaign(folder).runs}
    assert lengths.pop("steady") == pytest.approx(19.0, abs=1.0)
    assert list(lengths.values()) == pytest.approx([32.0] * 3, abs=1.0)


@pytest.mark.parametrize("named", [True, False])
def test_a_campaign_begins_around_a_vehicle_that_is_there(
    recording, tmp_path, capsys, monkeypatch, named
):
    folder = tmp_path / "our-car"
    folder.mkdir()
    numbers = VEHICLE.format(title='"ours"').replace("228.0 ", "301.5 ")
    (folder / "vehicle.toml").write_text(numbers)
    monkeypatch.chdir(folder)
    words = ["--vehicle", "vehicle.toml"] if named else []
    assert main(["campaign", "new", ".", str(recording), *words]) == 0
    assert "student-built" not in capsys.readouterr().out
    assert (folder / "vehicle.toml").read_text() == numbers
    assert tomllib.loads((folder / "campaign.toml").read_text())["title"] == "our-car"


def test_check_says_which_numbers_are_still_the_sample_s(recording, tmp_path, capsys):
    folder = tmp_path / "car"
    words = ["--id", "slow", "--stretch", "1", "--speed-kmph", "7.5", "--track", "flat"]
    assert main(["campaign", "new", str(folder), str(recording)]) == 0
    assert main(["campaign", "add", str(folder), str(recording), *words]) == 0
    capsys.readouterr()

    def said():
        assert main(["check", str(folder)]) == 0
        return " ".join(capsys.readouterr().out.split())

    assert re.search(r"(\d+) of \1 numbers in vehicle.toml are those of the sample file", said())
    file = folder / "vehicle.toml"
    lines = file.read_text().splitlines()
    others = [
        re.sub(r"= (-?[\d.]+) .*", lambda m: f"= {float(m[1]) * 1.1 + 1e-3:.4g}", line)
        if "# sample" in line and "roll_inertia" not in line and "tyre_damping" not in line
        else line
        for line in lines
    ]
    file.write_text("\n".join(others) + "\n")
    left = "body.roll_inertia_kg_m2, wheel.front.tyre_damping_N_s_m, wheel.rear.tyre_damping_N_s_m"
    assert f"still marked as the sample's: {left}" in said()
    file.write_text("\n".join(line.partition("# sample")[0] for line in others) + "\n")
    assert "the sample" not in said()


MISTAKES = {
    "no such stretch": (["--stretch", "3"], "there are 2 stretches, none is number 3"),
    "two spans": (["--stretch", "1", "--from", "2"], "leave out --from and --to"),
    "whole of nothing": (["--whole"], "--whole is about --stretch"),
    "outside": (["--from", "100"], "outside the recording"),
    "no pair": (["--track", "washboard", "15"], "KEY=VALUE"),
    "unknown track": (["--track", "washbord"], "washboard"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_one_line(case, recording, tmp_path, capsys):
    words, complaint = MISTAKES[case]
    folder = str(tmp_path / "car")
    assert main(["campaign", "new", folder, str(recording)]) == 0
    capsys.readouterr()
    add = ["campaign", "add", folder, str(recording), "--id", "x", "--speed-kmph", "7", *words]
    assert main(add) == 2
    error = capsys.readouterr().err
    assert complaint in error and error.count("\n") == 1 and "Traceback" not in error


def of_a_bus(tmp_path, rate_hz=100.0, unit="m/s²"):
    """A recording of which one channel is an acceleration."""
    rng = np.random.default_rng(3)
    pot, hub = ("Damper Pos FL", "m"), ("Accel Upright FL", unit)
    named = (("Distance", "m"), pot, hub, ("Speed", "m/s"))
    values = rng.normal(size=(1000, 4))
    values[::2, 3] = np.nan  # at half the rate
    recording = Recording(values, rate_hz, tuple(Channel(*pair) for pair in named))
    write(recording, tmp_path / "bus.csv")
    return tmp_path / "bus.csv"


def test_channels_that_a_campaign_never_takes_are_left_out_by_name(tmp_path, capsys):
    """Before anybody is asked where they sit."""
    file, folder = of_a_bus(tmp_path), tmp_path / "camp"
    assert main(["campaign", "new", str(folder), str(file)]) == 2
    said = capsys.readouterr()
    assert "Accel Upright FL: where does it sit?" in said.err and "Damper" not in said.err
    place = ["--place", "Accel Upright FL=A1"]
    assert main(["campaign", "new", str(folder), str(file), *place]) == 0
    assert "left out, no accelerations: Distance (in m), Damper Pos FL (in m), Speed (in m/s)" in (
        capsys.readouterr().out
    )
    head = (folder / "campaign.toml").read_text()
    assert '"Accel Upright FL" = "A1"' in head and "Distance" not in head
    run = ["--id", "a", "--speed-kmph", "27", "--track", "unknown"]
    assert main(["campaign", "add", str(folder), str(file), *run]) == 0
    assert (folder / "runs/a.csv").read_text().startswith("time_s,Accel Upright FL\n")


def test_a_rate_that_leaves_no_band_is_refused(tmp_path, capsys):
    """Seconds that are milliseconds, say: the band would end below its beginning."""
    for rate_hz, status in ((0.1, 2), (1.0, 2), (2.0, 2), (3.0, 0), (20.0, 0)):
        file, folder = of_a_bus(tmp_path, rate_hz), tmp_path / f"camp-{rate_hz}"
        place = ["--place", "Accel Upright FL=A1"]
        assert main(["campaign", "new", str(folder), str(file), *place]) == status
        assert (folder / "campaign.toml").exists() == (status == 0)
        if status:
            assert "was the recording's time read in the right unit?" in capsys.readouterr().err
        else:
            low, high = tomllib.loads((folder / "campaign.toml").read_text())["band_hz"]
            assert 0 < low < high < rate_hz / 2
