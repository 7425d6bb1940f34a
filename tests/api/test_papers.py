"""The files around the code: version and licence are the same everywhere."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
SETUP = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETUP["project"]


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_papers_and_a_copy_without_history_name_one_version():
    newest = re.findall(r"^## (\S+),", text_of("CHANGELOG.md"), re.M)[0]
    facts = dict(re.findall(r"^([\w-]+): (.+)$", text_of("CITATION.cff"), re.M))
    assert facts["version"] == newest and facts["license"] == PROJECT["license"]
    assert facts["cff-version"] == "1.2.0" and facts["title"].startswith('"wheelhop')
    assert SETUP["tool"]["hatch"]["version"]["fallback-version"] == f"{newest}.dev0"


def test_contributors_are_told_commands_that_exist():
    asked = re.findall(r"^ {4}make (\S+)", text_of("CONTRIBUTING.md"), re.M)
    offered = re.findall(r"^([a-z-]+):", text_of("Makefile"), re.M)
    assert asked and set(asked) <= set(offered)
    for tool in re.findall(r"^ {4}\.venv/bin/(\w+)", text_of("CONTRIBUTING.md"), re.M):
        wanted = " ".join(PROJECT["optional-dependencies"]["test"])
        assert tool in wanted


def test_pandas_and_pyarrow_come_with_every_installation():
    names = {re.split(r"[<>=~! ]", one)[0] for one in PROJECT["dependencies"]}
    assert {"pandas", "pyarrow"} <= names
