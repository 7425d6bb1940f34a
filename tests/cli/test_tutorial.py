"""The tutorial is followed: its commands run in the order of the page, and print what it shows."""

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

from wheelhop.cli.main import main

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/tutorial.md"
SHOWN = re.compile(r"^ {4,}(\S.*?)\s*$", re.MULTILINE)
RULE = "────"


@pytest.mark.parametrize(
    "last", ["check", pytest.param("diagnose", marks=pytest.mark.slow, id="to the verdict")]
)
def test_the_tutorial_is_true(last, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    said, ran = "", []
    for line in SHOWN.findall(PAGE.read_text(encoding="utf-8")):
        program, *arguments = shlex.split(line) if "wheelhop " in line else [line]
        if line.startswith("python "):
            example = ROOT / line.removeprefix("python ")
            subprocess.run([sys.executable, example], check=True, capture_output=True)
            said = _plain((tmp_path / "logger/lap-12.csv").read_text(encoding="utf-8"))
        elif program == "wheelhop":
            if ran and ran[-1] == last:
                break
            assert main(arguments) == 0, line
            ran.append(arguments[0])
            said = _plain(capsys.readouterr().out)
        elif not line.startswith(RULE):
            assert _plain(line) in said, line
    assert ran[-1] == last
    assert (tmp_path / "our-car/vehicle.toml").is_file()


def _plain(text: str) -> str:
    """Without what a table adds."""
    return re.sub(r"\s+", " ", text.replace(RULE, "")).strip()
