"""Without a library that only a part of wheelhop needs, that part says how to install it."""

import sys

import pytest

from wheelhop.cli.main import main

PARTS = {
    "serial": (["logger", "list", "--port", "/dev/nowhere"], "logger"),
    "nicegui": (["workbench", "--no-browser"], "workbench"),
    "shtab": (["completion", "bash"], "completion"),
}


@pytest.mark.parametrize("package", PARTS)
def test_what_is_missing_is_one_line_with_the_command_that_installs_it(
    package, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, package, None)  # as if it were not installed
    arguments, extra = PARTS[package]
    assert main(arguments) == 2
    said = capsys.readouterr().err
    assert f"needs {package}: pip install 'wheelhop[{extra}]'" in said and said.count("\n") == 1
