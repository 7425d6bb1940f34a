"""The files around the code: version and licence are the same everywhere."""

import hashlib
import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

from tools import sbom

ROOT = Path(__file__).parents[2]
SETUP = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = SETUP["project"]
WORKFLOW = ".github/workflows/ci.yml"
FATFS = {
    "ff.c": "dbeae3d7d22dbc070983e31af897fa5e43d29c726a0a240fe9589ffe2ec0ef1e",
    "ff.h": "42920ae4d6080bfc2a72d92a9969b5e94eeaff070e5e71d90da9ab6d7d8e158e",
    "diskio.h": "1c2b29f53e061c55d43b2e412c3a61320b2621bac7561a05e275514baa44785a",
}
"""SHA-256 of FatFs's files as they were released: ours is what is around them."""
BOUND = re.compile(r"([\w-]+)>=([\d.]+)(,<[\d.]+)?")


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


def test_the_papers_and_a_copy_without_history_name_one_version():
    version, state = re.findall(r"^## (\S+), (.+)$", text_of("CHANGELOG.md"), re.M)[0]
    facts = dict(re.findall(r"^([\w-]+): (.+)$", text_of("CITATION.cff"), re.M))
    assert facts["version"] == version and facts["license"] == PROJECT["license"]
    assert facts["cff-version"] == "1.2.0" and facts["title"].startswith('"wheelhop')
    assert re.fullmatch(r"\d{4}-\d\d-\d\d", facts["date-released"])
    released = state == facts["date-released"]
    assert released or state == "not released yet"
    fallback = SETUP["tool"]["hatch"]["version"]["fallback-version"]
    assert fallback == (version if released else f"{version}.dev0")


def test_contributors_are_told_commands_that_exist():
    asked = re.findall(r"^ {4}make (\S+)", text_of("CONTRIBUTING.md"), re.M)
    offered = re.findall(r"^([a-z-]+):", text_of("Makefile"), re.M)
    assert asked and set(asked) <= set(offered)
    for tool in re.findall(r"^ {4}\.venv/bin/(\w+)", text_of("CONTRIBUTING.md"), re.M):
        wanted = " ".join(PROJECT["optional-dependencies"]["test"])
        assert tool in wanted


def test_every_library_of_an_installation_has_a_tested_lower_bound():
    """And numba an upper one: effects/own_file.py makes use of what is not public in it."""
    extras = PROJECT["optional-dependencies"]
    bounds = PROJECT["dependencies"] + extras["workbench"] + extras["logger"]
    named = {match[1]: match for one in bounds if (match := BOUND.fullmatch(one))}
    assert len(named) == len({re.split(r"\W", one)[0] for one in bounds})
    assert {"pandas", "pyarrow"} <= set(named)
    assert [name for name, match in named.items() if match[3]] == ["numba"]


def test_what_is_linked_into_the_firmware_has_a_licence_beside_it():
    shipped = tomllib.loads(text_of("licenses/components.toml"))["component"]
    texts = {one["text"] for one in shipped if "text" in one}
    assert texts == {path.name for path in (ROOT / "licenses").glob("*.txt")}
    names = {one["name"] for one in shipped}
    assert {one["name"] for one in shipped if "text" not in one} == {"libgcc"} and "FatFs" in names
    (fatfs,) = (one["version"] for one in shipped if one["name"] == "FatFs")
    foreign = ROOT / "firmware/foreign/fatfs"
    assert f"Filesystem Module  {fatfs} " in (foreign / "ff.c").read_text(encoding="ascii")
    assert (foreign / "LICENSE.txt").read_bytes() == (ROOT / "licenses/FatFs.txt").read_bytes()
    sums = {name: hashlib.sha256((foreign / name).read_bytes()).hexdigest() for name in FATFS}
    assert sums == FATFS


def test_the_sbom_holds_what_an_installation_takes_along():
    found = sbom.bill(Requirement("wheelhop[workbench]"))
    names = {one["name"]: one for one in found["components"]}
    assert {"numpy", "llvmlite", "nicegui", "starlette"} <= set(names)  # what needs need, too
    assert "pytest" not in names and "asammdf" not in names
    assert names["llvmlite"]["purl"].startswith("pkg:pypi/llvmlite@")
    whole = found["metadata"]["component"]
    assert {"FatFs", "avr-libc"} <= {one["name"] for one in whole["components"]}
    refs = {one["bom-ref"] for one in [whole, *found["components"]]}
    assert {link["ref"] for link in found["dependencies"]} == refs
    assert {on for link in found["dependencies"] for on in link["dependsOn"]} <= refs


def test_what_runs_elsewhere_names_tests_and_examples_that_exist():
    named = re.findall(r"\b(?:tests|examples|tools)/[\w./-]+|\.ci/\w+", text_of(WORKFLOW))
    oldest = re.findall(r"tests/(\w+)/test_\{([\w,]+)\}", text_of("tools/test_oldest.sh"))
    named += [f"tests/{folder}/test_{one}.py" for folder, all in oldest for one in all.split(",")]
    assert oldest and [path for path in named if not (ROOT / path).exists()] == []
