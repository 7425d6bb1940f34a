"""compare, diagnose, add and demo on a small campaign, from words to files."""

import json
import os
import signal
import subprocess
import sys
import tomllib
from contextlib import nullcontext
from pathlib import Path

import pytest

from tests.campaign.build import edit
from tests.patience import PATIENCE_S
from tests.report.small import write_small_campaign
from wheelhop.cli import progress
from wheelhop.cli.main import main
from wheelhop.effects import load_effects

OWN_EFFECT = '''\
"""Quadratic damping."""
from wheelhop.effects import Amplitude, Effect, law
from wheelhop.vehicle import CORNERS, suspension


@law
def quadratic(x, v, dx, dt, z, p):
    return p[0] * v * abs(v), z


class QuadraticDamper(Effect):
    id = "quadratic-damper"
    place = "suspension"
    title = "damping grows with the square of velocity"
    equation = r"f = c_2 \\dot x |\\dot x|"
    source = "a test"

    def parameters_for(self, vehicle, channels):
        return (Amplitude("c2", "N s²/m²", "quadratic damping", 500.0),)

    def modify(self, theta, vehicle, parts):
        for i in CORNERS:
            parts.add_law(suspension(vehicle, i), quadratic, (theta["c2"],))
'''


def contents(folder):
    return {
        str(file.relative_to(folder)): file.read_bytes()
        for file in folder.rglob("*")
        if file.is_file()
    }


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_small_campaign(tmp_path_factory.mktemp("cli") / "c")


@pytest.fixture(scope="module")
def diagnosed(folder, tmp_path_factory):
    """Files that diagnose wrote, with what it left in the campaign's folder."""
    out = tmp_path_factory.mktemp("out")
    before = contents(folder)
    words = ["diagnose", folder, "--max-effects", "1", "--jobs", "2"]
    words += ["--json", out / "d.json", "--report", out / "d.html"]
    assert main([str(word) for word in words]) == 0
    assert contents(folder) == before
    return out


def test_the_json_of_a_diagnosis_has_every_key(diagnosed):
    found = json.loads((diagnosed / "d.json").read_text())
    assert found["format"] == 1
    assert found["verdict"][0] == "dry-friction"
    assert 0.0 <= found["confidence"] <= 1.0
    assert found["floor"]["source"] == "noise_rms_m_s2" and 0 < found["floor"]["error"] < 0.01
    named = {item["effect"] for item in found["ranking"]}
    beliefs = {name for name in named if name.startswith("belief: ")}
    assert named - beliefs == set(load_effects())
    assert "belief: amplitude of washboard tracks" in beliefs
    keys = {"effect", "place", "screened_error", "confirmed_error", "evidence", "p_value"}
    keys |= {"ambiguous_with", "parameters"}
    for item in found["ranking"]:
        assert keys <= set(item)
        assert isinstance(item["ambiguous_with"], list) and isinstance(item["parameters"], dict)
    first = found["ranking"][0]
    assert first["effect"] == "dry-friction" and first["place"] == "suspension"
    assert 60 < first["parameters"]["front_N"] < 90  # 75 N are in the data
    assert [rung["added"] for rung in found["ladder"]] == [[], ["dry-friction"]]
    for rung in found["ladder"]:
        assert {"added", "error_fit", "error_validate", "parameters"} <= set(rung)
    assert found["ladder"][1]["error_validate"] < 0.2 * found["ladder"][0]["error_validate"]
    for where in ("baseline", "last"):
        assert {"run", "channel", "band_hz", "motion", "locking"} <= set(found["where"][where])
    assert "next_run" in found
    assert ": dry-friction</title>" in (diagnosed / "d.html").read_text()


def test_a_diagnosis_within_a_budget_says_what_it_has_not_tried(folder, tmp_path, capsys):
    file = tmp_path / "d.json"
    assert main(["diagnose", str(folder), "--budget", "0.01", "--json", str(file)]) == 0
    out, _ = capsys.readouterr()
    assert "no effect of the library is confirmed" in out
    assert "The search ended after 0 s of work (the budget)." in out
    found = json.loads(file.read_text())
    assert found["verdict"] == ["unknown"] and found["confidence"] < 0.01
    assert found["unfinished"]["ended_by"] == "budget"


def test_ctrl_c_gives_the_verdict_so_far(folder, monkeypatch, capsys):
    def interrupted(text):
        if text.startswith("simulating"):
            raise KeyboardInterrupt

    monkeypatch.setattr("wheelhop.cli.diagnose.stages", lambda: nullcontext(interrupted))
    assert main(["diagnose", str(folder)]) == 130
    out, _ = capsys.readouterr()
    assert (
        "(interrupted). Not simulated, with the error expected of each: dry-friction"
        in " ".join(out.split())
    )


def test_compare_says_where_the_model_fails(folder, tmp_path, capsys):
    before = contents(folder)
    file, page = tmp_path / "c.json", tmp_path / "c.html"
    assert main(["compare", str(folder), "--json", str(file), "--report", str(page)]) == 0
    out, err = capsys.readouterr()
    assert err == "" and "residual / noise floor" in out and str(page) in out
    found = json.loads(file.read_text())
    assert found["format"] == 1 and found["error_fit"] > 10 * found["floor"]["error_fit"]
    assert [rung["added"] for rung in found["ladder"]] == [[]]
    assert "<h1>The baseline’s error is" in page.read_text()
    assert contents(folder) == before


