"""Every mistake of a user gets one line that names the place, what is wrong and what to do."""

import os
import re
import shutil
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.campaign.build import edit, write_campaign
from wheelhop.calibration import nominal_constants, write_constants
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.files import InputError
from wheelhop.vehicle import read_vehicle


@pytest.fixture
def folder(tmp_path):
    return write_campaign(tmp_path / "c")


def complaint(folder: Path) -> str:
    with pytest.raises(CampaignError) as caught:
        read_campaign(folder)
    line = str(caught.value)
    assert line.isprintable()
    return line


def assert_says(line: str, *words: str) -> None:
    for word in words:
        assert word in line, f"{word!r} is not in {line!r}"


# id: (old text, new text, what the line must say besides the file's name)
IN_CAMPAIGN_TOML = {
    "misspelt key": ("sample_rate_hz", "sample_rat_hz", ["sample_rat_hz", "'sample_rate_hz'?"]),
    "misspelt run key": ("role =", "rolle =", ['"slow"', "'rolle'", "'role'?"]),
    "misspelt track key": ("pitch_mm", "pich_mm", ['"slow"', "track.pich_mm", "'pitch_mm'?"]),
    "key of another track": (
        "track.pitch_mm = 400",
        "track.pitch_mm = 400\ntrack.side = 'left'",
        ["track.side", "takes amplitude_mm, pitch_mm"],
    ),
    "metres": ("pitch_mm = 400", "pitch_m = 0.4", ["given in millimetres", "pitch_mm = 400"]),
    "centimetres": ("pitch_mm = 400", "pitch_cm = 40", ["millimetres", "track.pitch_mm = 400"]),
    "no unit": ("pitch_mm = 400", "pitch = 400", ["millimetres", "track.pitch_mm"]),
    "metres per second": ("speed_kmph = 36", "speed_mps = 10", ["per hour", "speed_kmph = 36"]),
    "seconds": ("averaging_ms = 6.6", "averaging_s = 0.0066", ["averaging_ms = 6.6"]),
    "mixed units": ("pitch_mm = 400", "pitch_mm = 0.4", ["45 degrees", "both in millimetres"]),
    "missing key": ("track.pitch_mm = 400\n", "", ["track.pitch_mm", "missing", "millimetres"]),
    "missing rate": ("sample_rate_hz = 100.0\n", "", ["'sample_rate_hz' is missing", "hertz"]),
    "text for a number": ("speed_kmph = 7.5", 'speed_kmph = "7.5"', ["speed_kmph", "number"]),
    "truth for a number": ("speed_kmph = 7.5", "speed_kmph = true", ["speed_kmph", "number"]),
    "number for a text": ('id = "slow"', "id = 1", ["id", "quotes"]),
    "not finite": ("speed_kmph = 7.5", "speed_kmph = inf", ["speed_kmph", "finite"]),
    "beyond every float": ("speed_kmph = 7.5", f"speed_kmph = 1{'0' * 400}", ["finite"]),
    "negative speed": ("speed_kmph = 7.5", "speed_kmph = -1", ["speed_kmph = -1", "below 0"]),
    "negative length": ("pitch_mm = 400", "pitch_mm = -4", ["track.pitch_mm", "greater than 0"]),
    "unknown track": ('"washboard"', '"washbord"', ["track.kind", "'washboard'?"]),
    "track is no table": (
        'track.kind = "washboard"\ntrack.amplitude_mm = 15\ntrack.pitch_mm = 400',
        'track = "washboard"',
        ['track.kind = "washboard"'],
    ),
    "unknown role": ('"fit"', '"train"', ["role = 'train'", "fit, validate"]),
    "run is no list": ("[[run]]", "[run]", ["not valid TOML", "line"]),
    "syntax": ("speed_kmph = 7.5", "speed_kmph = 7,5", ["line 13", "7,5 has a decimal comma"]),
    "endless nesting": ("[0.5, 30.0]", "[" * 100_000, ["not valid TOML"]),
    "key twice": ("speed_kmph = 7.5", "speed_kmph = 7.5\nspeed_kmph = 8", ["line 14"]),
    "id twice": ('id = "fast"', 'id = "slow"', ['"slow"', "id is used twice"]),
    "recording twice": ("runs/fast.csv", "runs/slow.csv", ['"fast"', 'of run "slow"']),
    "nothing to fit": ('role = "fit"', 'role = "validate"', ['role = "fit"']),
    "missing recording": ("runs/slow.csv", "runs/slwo.csv", ["no such file", "'slow.csv'?"]),
    "back slashes": ('"runs/slow.csv"', r"'runs\slow.csv'", ["no such file", "write '/'"]),
    "out of the folder": ("runs/slow.csv", "../slow.csv", ["../slow.csv", "leads out", "copy"]),
    "absolute": ("runs/slow.csv", "/etc/passwd", ["absolute", "relative to the campaign folder"]),
    "absolute on Windows": ('"runs/slow.csv"', r"'C:\slow.csv'", ["absolute", "relative"]),
    "a folder for a file": ("runs/slow.csv", "runs", ["no such file"]),
    "endless name": ("runs/slow.csv", "a" * 5000, ["5000 characters"]),
    "missing vehicle": ('"vehicle.toml"', '"vehicel.toml"', ["no such file", "'vehicle.toml'?"]),
    "band upside down": ("[0.5, 30.0]", "[30.0, 0.5]", ["band_hz = [30, 0.5]", "rise"]),
    "band past Nyquist": ("[0.5, 30.0]", "[0.5, 50.0]", ["band_hz", "half the sample rate, 50"]),
    "band of one": ("[0.5, 30.0]", "[0.5]", ["band_hz", "two numbers"]),
    "averaging in µs": ("averaging_ms = 6.6", "averaging_ms = 6600", ["averaging_ms", "(30 ms)"]),
    "noise of zero": ("noise_rms_m_s2 = 0.12", "noise_rms_m_s2 = 0", ["greater than 0"]),
    "newer format": ("format = 1", "format = 2", ["format = 2", "reads format = 1"]),
    "wrong place": ("[[run]]", '[channels]\nA1 = "A5"\n[[run]]', ["[channels]: A1", '"body"']),
    "place of one": ("[[run]]", "[channels]\nA1 = [0.1]\n[[run]]", ["A1", "two numbers"]),
    "no channels": ("[[run]]", "[channels]\n[[run]]", ["[channels]", "is empty"]),
    "other formats": ("runs/slow.csv", "vehicle.toml", ["vehicle.toml", "wheelhop convert"]),
}


