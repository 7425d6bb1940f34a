"""The frame of the command line: what it accepts, what it prints, how it ends."""

import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from tests.campaign.build import edit, write_campaign
from wheelhop.api.verbs import BUDGET_S
from wheelhop.campaign import CampaignError
from wheelhop.cli.main import BROKEN_PIPE, main, module_of
from wheelhop.cli.parser import make_parser

COMMANDS = (
    *("check", "compare", "diagnose", "add", "demo", "flash", "version"),
    *("campaign", "convert", "import", "info", "decode", "recover", "health"),
    *("sync-check", "calibrate", "logger", "record", "download"),
)


@pytest.fixture
def folder(tmp_path):
    return write_campaign(tmp_path / "c")


def wheelhop(*words: object, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "wheelhop.cli.main", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, **options)


def test_check_shows_runs_channels_band_and_floor(folder, capsys):
    assert main(["check", str(folder)]) == 0
    out = capsys.readouterr().out
    for word in ("two runs", "student-built ATV", "0.5 to 30 Hz", "0.12 m/s²", "B1, B2", "A4"):
        assert word in out
    slow = next(line for line in out.splitlines() if line.strip().startswith("slow"))
    assert slow.split()[:8] == ["slow", "fit", "7.5", "washboard", "15", "×", "400", "mm"]
    assert slow.split()[8] == "256"


def test_a_mistake_is_one_line_on_stderr_and_status_2(folder):
    edit(folder / "vehicle.toml", "mass_kg = 228.0", "mass_kg = -228.0")
    done = wheelhop("check", folder)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"wheelhop: {folder / 'vehicle.toml'}: [body]: mass_kg")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["diagnos", "x"], "did you mean 'diagnose'"),
        (["fly"], "choose from check, compare,"),
        (["decode", "x", "--format", "cvs"], "did you mean 'csv'"),
    ],
)
def test_who_mistypes_is_told_what_there_is(words, said, capsys):
    with pytest.raises(SystemExit):
        main(words)
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1


@pytest.mark.parametrize(
    "words",
    [
        [],
        ["diagnos", "x"],
        ["diagnose"],
        ["diagnose", "x", "--jobs", "none"],
        ["diagnose", "x", "--max-effects", "0"],
        ["compare", "x", "--plus", "dry-friction"],
        ["add", "x"],
    ],
)
def test_a_wrong_command_line_is_one_line_and_status_2(words, capsys):
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("wheelhop: ") and err.count("\n") == 1


def test_an_output_that_cannot_be_written_is_told_before_the_work(folder, capsys, tmp_path):
    assert main(["diagnose", str(folder), "--json", str(tmp_path / "no/x.json")]) == 2
    assert "there is no folder" in capsys.readouterr().err
    assert main(["diagnose", str(folder), "--report", str(tmp_path)]) == 2
    assert "is a folder" in capsys.readouterr().err


def test_interruption_is_one_line_and_status_130(monkeypatch, folder, capsys):
    def interrupted(arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr("wheelhop.cli.check.run", interrupted)
    assert main(["check", str(folder)]) == 130
    assert capsys.readouterr().err == "wheelhop: interrupted\n"


@pytest.mark.parametrize("words", [["check", "."], ["version"]])
def test_a_reader_that_stops_reading_is_no_error(folder, words):
    command = [sys.executable, "-m", "wheelhop.cli.main", *words]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=folder, **pipes) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == BROKEN_PIPE


def test_a_fault_of_the_program_is_not_taken_for_one_of_the_user(monkeypatch, folder):
    def faulty(arguments):
        raise ValueError("a bug")

    monkeypatch.setattr("wheelhop.cli.check.run", faulty)
    with pytest.raises(ValueError, match="a bug"):
        main(["check", str(folder)])


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_is_a_module_and_has_help(command, capsys):
    assert callable(import_module(f"wheelhop.cli.{module_of(command)}").run)
    with pytest.raises(SystemExit) as end:
        main([command, "--help"])
    assert end.value.code == 0
    assert f"wheelhop {command}" in capsys.readouterr().out


def test_options_of_diagnose_and_compare():
    parse = make_parser().parse_args
    compare = parse(
        ["compare", "c", "--add", "dry-friction", "--add", "tyre-lift-off", "--json", "x.json"]
    )
    assert compare.add == ["dry-friction", "tyre-lift-off"]
    assert compare.json == Path("x.json")
    diagnose = parse(["diagnose", "c"])
    assert (diagnose.max_effects, diagnose.json, diagnose.report) == (4, None, None)
    own = parse(["diagnose", "c", "--effects", "mine.py", "--jobs", "2", "--max-effects", "5"])
    assert (own.effects, own.jobs, own.max_effects) == (Path("mine.py"), 2, 5)
    assert diagnose.budget == BUDGET_S
    assert parse(["diagnose", "c", "--budget", "none"]).budget is None
    assert parse(["diagnose", "c", "--budget", "2.5"]).budget == 2.5
    assert parse(["add", "c", "dry-friction", "bump-stop"]).effects == ["dry-friction", "bump-stop"]


def test_version_is_printed_both_ways(capsys):
    assert main(["version"]) == main(["--version"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first == second and re.fullmatch(r"wheelhop \d+\.\d+\.\d+\S*", first)


def test_help_answers_at_once_because_it_loads_no_room():
    heavy = "numpy", "scipy", "numba", "matplotlib", "rich", "wheelhop.campaign"
    code = (
        "import sys; from wheelhop.cli.parser import make_parser; make_parser().format_help(); "
        f"print(len(sys.modules), [name for name in {heavy!r} if name in sys.modules])"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout
    modules, loaded = told.split(maxsplit=1)
    assert loaded.strip() == "[]" and int(modules) < 200  # 109 take 0.1 s on a laptop core


def test_the_demo_deletes_nothing(tmp_path, monkeypatch):
    """A campaign of one's own has the names that a demo leaves."""
    from wheelhop.cli.demo import begin, free_folder

    monkeypatch.chdir(tmp_path)
    begin(free_folder())
    begin(Path("wheelhop-demo"))
    Path("wheelhop-demo/campaign.toml").write_text("precious")
    with pytest.raises(CampaignError, match="not empty"):
        begin(Path("wheelhop-demo"))
    assert Path("wheelhop-demo/campaign.toml").read_text() == "precious"
    assert free_folder() == Path("wheelhop-demo-2")


def test_no_garbage_is_looked_for_while_a_command_is_imported(tmp_path):
    (tmp_path / "seen.py").write_text("import gc\ncollecting = gc.isenabled()\n")
    (tmp_path / "broken.py").write_text("1 / 0\n")
    script = (
        "import gc\nfrom wheelhop.cli.main import imported\n"
        "assert imported('seen').collecting is False\n"
        "assert gc.isenabled() and gc.get_freeze_count()\n"
        "try:\n    imported('broken')\nexcept ZeroDivisionError:\n    assert gc.isenabled()\n"
        "gc.disable()\nimported('json')\nassert not gc.isenabled()\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True)
    assert (done.returncode, done.stderr) == (0, b"")
