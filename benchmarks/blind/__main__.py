"""python -m benchmarks.blind generate|run|table|compare [--seeds published] [--short] …"""

from __future__ import annotations

import argparse
import signal
import sys
import tomllib
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from functools import partial
from multiprocessing import active_children, get_context
from pathlib import Path
from typing import Any

from benchmarks.blind import compare, table
from benchmarks.blind.answers import read_answers, write_answers
from benchmarks.blind.generate import generate
from benchmarks.blind.picture import draw_confusion
from benchmarks.blind.plan import DEV_ROUNDS, FIRST_SEED, KINDS, Case, plan
from benchmarks.blind.recipes import RECIPES
from benchmarks.blind.run import ask
from benchmarks.blind.score import Outcome, outcome
from benchmarks.blind.statistics import confusion
from benchmarks.blind.work import Work, default_work, read_json, write_json
from wheelhop.effects import load_effects

Answer = dict[str, Any]


def main(argv: Sequence[str] | None = None) -> int:
    """Parse, do, print."""
    given = _parser().parse_args(argv)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # so that no worker is left behind
    work = Work(given.work, given.short, given.label)
    cases = _chosen(given)
    try:
        commands = {"generate": _generate, "run": _run, "table": _table, "compare": _compare}
        return commands[given.command](cases, work, given)
    except KeyboardInterrupt:
        print("interrupted; what is done is kept", file=sys.stderr)
        return 130


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind", description=__doc__)
    parser.add_argument("command", choices=("generate", "run", "table", "compare"))
    parser.add_argument("--seeds", choices=FIRST_SEED, default="dev", help="which ones (dev)")
    parser.add_argument("--rounds", type=int, default=1, help="of 200 seeds (1)")
    parser.add_argument("--first-round", type=int, default=0, help="begin with this round (0)")
    parser.add_argument("--short", action="store_true", help="8 runs per campaign, not 18")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS)
    parser.add_argument("--effects", nargs="+", default=(), help="only cases that hide one of them")
    parser.add_argument("--work", type=Path, default=default_work(), help=f"({default_work()})")
    parser.add_argument("--label", default="latest", help="name of a set of results (latest)")
    parser.add_argument("--jobs", type=int, default=1, help="cases at the same time (1)")
    parser.add_argument("--threads", type=int, default=2, help="of each diagnosis (2)")
    parser.add_argument(
        "--answers", type=Path, nargs="+", default=(), help="count those of earlier tables, too"
    )
    parser.add_argument("--budget", help="with run: what each diagnosis may spend, s, or none")
    parser.add_argument("--before", help="with compare: the set of results to compare with")
    parser.add_argument("--again", action="store_true", help="forget earlier results")
    return parser


def _chosen(given: argparse.Namespace) -> list[Case]:
    available = RECIPES.keys() & load_effects().keys()
    if given.seeds == "dev" and given.first_round + given.rounds > DEV_ROUNDS:
        raise SystemExit(f"there are {DEV_ROUNDS} rounds of development seeds")
    first = FIRST_SEED[given.seeds] + 200 * given.first_round
    return [
        case
        for case in plan(first, given.rounds, available)
        if case.kind in given.kinds and (not given.effects or set(given.effects) & set(case.hidden))
    ]


def _generate(cases: Sequence[Case], work: Work, given: argparse.Namespace) -> int:
    missing = {
        case.campaign: case
        for case in cases
        if case.kind != "without" and (given.again or not work.truth_json(case.campaign).is_file())
    }

    def say(case: Case, made: Answer) -> str:
        strength = made.get("unreachable") or f"{made['baseline_over_floor']:.2f} x floor"
        return f"{case.campaign}: {strength}, {made['seconds']} s"

    return _each(list(missing.values()), partial(generate, work=work), say, given.jobs)


def _run(cases: Sequence[Case], work: Work, given: argparse.Namespace) -> int:
    waiting = [
        case
        for case in cases
        if work.truth_json(case.campaign).is_file()
        and work.campaign(case.campaign).is_dir()
        and (given.again or not work.answered(case.name, case.campaign))
    ]

    def say(case: Case, ended: Answer) -> str:
        seen = _outcome(case, work)
        assert seen is not None
        said = f"{', '.join(seen.verdict) or 'no answer'} ({seen.confidence:.2f})"
        return f"{case.name}: {said}, {ended['seconds']} s{'' if seen.passed else '  FAIL'}"

    return _each(
        waiting,
        partial(ask, work=work, threads=given.threads, budget=given.budget),
        say,
        given.jobs,
    )


