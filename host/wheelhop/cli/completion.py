"""`wheelhop completion`: what a shell needs to complete commands, options and files."""

from __future__ import annotations

import argparse
from argparse import Namespace
from collections.abc import Iterator
from pathlib import Path

from wheelhop.cli.parser import make_parser
from wheelhop.files import require


def run(arguments: Namespace) -> int:
    """Print the script of a shell; raises InputError where the library that makes it is missing."""
    require("shtab", "completion", "completion")
    import shtab

    parser = make_parser()
    for action in _actions(parser):
        if action.type is Path:
            action.complete = shtab.FILE  # type: ignore[attr-defined]
    print(shtab.complete(parser, arguments.shell))
    return 0


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Every argument of the parser and of the commands below it."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _actions(below)
        else:
            yield action
