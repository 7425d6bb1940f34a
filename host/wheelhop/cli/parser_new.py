"""What `wheelhop new` takes: every question is an option."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from wheelhop.workbench.questions import QUESTIONS, Question


def add_new(commands: Any) -> None:
    """Add the command; makes it without loading any other package."""
    new = commands.add_parser(
        "new", help="begin a vehicle.toml: asks what you know, estimates the rest"
    )
    new.add_argument("folder", metavar="FOLDER", type=Path, help="where to: a campaign's folder")
    new.add_argument("--name", help="of the vehicle (default: the folder's name)")
    for question in QUESTIONS:
        new.add_argument(
            question.option,
            metavar=question.unit or "RATIO",
            type=lambda text, ask=question: _answer(ask, text),
            help=question.words,
        )


def _answer(question: Question, text: str) -> float:
    try:
        return question.read(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None
