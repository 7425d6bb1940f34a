"""`wheelhop new`: a vehicle.toml from what a user knows; the rest is estimated, and marked."""

from __future__ import annotations

import sys
from argparse import Namespace

from wheelhop.campaign.sample import marked_numbers
from wheelhop.campaign.types import CampaignError
from wheelhop.files import made_folder, write_text
from wheelhop.vehicle import read_vehicle
from wheelhop.vehicle.estimate import ESTIMATED, vehicle_toml
from wheelhop.workbench.questions import QUESTIONS, Answers, Question, known


def run(arguments: Namespace) -> int:
    """Ask what the options do not say, where somebody can answer; write FOLDER/vehicle.toml.

    Raises CampaignError for what is missing, and for a vehicle.toml that is there.
    """
    file = arguments.folder / "vehicle.toml"
    if file.exists():
        raise CampaignError(f"{file}: is there already: edit it, or delete it first")
    given: Answers = {question.name: vars(arguments)[question.name] for question in QUESTIONS}
    if sys.stdin.isatty():
        given = _asked(given)
    missing = [q for q in QUESTIONS if q.needed and given[q.name] is None]
    if missing:
        raise CampaignError(f"say {', '.join(f'{q.option} {q.unit.upper()}' for q in missing)}")
    text = vehicle_toml(known(arguments.name or arguments.folder.resolve().name, given))
    with made_folder(arguments.folder):
        write_text(file, text, CampaignError)
    numbers, guessed = read_vehicle(file).values, marked_numbers(file, ESTIMATED)
    print(f"{file}: {len(numbers)} numbers, {len(guessed)} of them estimated and marked so.")
    print("docs/vehicle-file.md says how to measure each of them.")
    print(f"Next: wheelhop campaign new {arguments.folder} RECORDING")
    return 0


def _asked(given: Answers) -> Answers:
    print("Press Enter where you do not know: it is estimated. Ctrl-C ends without a file.")
    answers: dict[str, float | None] = dict(given)
    for question in QUESTIONS:
        end, _, rest = question.name.partition("_")
        spring = answers.get(f"{end}_spring_n_mm")
        idle = {"motion_ratio": spring is None, "ride_hz": spring is not None}
        if answers[question.name] is None and not idle.get(rest, False):
            answers[question.name] = _ask(question)
    return answers


def _ask(question: Question) -> float | None:
    unit = f", {question.unit}" if question.unit else ""
    while True:
        try:
            text = input(f"{question.words}{unit}: ").strip()
        except EOFError:
            return None
        if not text and not question.needed:
            return None
        try:
            return question.read(text)
        except ValueError as error:
            print(f"  {error if text else 'this one is needed'}")