@pytest.mark.parametrize("mistake", IN_CAMPAIGN_TOML)
def test_in_campaign_toml(folder, mistake):
    old, new, words = IN_CAMPAIGN_TOML[mistake]
    edit(folder / "campaign.toml", old, new)
    file = "vehicle.toml" if mistake == "other formats" else "campaign.toml"
    assert_says(complaint(folder), str(folder / file), *words)


HEADER = "time_s,B1,B2,B3,B4,A1,A2,A3,A4\n"

IN_A_RECORDING = {
    "not a number": (r"\n0.08,[^,]*,", "\n0.08,oops,", ["line 10 (row 9)", "B1", "'oops'"]),
    "underscore": (r"\n0.08,[^,]*,", "\n0.08,1_0,", ["line 10 (row 9)", "B1", "'1_0'"]),
    "empty cell": (r"\n0.08,[^,]*,", "\n0.08,,", ["line 10 (row 9)", "B1", "empty"]),
    "NaN": (r"\n0.08,[^,]*,", "\n0.08,NaN,", ["line 10 (row 9)", "B1", "nan", "cut the run"]),
    "infinite": (r"\n0.08,[^,]*,", "\n0.08,-inf,", ["line 10 (row 9)", "B1", "inf"]),
    "one value too many": (
        r"\n0.08,",
        "\n0.08,1.0,",
        ["line 10 (row 9)", "10 values", "9 columns"],
    ),
    "one value too few": (r"\n0.08,[^,]*,", "\n0.08,", ["line 10 (row 9)", "8 values"]),
    "blank line": (r"\n0.08,[^\n]*", "\n", ["line 10 (row 9)", "0 values"]),
    "gap": (r"\n0.08,[^\n]*", "", ["line 10 (row 9)", "jumps from 0.07 to 0.09", "cut the run"]),
    "clock set back": (r"\n0.08,", "\n0.07,", ["line 10 (row 9)", "does not rise"]),
    "stamp far off": (r"\n0.08,", "\n1e300,", ["line 10 (row 9)", "jumps"]),
    "too short": (r"(?s)\n1.90,.*", "", ["190 rows", "1.9 s", "at least 2 s"]),
    "semicolons": (",", ";", ["semicolons", "commas"]),
    "tabs": (",", "\t", ["tabs", "commas"]),
    "no header": (HEADER, "", ["line 1", "time_s"]),
    "comment first": (r"\A", "# made with love\n", ["line 1", "time_s"]),
    "only a header": (r"(?s)\n.*", "", ["0 rows"]),
    "empty": (r"(?s).*", "", ["is empty", "time_s"]),
    "column twice": ("B2", "B1", ["B1", "twice"]),
    "column without a name": ("B2", "", ["column 3", "no name"]),
    "terminal codes": ("B2", "B2\x1b[2J", ["unexpected column B2?[2J"]),
    "column misspelt": ("B2", "B22", ["B22", "'B2'?"]),
    "column unknown": ("B2", "seat", ["seat", "[channels]", "campaign.toml"]),
    "no time": ("time_s", "t", ["time_s is missing", "seconds"]),
}


