"""Files are replaced whole, links lead nowhere else, and of two writers none loses anything."""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.campaign.write import NewRun, add_run, new_campaign
from wheelhop.cli.main import main
from wheelhop.files import InputError, locked, make_folder, replacing, write_text
from wheelhop.formats import write
from wheelhop.logger.recording import Channel, Recording

POINTS = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")
WRITERS = 4


def recording(seed: int = 1) -> Recording:
    values = np.random.default_rng(seed).normal(0, 3, (512, 8))
    return Recording(values, 100.0, tuple(Channel(p, "m/s²") for p in POINTS))


def run_of(name: str) -> NewRun:
    return NewRun(name, "fit", 7.5, {"kind": "washboard", "amplitude_mm": 15, "pitch_mm": 400})


def files(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir() if p.is_file()}


@pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="there is no /dev/shm")
def test_a_folder_in_memory_is_a_folder_and_standard_output_is_none(tmp_path):
    """Below /dev there are files that people keep, and names of files that are open."""
    with tempfile.TemporaryDirectory(dir="/dev/shm") as memory:
        file = Path(memory) / "x.txt"
        write_text(file, "old\n")
        with pytest.raises(ZeroDivisionError), replacing(file) as draft:
            draft.write_text("half of")
            raise ZeroDivisionError
        assert files(Path(memory)) == {"x.txt": b"old\n"}
    code = "from wheelhop.files import *; write_text(__import__('pathlib').Path({!r}), 'said')"
    for name in ("/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"):
        kept = tmp_path / "kept"
        with kept.open("w") as out:
            subprocess.run([sys.executable, "-c", code.format(name)], stdout=out, check=True)
        assert files(tmp_path) == {"kept": b"said"}


def test_a_file_is_as_before_until_all_is_written_and_keeps_its_mode(tmp_path):
    file = tmp_path / "x.txt"
    write_text(file, "old\n")
    file.chmod(0o640)
    with pytest.raises(ZeroDivisionError), replacing(file) as draft:
        draft.write_text("half of")
        assert file.read_text() == "old\n"
        raise ZeroDivisionError
    assert files(tmp_path) == {"x.txt": b"old\n"}
    write_text(file, "new\n")
    assert files(tmp_path) == {"x.txt": b"new\n"}
    if sys.platform != "win32":
        assert file.stat().st_mode & 0o777 == 0o640


def test_a_folder_that_cannot_be_made_gets_a_line_and_leaves_none(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(CampaignError, match=r"file.figures: cannot be made: "):
        make_folder(tmp_path / "file" / "figures", CampaignError)
    if sys.platform != "win32":
        with pytest.raises(InputError, match="cannot be made"):
            make_folder(tmp_path / "a" / "b" / ("n" * 300))
        assert not (tmp_path / "a").exists()


@pytest.mark.skipif(sys.platform == "win32", reason="links take a privilege on Windows")
def test_a_link_is_followed_inside_its_folder_and_not_out_of_it(tmp_path):
    folder, outside = tmp_path / "c", tmp_path / "precious.txt"
    folder.mkdir()
    outside.write_text("precious")
    (folder / "out").symlink_to(outside)
    (folder / "real").write_text("old")
    (folder / "in").symlink_to("real")
    (folder / "loop").symlink_to("loop")
    with pytest.raises(InputError, match="link out of its folder"):
        write_text(folder / "out", "new")
    with pytest.raises(InputError, match="cannot be written"):
        write_text(folder / "loop", "new")
    write_text(folder / "in", "new")
    assert outside.read_text() == "precious" and (folder / "out").is_symlink()
    assert (folder / "real").read_text() == "new" and (folder / "in").is_symlink()


@pytest.mark.skipif(sys.platform == "win32", reason="links take a privilege on Windows")
@pytest.mark.parametrize("linked", ["campaign.toml", "runs"])
def test_a_campaign_that_links_out_of_its_folder_is_not_written_through(linked, tmp_path):
    folder, outside = tmp_path / "c", tmp_path / "outside"
    outside.mkdir()
    new_campaign(folder, "t", recording(), {})
    (folder / linked).rename(outside / linked)
    (folder / linked).symlink_to(outside / linked)
    before = {p: p.read_bytes() for p in outside.rglob("*") if p.is_file()}
    with pytest.raises(CampaignError, match="link out of"):
        add_run(folder, recording(), run_of("slow"))
    assert {p: p.read_bytes() for p in outside.rglob("*") if p.is_file()} == before


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full")
def test_a_full_disk_is_one_line_wherever_the_output_goes(tmp_path):
    write(recording(), tmp_path / "r.csv")
    words = ["health", str(tmp_path / "r.csv")]
    for more, stdout in (((), "/dev/full"), (("--json", "/dev/full"), os.devnull)):
        command = [sys.executable, "-m", "wheelhop.cli.main", *words, *more]
        with open(stdout, "w") as out:
            done = subprocess.run(command, stdout=out, stderr=subprocess.PIPE, text=True)
        assert done.returncode == 2, done.stderr
        assert done.stderr.count("\n") == 1 and "No space left on device" in done.stderr


def test_of_many_who_add_runs_at_the_same_time_none_loses_one(tmp_path):
    new_campaign(tmp_path / "c", "t", recording(), {})
    code = (
        "import sys; from pathlib import Path; from tests.files.test_write import *\n"
        "sys.stdin.readline()\n"
        "for k in range(5): add_run(Path(sys.argv[1]), recording(k), run_of(sys.argv[2] + str(k)))"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "c")]
    root = Path(__file__).parents[2]
    writers = [
        subprocess.Popen([*command, f"w{k}-"], stdin=subprocess.PIPE, cwd=root)
        for k in range(WRITERS)
    ]
    for writer in writers:
        writer.stdin.write(b"go\n")
        writer.stdin.flush()
    assert [writer.wait() for writer in writers] == [0] * WRITERS
    assert len(read_campaign(tmp_path / "c").runs) == 5 * WRITERS


