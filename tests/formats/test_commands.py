"""`wheelhop convert` and `wheelhop import`, from words to files; and libraries that are missing."""

import subprocess
import sys
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.formats.foreign import GERMAN
from tests.formats.recordings import assert_same, recording
from tests.logger.session import session
from wheelhop.cli import convert, import_
from wheelhop.files import InputError
from wheelhop.formats import ExchangeError, read, write
from wheelhop.logger import read_log


def converted(source, target, force=False):
    return convert.run(Namespace(source=source, target=target, force=force))


def imported(*files, out, draft=False, to=".csv", force=False, **rest):
    mapping = rest.get("mapping")
    return import_.run(
        Namespace(
            files=list(files),
            map=mapping,
            out=out,
            draft=draft,
            to=to,
            force=force,
            yes=rest.get("yes", False),
            answer=rest.get("answer", []),
        )
    )


def test_convert_writes_and_says_what_it_wrote_and_lost(tmp_path, capsys):
    original = recording()
    values = original.values.copy()
    values[3, 1] = np.nan
    source, target = tmp_path / "run.csv", tmp_path / "run.uff"
    write(replace(original, values=values), source)
    assert converted(source, target) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first == (
        f"{target}: 400 samples at 100 Hz (4 s), 11 samples missing, 1 of A2 alone: "
        "A1 [m/s²], A2 [m/s²], A3 [m/s²]"
    )
    assert second == "  lost: rows with a value in some channels only: 1; they become gaps"


def test_convert_destroys_nothing_unless_told_to(tmp_path):
    source, target = tmp_path / "run.csv", tmp_path / "run.mf4"
    write(recording(), source)
    target.write_bytes(b"precious")
    with pytest.raises(ExchangeError, match="exists: choose another name, or --force"):
        converted(source, target)
    with pytest.raises(ExchangeError, match="is what is read"):
        converted(source, source, force=True)
    assert target.read_bytes() == b"precious"
    assert converted(source, target, force=True) == 0
    assert_same(read(target), recording())


def test_import_drafts_a_mapping_and_imports_with_it(tmp_path, capsys):
    file, mapping, out = tmp_path / "fahrt.csv", tmp_path / "map.toml", tmp_path / "runs"
    file.write_bytes(GERMAN.encode("cp1252"))
    assert imported(file, out=out, draft=True) == 0
    mapping.write_text(capsys.readouterr().out, encoding="utf-8")
    assert imported(file, out=out, mapping=mapping) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("4 samples at 100 Hz (0.04 s): Achse vl [m/s²], Aufbau [m/s²]")
    assert lines[1:] == ["  imported from fahrt.csv (text)", "  Achse vl: g × 9.80665 = m/s²"]
    assert read(out / "fahrt.csv").values[:, 1].tolist() == [-0.25, -0.5, -0.75, -1.0]


def test_import_without_a_mapping_shows_what_it_understood(tmp_path, capsys):
    """A table of the columns; what is taken for granted stands in the history."""
    file, out = tmp_path / "fahrt.csv", tmp_path / "runs"
    file.write_bytes(GERMAN.encode("cp1252"))
    assert imported(file, out=out) == 0
    printed = capsys.readouterr().out
    rows = [line.split() for line in printed.splitlines()]
    assert ["Zeit", "s", "time", "in", "s,", "as", "it", "says"] in rows
    assert ["Achse", "vl", "g", "a", "channel,", "at", "A1", "×", "9.80665", "=", "m/s²"] in rows
    assert ["Bemerkung", "left", "out", "no", "numbers"] in rows
    found = read(out / "fahrt.csv")
    assert found.channels[0].point == "A1" and found.rate_hz == 100.0
    assert "Achse vl: taken for A1, by its name" in found.history


def test_files_that_are_understood_alike_are_shown_once(tmp_path, capsys):
    """Of the second one it is said which it is like; a third in other units is shown."""
    other = GERMAN.replace("s;g;", "s;mg;")
    files = [tmp_path / f"{i}.csv" for i in (1, 2, 3)]
    for file, text in zip(files, (GERMAN, GERMAN, other), strict=True):
        file.write_bytes(text.encode("cp1252"))
    assert imported(*files, out=tmp_path / "runs") == 0
    printed = capsys.readouterr().out
    assert printed.count("taken for  ") == 2
    assert "2.csv: as 1.csv\n" in printed and "3.csv: as" not in printed
    assert printed.count("  as 1.csv\n") == 1


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("time_s,acc_g\n0.00,1\n0.01,2\n0.02,3\n", "m/s²", 9.80665),
        ("time_s,acc\ns,g\n0.00,1\n0.01,2\n0.02,3\n", "m/s²", 9.80665),
        ("time_s,acc_m_s2\n0.00,1\n0.01,2\n0.02,3\n", "m/s²", 1.0),
        ("time_s,A1\n0.00,1\n0.01,2\n0.02,3\n", "m/s²", 1.0),
    ],
)
def test_a_csv_that_only_names_its_time_as_ours_do_is_understood(text, unit, value, tmp_path):
    file, out = tmp_path / "run.csv", tmp_path / "runs"
    file.write_text(text)
    assert imported(file, out=out) == 0
    found = read(out / "run.csv")
    assert found.channels[0].unit == unit and found.values[0, 0] == pytest.approx(value)