@pytest.mark.parametrize("mistake", IN_A_RECORDING)
def test_in_a_recording(folder, mistake):
    pattern, new, words = IN_A_RECORDING[mistake]
    file = folder / "runs/fast.csv"
    every = mistake in ("semicolons", "tabs")
    text, edits = re.subn(pattern, new.replace("\\", ""), file.read_text(), count=not every)
    assert edits
    file.write_text(text)
    assert_says(complaint(folder), str(file), *words)


def test_missing_columns_point_to_the_channels_table(folder):
    file = folder / "runs/slow.csv"
    file.write_text(re.sub(r",[^,\n]*\n", "\n", file.read_text()))
    assert_says(complaint(folder), str(file), "column A4 is missing", "[channels]")


def test_a_named_channel_that_no_column_has(folder):
    edit(folder / "campaign.toml", "[[run]]", '[channels]\nA_1 = "A1"\n\n[[run]]')
    assert_says(complaint(folder), "slow.csv", "column A_1 is missing", "'A1'?")


def test_rate_that_the_time_stamps_contradict(folder):
    edit(folder / "campaign.toml", "100.0", "200.0")
    assert_says(complaint(folder), "slow.csv", "(100 Hz)", "sample_rate_hz = 200")


def test_clock_that_is_half_a_percent_off(folder):
    edit(folder / "campaign.toml", "100.0", "100.5")
    assert_says(complaint(folder), "slow.csv", "(100 Hz)", "sample_rate_hz = 100.5")


def test_time_in_milliseconds(folder):
    file = folder / "runs/slow.csv"
    file.write_text(re.sub(r"\n(\d+)\.(\d+),", r"\n\1\g<2>0,", file.read_text()))
    assert_says(complaint(folder), "slow.csv", "milliseconds", "in seconds")


def test_stamps_in_which_a_lost_sample_would_hide(folder):
    edit(folder / "campaign.toml", "100.0", "120.0")
    for name in ("slow", "fast"):
        file = folder / f"runs/{name}.csv"
        header, *rows = file.read_text().splitlines()
        rows = [f"{i / 120:.2f},{row.split(',', 1)[1]}" for i, row in enumerate(rows)]
        file.write_text("\n".join([header, *rows]))
    assert_says(complaint(folder), "slow.csv", "rounded to 0.01 s", "more decimals")


@pytest.mark.parametrize("name", ["campaign.toml", "runs/slow.csv"])
def test_encodings_other_than_utf8(folder, name):
    file = folder / name
    file.write_bytes(file.read_bytes().replace(b"\n", b"\n\xdf", 1))
    assert_says(complaint(folder), str(file), "line 2", "0xdf", "save the file as UTF-8")


@pytest.mark.skipif(sys.platform == "win32", reason="needs the right to make symbolic links")
def test_links_out_of_the_folder(folder, tmp_path):
    (folder / "runs/slow.csv").rename(tmp_path / "elsewhere.csv")
    (folder / "runs/slow.csv").symlink_to(tmp_path / "elsewhere.csv")
    assert_says(complaint(folder), "campaign.toml", '"slow"', "runs/slow.csv", "link out")


@pytest.mark.skipif(sys.platform == "win32", reason="needs the right to make symbolic links")
def test_links_in_a_circle(folder):
    (folder / "runs/slow.csv").unlink()
    (folder / "runs/slow.csv").symlink_to("slow.csv")
    assert_says(complaint(folder), "campaign.toml", '"slow"', "no such file")


def test_links_inside_the_folder_are_fine(folder):
    (folder / "data").mkdir()
    (folder / "runs/slow.csv").rename(folder / "data/slow.csv")
    (folder / "runs/slow.csv").symlink_to("../data/slow.csv")
    assert len(read_campaign(folder).runs) == 2


