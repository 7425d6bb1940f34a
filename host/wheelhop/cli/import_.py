"""`wheelhop import`: recordings of other recorders, into SI, as a mapping says or as understood."""

from __future__ import annotations

import sys
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from rich import box
from rich.markup import escape
from rich.table import Table

from wheelhop.cli.convert import check_target, in_words
from wheelhop.cli.output import open_console
from wheelhop.cli.progress import stages
from wheelhop.files import made_folder
from wheelhop.formats import (
    ExchangeError,
    Map,
    Understood,
    is_foreign,
    losses,
    read_mapping,
    understand,
    write,
)
from wheelhop.formats.mapping import ASKED
from wheelhop.formats.registry import load, recording_of
from wheelhop.formats.understood_tables import of_tables
from wheelhop.logger.recording import Recording


def run(arguments: Namespace) -> int:
    """Import each file, or print a draft of the mapping; raises ExchangeError."""
    answers = dict(_answer(word) for word in arguments.answer)
    if arguments.draft:
        for file in arguments.files:
            sys.stdout.write(understand(file, answers).text())
        return 0
    mapping = read_mapping(arguments.map) if arguments.map else None
    if mapping is not None and answers:
        raise ExchangeError(f"--answer: what {arguments.map} says counts: write the answer there")
    with made_folder(arguments.out):
        _import(arguments, mapping, answers)
    return 0


def _answer(word: str) -> tuple[str, str]:
    """`rate_hz=500` as a key and its value."""
    key, equals, value = word.partition("=")
    if not equals:
        raise ExchangeError(f"--answer: '{word}' is not KEY=VALUE, such as rate_hz=500")
    return key.strip(), value.strip()


def _import(arguments: Namespace, mapping: Map | None, answers: dict[str, str]) -> None:
    targets = [_target(file, arguments) for file in arguments.files]
    for target in targets:
        if targets.count(target) > 1:
            raise ExchangeError(f"{target}: two files would become this one: import them apart")
    shown, told = dict[object, str](), dict[object, str]()
    for file, target in zip(arguments.files, targets, strict=True):
        check_target(target, arguments.force, *arguments.files)
        recording = _read(file, mapping, answers, arguments.yes, shown)
        with stages() as stage:
            stage(f"writing {target}")
            write(recording, target)
        print(f"{target}: {in_words(recording)}", flush=True)
        lost = (f"lost: {x}" for x in losses(recording, target.suffix))
        steps = (*recording.history, *lost)
        like = told.setdefault(tuple(step.replace(file.name, "") for step in steps), file.name)
        for step in steps if like == file.name else (f"as {like}",):
            print(f"  {step}")


def _read(
    file: Path, mapping: Map | None, answers: dict[str, str], yes: bool, shown: dict[object, str]
) -> Recording:
    """A recording, as the mapping says, or else as it is understood, which is `shown`. What has to
    be known and is not said is asked; with `yes` nothing is asked, and nothing guessed."""
    granted: tuple[str, ...] = ()
    tables = None
    if mapping is None and not answers and not is_foreign(file):
        with stages() as stage:
            stage(f"reading {file}")
            tables = load(file)
        if len(tables) == 1 and not tables[0].own and tables[0].header is None:
            found = of_tables(file, tables, {})
            if found.questions:
                tables = None
            else:
                _show(found, shown)
    if mapping is None and tables is None:
        found = _understood(file, answers, yes, shown)
        mapping, granted = found.mapping(places=not yes), found.granted(places=not yes)
    with stages() as stage:
        stage(f"reading {file}")
        if tables is None:
            tables = load(file, mapping)
        recording = recording_of(file, tables, mapping, guess=not yes)
    return replace(recording, history=(*recording.history, *granted))


def _understood(
    file: Path, answers: dict[str, str], yes: bool, shown: dict[object, str]
) -> Understood:
    answers = dict(answers)
    found = understand(file, answers)
    while found.questions and sys.stdin.isatty() and not yes:
        _show(found, shown)
        for question in found.questions:
            print(f"{file.name}: {question.words}")
            answer = input(f"{question.key}, {ASKED[question.key]}: ").strip()
            if not answer:
                break
            answers[question.key] = answer
        else:
            found = understand(file, answers)
            continue
        break
    if found.questions:
        asked = "; ".join(f"{question.key}: {question.words}" for question in found.questions)
        keys = " ".join(f"--answer {question.key}=…" for question in found.questions)
        raise ExchangeError(f"{file}: is not known, {asked}: say {keys}, or write a mapping")
    if found.guesses and yes:
        raise ExchangeError(
            f"{file}: would have to be guessed: {'; '.join(found.guesses)}: say so in a mapping"
            " (--draft begins one)"
        )
    _show(found, shown)
    return found


def _show(found: Understood, shown: dict[object, str]) -> None:
    """What was understood of a file, column by column; or which of those `shown`, by what was
    understood of them, is like it."""
    console, name = open_console(), found.path.name
    words = found.words() or "as it says itself"
    like = shown.setdefault((words, found.columns), name)
    if like != name:
        console.print(escape(f"{name}: as {like}"), soft_wrap=True)
        return
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in ("column", "unit", "taken for", "why"):
        table.add_column(heading)
    for column in found.columns:
        place = f", at {column.point}" if column.placed else ""
        cells = (column.label, column.unit, f"{column.taken_for}{place}", column.why)
        table.add_row(*map(escape, cells))  # brackets are units here
    console.print(escape(f"{name}: {words}"), soft_wrap=True)
    console.print(table)


def _target(file: Path, arguments: Namespace) -> Path:
    folder: Path = arguments.out
    return folder / f"{file.stem}{arguments.to}"