COUNTED = "count;A1 [g]\n" + "".join(f"{k};{k % 7}\n" for k in range(50))


def test_import_asks_only_what_is_not_known(tmp_path, capsys, monkeypatch):
    """Of a person; what is no terminal is told how to say it."""
    file, out = tmp_path / "run.csv", tmp_path / "runs"
    file.write_text(COUNTED)
    with pytest.raises(
        ExchangeError, match=r"run\.csv: is not known, rate_hz: .*--answer rate_hz="
    ):
        imported(file, out=out)
    assert not out.exists()
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    asked = []
    monkeypatch.setattr("builtins.input", lambda words: asked.append(words) or "500")
    assert imported(file, out=out) == 0
    assert len(asked) == 1 and asked[0].startswith("rate_hz, how many samples a second")
    assert read(out / "run.csv").rate_hz == 500.0
    monkeypatch.setattr("builtins.input", lambda words: "")
    with pytest.raises(ExchangeError, match="is not known"):
        imported(file, out=tmp_path / "more")


@pytest.mark.parametrize(
    ("text", "answer", "rate_hz"),
    [
        (COUNTED, ["rate_hz=500"], 500.0),
        ("t;A1 [g]\n" + "".join(f"{10 * k};1\n" for k in range(9)), ["time_unit=ms"], 100.0),
        (
            "x;A1 [g]\n" + "".join(f"{k};1,234\n" for k in range(9)),
            ["decimal=,", "time_unit=sample", "rate_hz=50"],
            50.0,
        ),
    ],
)
def test_answers_can_be_given_with_the_command(text, answer, rate_hz, tmp_path):
    file, out = tmp_path / "run.csv", tmp_path / "runs"
    file.write_text(text)
    assert imported(file, out=out, answer=answer, yes=True) == 0
    assert read(out / "run.csv").rate_hz == rate_hz


@pytest.mark.parametrize(
    "answer", ["rate_hz", "rate=5", "rate_hz=fast", "rate_hz=-3", "rate_hz=nan", "time_unit=weeks"]
)
def test_an_answer_that_is_none_is_a_line(answer, tmp_path):
    file = tmp_path / "run.csv"
    file.write_text(COUNTED if "rate" in answer else COUNTED.replace("count", "x"))
    with pytest.raises(ExchangeError):
        imported(file, out=tmp_path, answer=[answer])


def test_a_file_that_names_its_channels_is_shown_and_asked_about_as_a_text_is(tmp_path, capsys):
    pytest.importorskip("scipy")
    from scipy import io

    file = tmp_path / "run.mat"
    io.savemat(file, {"acc": np.arange(50.0) % 3, "Fs": 100.0})
    assert imported(file, out=tmp_path / "runs") == 0
    shown = capsys.readouterr().out
    assert "run.mat: as it says itself" in shown and "a channel   its unit is not said" in shown
    io.savemat(file, {"acc": np.arange(50.0) % 3, "Fs": 1.0})
    with pytest.raises(ExchangeError, match=r"is not known, rate_hz: .* say --answer rate_hz=…"):
        imported(file, out=tmp_path / "runs", force=True)
    assert imported(file, out=tmp_path / "runs", force=True, answer=["rate_hz=1"]) == 0


def test_scripts_get_no_guesses(tmp_path):
    """With --yes nothing is asked, a guess is refused, and a name does not place a sensor."""
    file, out = tmp_path / "run.csv", tmp_path / "runs"
    file.write_text("Time;Acc axle FL [g]\n" + "".join(f"{k / 100};{k % 7}\n" for k in range(50)))
    with pytest.raises(ExchangeError, match=r"run\.csv: would have to be guessed: Time is in s"):
        imported(file, out=out, yes=True)
    file.write_text(file.read_text().replace("Time;", "Time [s];"))
    assert imported(file, out=out, yes=True) == 0
    assert [channel.point for channel in read(out / "run.csv").channels] == [""]