def test_no_folder_no_campaign_toml_or_a_file(folder):
    assert_says(complaint(folder / "nowhere"), "nowhere", "no such folder")
    assert_says(complaint(folder / "campaign.toml"), "give the folder that holds campaign.toml")
    (folder / "campaign.toml").rename(folder / "Campaign.tml")
    assert_says(complaint(folder), "campaign.toml", "no such file", "'Campaign.tml'?")


def test_parquet_that_is_none_or_holds_no_numbers(folder):
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    edit(folder / "campaign.toml", "slow.csv", "slow.parquet")
    file = folder / "runs/slow.parquet"
    file.write_text("time_s,B1\n")
    assert_says(complaint(folder), str(file), "Parquet")
    parquet.write_table(arrow.table({"time_s": [0.0, 0.01], "B1": ["a", "b"]}), file)
    assert_says(complaint(folder), str(file), "column B1", "not numbers")
    parquet.write_table(arrow.table({"time_s": [0.0, 0.01], "B1": [1.0, None]}), file)
    assert_says(complaint(folder), str(file), "row 2", "B1", "nan")


@pytest.fixture(scope="module")
def valid(tmp_path_factory):
    folder = write_campaign(tmp_path_factory.mktemp("valid"))
    write_constants(nominal_constants(["A1", "B1"]), folder / "calibration.toml")
    return folder


edits = st.tuples(st.floats(0.0, 1.0), st.integers(0, 12), st.binary(max_size=8))
lines = st.tuples(st.floats(0.0, 1.0), st.sampled_from(["delete", "double", "swap", "blank"]))
FILES = ("campaign.toml", "vehicle.toml", "calibration.toml", "runs/slow.csv")
TRIES = int(os.environ.get("WHEELHOP_FUZZ", "300"))


@settings(max_examples=TRIES)
@given(st.sampled_from(FILES), st.lists(edits, max_size=3), st.lists(lines, max_size=2))
def test_damaged_files_are_read_or_refused_in_one_line(valid, name, edits, lines):
    data = (valid / name).read_bytes()
    rows = data.split(b"\n")
    for place, what in lines:
        i = int(place * (len(rows) - 2))
        new = {
            "delete": [],
            "double": [rows[i]] * 2,
            "swap": [rows[i + 1], rows[i]],
            "blank": [b""],
        }
        rows[i : i + (2 if what == "swap" else 1)] = new[what]
    data = b"\n".join(rows)
    for place, length, new in edits:
        i = int(place * len(data))
        data = data[:i] + new + data[i + length :]
    with tempfile.TemporaryDirectory() as temporary:
        folder = shutil.copytree(valid, Path(temporary) / "c")
        (folder / name).write_bytes(data)
        try:
            read_vehicle(read_campaign(folder).vehicle_file)
        except InputError as error:
            assert str(error).isprintable() and len(str(error)) < 1000


def test_all_that_is_missing_is_said_at_once(folder):
    edit(folder / "campaign.toml", "speed_kmph", "# speed_kmph")
    with pytest.raises(CampaignError, match="'speed_kmph' is missing: give a number in kilom"):
        read_campaign(folder)
    edit(folder / "campaign.toml", "title", "# title")
    edit(folder / "campaign.toml", "band_hz", "# band_hz")
    with pytest.raises(CampaignError, match=r"3 keys are missing: title; band_hz; \[\[run\]\] \"."):
        read_campaign(folder)
    file = folder / "vehicle.toml"
    edit(file, "pitch_inertia_kg_m2 =", "# pitch_inertia_kg_m2 =")
    with pytest.raises(CampaignError, match="pitch_inertia_kg_m2' is missing: give a number"):
        read_vehicle(file)
    text = file.read_text()
    file.write_text(text[: text.index("[wheel.front]")] + "[wheel]\n")
    with pytest.raises(CampaignError, match=r"3 things .* \[body\] pitch.*\[wheel.front\], \[wh"):
        read_vehicle(file)


@pytest.mark.parametrize(
    ("old", "new"), [('id = "slow"', 'id = "{}"'), ("title = ", 'title = "{}" # ')]
)
def test_a_text_nobody_reads_is_refused_and_not_echoed(folder, old, new):
    edit(folder / "campaign.toml", old, new.format("k" * 2_000_000))
    with pytest.raises(CampaignError, match="has 2000000 characters: give at most") as caught:
        read_campaign(folder)
    assert len(str(caught.value)) < 500
