"""What other programs rely on: exit statuses, and JSON that fits its schema."""

import ast
import json
import re
from pathlib import Path

import jsonschema
import pytest

from wheelhop.cli import main as entry
from wheelhop.cli.main import main
from wheelhop.cli.parser import make_parser
from wheelhop.files.schemas import names, schema

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs/programs.md").read_text(encoding="utf-8")
EXAMPLES = ROOT / "examples"


def valid(name, document):
    errors = jsonschema.Draft202012Validator(json.loads(schema(name))).iter_errors(document)
    return [f"{list(error.path)}: {error.message[:200]}" for error in errors]


def test_the_page_has_every_exit_status_of_the_commands():
    told = {int(number) for number in re.findall(r"^\| (\d+) \|", PAGE, re.M)}
    assert told == {0, 1, entry.BAD_INPUT, entry.INTERRUPTED}
    returned = set()
    for file in (ROOT / "host/wheelhop/cli").glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and node.name == "run":
                values = [part for part in ast.walk(node) if isinstance(part, ast.Return)]
                returned |= {
                    value.value.value for value in values if isinstance(value.value, ast.Constant)
                }
    assert returned <= told


def test_each_status_is_what_the_page_says(tmp_path, capsys):
    assert main(["check", str(EXAMPLES / "clean")]) == 0
    dead = tmp_path / "dead.csv"
    rows = "".join(f"{i / 100},{(i % 7) - 3},0.5\n" for i in range(600))
    dead.write_text(f"time_s,A1,B1\n{rows}")
    assert main(["health", str(dead)]) == 1
    assert main(["check", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_every_command_that_has_json_is_on_the_page():
    (commands,) = (a for a in make_parser()._actions if hasattr(a, "choices") and a.choices)
    named = set(re.findall(r"`(?:wheelhop )?([a-z-]+)(?: [a-z]+)?`", PAGE.split("## JSON")[1]))
    for name, parser in commands.choices.items():
        if any("--json" in action.option_strings for action in parser._actions):
            assert name in named, name


def test_every_schema_of_an_output_is_on_the_page_and_is_there():
    told = set(re.findall(r"`([a-z-]+-output)`", PAGE))
    assert told == {name for name in names() if name.endswith("-output")}


COMMANDS = {
    "check": ["check", EXAMPLES / "open-driver-seat"],
    "frame": ["frame", EXAMPLES / "frame/baja.toml", "--modes", "3"],
    "modes": ["modes", EXAMPLES / "open-driver-seat/vehicle.toml"],
    "rates": [
        *("rates", EXAMPLES / "rig/rear-strut.csv", EXAMPLES / "rig/rear-damper.csv"),
        *("--motion-ratio", "0.7"),
    ],
    "health": ["health", EXAMPLES / "open-dry-friction/runs/herringbone-low-fast.csv"],
    "road": ["road", "cobblestone:height_mm=10:seed=2"],
}


@pytest.mark.parametrize("name", COMMANDS)
def test_what_a_command_writes_fits_its_schema(tmp_path, name):
    """Of other inputs than those the schema was made from."""
    file = tmp_path / "out.json"
    assert main([*map(str, COMMANDS[name]), "--json", str(file)]) in (0, 1)
    assert valid(f"{name}-output", json.loads(file.read_text())) == []


def test_a_schema_refuses_what_lacks_a_name_or_has_another_kind(tmp_path):
    file = tmp_path / "out.json"
    main(["check", str(EXAMPLES / "clean"), "--json", str(file)])
    document = json.loads(file.read_text())
    assert valid("check-output", document) == []
    assert valid("check-output", document | {"runs": "five"})
    assert valid("check-output", {key: document[key] for key in document if key != "runs"})