def test_a_name_that_a_csv_cannot_hold_is_another_in_the_draft_and_a_line_without_it(tmp_path):
    """The line names the file that was to be written, not the draft of it, which is hidden."""
    file, out = tmp_path / "run.csv", tmp_path / "runs"
    file.write_text('Time [s],"Acc ""hub"", left [g]"\n0.00,1\n0.01,2\n0.02,3\n')
    assert imported(file, out=out) == 0
    assert [channel.name for channel in read(out / "run.csv").channels] == ["Acc hub left"]
    original = recording(channels=1)
    named = replace(original, channels=(replace(original.channels[0], name="Acc, left"),))
    with pytest.raises(ExchangeError) as caught:
        write(named, tmp_path / "new.csv")
    assert str(caught.value).startswith(f"{tmp_path / 'new.csv'}: a column of CSV cannot be")
    assert "/." not in str(caught.value)


def test_plain_commands_leave_nothing_in_the_temporary_folder(tmp_path, monkeypatch):
    folder, source = tmp_path / "temporary", tmp_path / "run.csv"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    write(recording(), source)
    for suffix in (".uff", ".mf4", ".parquet"):
        assert imported(source, out=tmp_path / "out", to=suffix) == 0
        assert imported(tmp_path / f"out/run{suffix}", out=tmp_path / f"from{suffix}") == 0
    assert list(folder.iterdir()) == []


def test_import_never_writes_over_what_it_reads(tmp_path):
    file = tmp_path / "run.csv"
    write(recording(), file)
    with pytest.raises(ExchangeError, match="is what is read: choose another name"):
        imported(file, out=tmp_path, force=True)
    assert_same(read(file), recording())


@pytest.mark.parametrize(
    ("suffix", "module", "extra"),
    [
        (".mf4", "asammdf", "mdf"),
        (".uff", "pyuff", "uff"),
        (".tdms", "nptdms", "tdms"),
    ],
)
def test_a_missing_library_gives_the_command_to_type(suffix, module, extra, tmp_path, monkeypatch):
    file = tmp_path / f"run{suffix}"
    file.write_bytes(b"something")
    monkeypatch.setitem(sys.modules, module, None)  # as if it were not installed
    line = rf"{suffix} needs {module}: pip install 'wheelhop\[{extra}\]'$"
    with pytest.raises(ExchangeError, match=line):
        read(file)
    if suffix != ".tdms":
        with pytest.raises(ExchangeError, match=line):
            write(recording(), tmp_path / f"new{suffix}")
        assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_the_room_loads_no_optional_library():
    heavy = ("asammdf", "pyuff", "nptdms", "pyarrow", "pandas", "matplotlib", "scipy")
    code = f"import sys, wheelhop.formats; print([x for x in {heavy!r} if x in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "[]\n", done.stderr


def test_a_log_of_the_logger_is_read_and_converted(tmp_path):
    rng = np.random.default_rng(5)
    file = tmp_path / "HOP00012.HOP"
    file.write_bytes(session(rng.integers(0, 8184, (300, 8)), lost=range(100, 110)))
    expected = read_log(file).recording()
    assert int(expected.missing.sum()) == 10
    assert_same(read(file), expected)
    for suffix in (".csv", ".mf4"):
        converted(file, tmp_path / f"run{suffix}")
        assert_same(read(tmp_path / f"run{suffix}"), expected)
    file.write_bytes(b"HOP1" + bytes(508))
    with pytest.raises(InputError) as caught:
        read(file)
    assert str(caught.value).count(file.name) == 1


def test_a_damaged_mdf_leaves_no_traceback_on_stderr_and_is_not_touched(tmp_path):
    file = tmp_path / "run.mf4"
    write(recording(), file)
    damaged = file.read_bytes()[:900]
    file.write_bytes(damaged)
    code = (
        "from pathlib import Path; from wheelhop.formats import read, ExchangeError\n"
        f"try: read(Path({str(file)!r}))\nexcept ExchangeError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.startswith(f"{file}: cannot be read as ASAM MDF: ")
    assert done.stdout.count("\n") == 1 and done.stderr == ""
    assert file.read_bytes() == damaged and [path.name for path in Path(tmp_path).iterdir()] == [
        file.name
    ]


def test_two_files_of_one_name_are_not_imported_over_each_other(tmp_path):
    files = [tmp_path / day / "run.csv" for day in ("monday", "tuesday")]
    for file in files:
        file.parent.mkdir()
        write(recording(), file)
    with pytest.raises(ExchangeError, match="two files"):
        imported(*files, out=tmp_path / "all", force=True)
    assert not (tmp_path / "all").exists()