def test_compare_with_an_effect_shows_the_error_fall(folder, tmp_path, capsys):
    file = tmp_path / "c.json"
    assert main(["compare", str(folder), "--add", "dry-friction", "--json", str(file)]) == 0
    assert "+ dry-friction" in capsys.readouterr().out
    first, last = json.loads(file.read_text())["ladder"]
    assert last["added"] == ["dry-friction"]
    assert last["error_validate"] < 0.2 * first["error_validate"]


def test_add_stores_the_model_and_changes_nothing_else(folder, tmp_path, capsys):
    own = write_small_campaign(tmp_path / "c")
    before = contents(own)
    assert main(["add", str(own), "dry-friction"]) == 0
    after = contents(own)
    assert set(after) - set(before) == {"model.toml"}
    assert {name: after[name] for name in before} == before
    model = tomllib.loads(after["model.toml"].decode())
    assert [effect["id"] for effect in model["effect"]] == ["dry-friction"]
    out = capsys.readouterr().out
    assert "noise floor" in out and f"stored in {own / 'model.toml'}" in out
    assert main(["check", str(own)]) == 0  # the folder is a campaign still


def test_an_effect_of_the_users_own_takes_part(folder, tmp_path, capsys):
    file = tmp_path / "mine.py"
    file.write_text(OWN_EFFECT)
    words = ["compare", folder, "--add", "quadratic-damper", "--effects", file]
    assert main([str(word) for word in words]) == 0
    assert "+ quadratic-damper" in capsys.readouterr().out


@pytest.mark.parametrize(
    "words", [["add", "{}", "dry-fricton"], ["compare", "{}", "--add", "dry-fricton"]]
)
def test_a_misspelt_effect_is_one_line_with_the_nearest_name(folder, words, capsys):
    assert main([word.format(folder) for word in words]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.count("\n") == 1
    assert 'no effect "dry-fricton": did you mean "dry-friction"?' in err


def test_an_effect_that_does_not_apply_is_one_line(folder, tmp_path, capsys):
    """Measured axle motion drives the model when no track is known: no tyre is in it."""
    own = write_small_campaign(tmp_path / "c")
    text = (own / "campaign.toml").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("track.")]
    text = "\n".join(lines).replace("speed_kmph", 'track.kind = "unknown"\nspeed_kmph')
    (own / "campaign.toml").write_text(text)
    assert main(["add", str(own), "tyre-lift-off"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "tyre-lift-off cannot be added" in err
    assert "known track" in err and not (own / "model.toml").exists()


def test_a_broken_campaign_is_one_line_and_status_2(tmp_path, capsys):
    own = write_small_campaign(tmp_path / "c")
    edit(own / "campaign.toml", "pitch_mm", "pitch_cm")
    for command in (["compare"], ["diagnose"], ["add"]):
        words = [*command, str(own)] + (["dry-friction"] if command == ["add"] else [])
        assert main(words) == 2
        assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_interruption_while_computing_is_one_line_and_status_130():
    """It says when it has loaded what it computes with; eighteen runs are not done at once."""
    folder = Path(__file__).parents[2] / "examples" / "open-dry-friction"
    code = (
        "import sys, threading, time\n"
        "from wheelhop.cli.main import main\n"
        "def tell():\n"
        "    while 'wheelhop.diagnose' not in sys.modules: time.sleep(0.01)\n"
        "    print('computing', flush=True)\n"
        "threading.Thread(target=tell, daemon=True).start()\n"
        f"sys.exit(main(['diagnose', {str(folder)!r}]))"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        # A shell that runs tests in the background has told them to ignore interrupts.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        assert process.stdout.readline() == b"computing\n"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE_S)
    assert (process.returncode, out, err) == (130, b"", b"wheelhop: interrupted\n")


def test_the_first_run_says_that_it_compiles(tmp_path, monkeypatch, capsys):
    room = tmp_path / "room"
    (room / "__pycache__").mkdir(parents=True)
    source = room / "law.py"
    source.write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    (room / "__init__.py").write_text("")
    monkeypatch.setattr(progress, "COMPILED", (("room", "law"),))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    progress.announce_compilation()
    assert "compiling" in capsys.readouterr().err
    cache = room / "__pycache__/law.slip-3.py312.nbi"
    cache.write_bytes(b"")
    progress.announce_compilation()
    assert capsys.readouterr().err == ""
    os.utime(cache, (1, 1))  # older than the source
    progress.announce_compilation()
    assert "compiling" in capsys.readouterr().err


def test_demo_tells_the_story_and_leaves_model_and_report(tmp_path, monkeypatch, capsys):
    def small(folder, console):
        write_small_campaign(folder)

    monkeypatch.setattr("wheelhop.cli.demo.record_day", small)
    folder = tmp_path / "demo"
    assert main(["demo", str(folder)]) == 0
    out = capsys.readouterr().out
    commands = [line.split("#")[0].split() for line in out.splitlines() if line.startswith("$")]
    assert [words[2] for words in commands] == ["compare", "diagnose", "add"]
    assert commands[2][3:] == [str(folder), "dry-friction"]
    assert len(out.splitlines()) < 60
    model = tomllib.loads((folder / "model.toml").read_text())
    assert [effect["id"] for effect in model["effect"]] == ["dry-friction"]
    assert ": dry-friction</title>" in (folder / "report.html").read_text()