def _each(
    cases: Sequence[Case],
    do: Callable[[Case], Answer],
    say: Callable[[Case, Answer], str],
    jobs: int,
) -> int:
    """Print a line as each case is done; an error in one of them does not stop the others."""
    failed = 0
    for number, (case, finish) in enumerate(_finished(cases, do, jobs), start=1):
        try:
            line = say(case, finish())
        except Exception as error:
            failed += 1
            line = f"{case.name}: {type(error).__name__}: {error}"
        print(f"[{number}/{len(cases)}] {line}", flush=True)
    return 1 if failed else 0


def _finished(
    cases: Sequence[Case], do: Callable[[Case], Answer], jobs: int
) -> Iterator[tuple[Case, Callable[[], Answer]]]:
    """Each case with a function that gives, or raises, what came of it; in the order they end."""
    if jobs == 1:
        yield from ((case, partial(do, case)) for case in cases)
        return
    with ProcessPoolExecutor(jobs, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(do, case): case for case in cases}
        try:
            yield from ((futures[done], done.result) for done in as_completed(futures))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for worker in active_children():
                worker.terminate()
            raise


def _table(cases: Sequence[Case], work: Work, given: argparse.Namespace) -> int:
    stored, unmade = dict[str, Outcome](), set[str]()
    for file in given.answers:
        if not file.is_file():
            raise SystemExit(f"{file}: no such file; `table` writes answers.csv beside its table")
        answers, missing = read_answers(file, cases)
        stored |= answers
        unmade |= missing
    answered = (_outcome(case, work) or stored.get(case.name) for case in cases)
    outcomes = [outcome for outcome in answered if outcome is not None]
    if not outcomes:
        raise SystemExit("no results yet: generate, then run")
    unmade |= {case.name for case in cases if case.kind != "without" and _is_unmade(case, work)}
    runs = 8 if given.short else 18
    counted = unmade.union(outcome.name for outcome in outcomes)
    first = min(case.seed for case in cases if case.name in counted)
    title = f"Blind benchmark, {given.seeds} seeds from {first}, {runs} runs per campaign"
    written = table.text(outcomes, title=title, short=given.short, unreachable=len(unmade))
    print(written, end="")
    folder = work.table()
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "table.txt").write_text(written)
    write_answers(folder / "answers.csv", outcomes, sorted(unmade))
    write_json(folder / "table.json", table.document(outcomes, title=title, short=given.short))
    draw_confusion(confusion(outcomes), folder / "confusion.png")
    print(f"\nin {folder}")
    return 0


def _compare(cases: Sequence[Case], work: Work, given: argparse.Namespace) -> int:
    """Print what two sets of results say otherwise; 1 if a verdict differs."""
    if given.before is None:
        raise SystemExit("compare: say with --before which set of results to compare with")
    earlier = replace(work, label=given.before)
    both = [(_outcome(case, earlier), _outcome(case, work)) for case in cases]
    pairs = [(before, after) for before, after in both if before and after]
    if not pairs:
        raise SystemExit(f"no campaign has results called {given.before} and {given.label}")
    print(compare.text(pairs), end="")
    return 1 if compare.differing(pairs) else 0


def _is_unmade(case: Case, work: Work) -> bool:
    return "unreachable" in (read_json(work.truth_json(case.campaign)) or {})


def _outcome(case: Case, work: Work) -> Outcome | None:
    if not work.answered(case.name, case.campaign):
        return None
    made, ended = read_json(work.truth_json(case.campaign)), read_json(work.timing(case.name))
    if made is None or ended is None or "unreachable" in made:
        return None
    truth = tomllib.loads(work.truth_toml(case.campaign).read_text())
    return outcome(case, made, ended, read_json(work.diagnosis(case.name)), truth)


if __name__ == "__main__":
    sys.exit(main())