def test_who_holds_the_lock_for_long_is_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr("wheelhop.files.lock.PATIENCE_S", 0.1)
    with (
        locked(tmp_path),
        pytest.raises(InputError, match="another wheelhop"),
        locked(tmp_path),
    ):
        pass
    with locked(tmp_path):
        pass


def test_a_new_campaign_onto_its_own_vehicle_file(tmp_path, capsys):
    folder = tmp_path / "c"
    folder.mkdir()
    write(recording(), tmp_path / "r.csv")
    new_campaign(tmp_path / "other", "t", recording(), {})
    vehicle = folder / "vehicle.toml"
    vehicle.write_bytes((tmp_path / "other/vehicle.toml").read_bytes())
    words = ["campaign", "new", str(folder), str(tmp_path / "r.csv"), "--vehicle"]
    before = vehicle.read_bytes()
    (tmp_path / "another.toml").write_bytes(before + b"# mine\n")
    assert main([*words, str(tmp_path / "another.toml")]) == 2
    assert files(folder) == {"vehicle.toml": before} and not (folder / "runs").exists()
    assert main([*words, str(vehicle)]) == 0
    assert vehicle.read_bytes() == before and (folder / "campaign.toml").exists()
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("title", ['a "b"', "back\\slash", "{brace}", "naïve 道", "\\u0041"])
def test_any_line_of_text_can_be_a_title(title, tmp_path):
    from wheelhop.vehicle import read_nominal

    new_campaign(tmp_path / "c", title, recording(), {})
    add_run(tmp_path / "c", recording(), run_of("slow"))
    campaign = read_campaign(tmp_path / "c")
    assert campaign.title == title and read_nominal(campaign).name == title


@pytest.mark.parametrize("title", ["two\nlines", "bell\a", "del\x7f", " ", "\ud800"])
def test_what_is_no_line_of_text_is_no_title(title, tmp_path):
    with pytest.raises(CampaignError, match="title"):
        new_campaign(tmp_path / "c", title, recording(), {})
    assert not (tmp_path / "c").exists()


def test_an_interruption_before_anyone_listens_is_one_line(monkeypatch, capsys):
    def strike(interrupts):
        raise KeyboardInterrupt

    monkeypatch.setattr("wheelhop.cli.main._listen", strike)
    assert main(["version"]) == 130
    assert capsys.readouterr().err == "wheelhop: interrupted\n"


def end_of(code):
    """Status and complaint of a program that is struck by Ctrl-C."""
    command, root = [sys.executable, "-c", code], Path(__file__).parents[2]
    done = subprocess.run(command, capture_output=True, text=True, cwd=root)
    return done.returncode, done.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
def test_an_interruption_where_nothing_can_be_raised_is_not_lost():
    """A compiler calls back while it works; what is raised there goes nowhere."""
    code = (
        "import os, signal, sys, time\n"
        "from ctypes import CFUNCTYPE\n"
        "import wheelhop.cli.main as command\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "def strike(): os.kill(os.getpid(), signal.SIGINT); time.sleep(0.01)\n"
        "command._run = lambda *given: (CFUNCTYPE(None)(strike)(), time.sleep(5))\n"
        "sys.exit(command.main([]))"
    )
    assert end_of(code) == (130, "wheelhop: interrupted\n")


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
def test_an_interruption_that_an_import_makes_nothing_of_is_not_lost():
    """Libraries try what may be missing, and take any exception for an answer."""
    code = (
        "import os, signal, sys, time\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "class Finder:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        try:\n"
        "            if name == 'wheelhop.cli.info':\n"
        "                os.kill(os.getpid(), signal.SIGINT); time.sleep(0.1)\n"
        "        except:\n"
        "            pass\n"
        "sys.meta_path.insert(0, Finder())\n"
        "from wheelhop.cli.main import main\n"
        "sys.exit(main(['info', 'no.HOP']))"
    )
    assert end_of(code) == (130, "wheelhop: interrupted\n")


@pytest.mark.skipif(sys.platform == "win32", reason="there is no SIGINT to send")
@pytest.mark.parametrize("after_s", [0.15, 0.4, 0.8])
def test_an_interruption_anywhere_is_one_line(after_s):
    """From the moment the program's own first line runs; before that Python is on its own."""
    code = (
        "import os, signal, sys, threading\n"
        # A test run in a shell's background ignores interruptions, and so would what it starts.
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"threading.Timer({after_s}, os.kill, (os.getpid(), signal.SIGINT)).start()\n"
        "from wheelhop.cli.main import main\n"
        "sys.exit(main(['diagnose', 'examples/clean', '--jobs', '1']))"
    )
    assert end_of(code) == (130, "wheelhop: interrupted\n")
