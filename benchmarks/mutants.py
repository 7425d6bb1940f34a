"""Mutants of the host: python -m benchmarks.mutants [--part NAME] [--count N] [--seed N]

Small mistakes are planted, one at a time, in what results stand on: formats, score, fit and floor.
A comparison is off by one or turned round, a sign changes, a number is another, a statement is left
out. One that fails the part's tests, or does not come to an end, is caught; the others are listed,
for somebody to say whether a test is missing or nothing depends on what was changed.

Mistakes that tests once let pass are planted first, whatever the seed.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
HOST = "host/wheelhop"
LINKED = ("calibration", "hil_sim", "tests", "examples", "benchmarks", "docs", "pyproject.toml")


@dataclass(frozen=True)
class Part:
    """Files of the host, and the tests that are there for them."""

    files: tuple[str, ...]
    tests: tuple[str, ...]


PARTS = {
    "formats": Part(
        ("formats/*.py", "files/units.py"),
        (
            *("tests/files/test_units.py", "tests/api/test_frames.py"),
            *("tests/campaign/test_mistakes.py", "tests/formats"),
        ),
    ),
    "score": Part(
        ("diagnose/score.py",),
        (
            *("tests/diagnose/test_score_bounds.py", "tests/diagnose/test_evidence.py"),
            *("tests/diagnose/test_rotate.py", "tests/diagnose/test_score.py"),
        ),
    ),
    "fit": Part(
        ("fit/*.py",),
        (
            *("tests/fit/test_linear.py", "tests/fit/test_steps.py", "tests/fit/test_density.py"),
            *("tests/fit/test_linear_heights.py", "tests/fit/test_parameters.py"),
            *("tests/fit/test_component.py", "tests/fit/test_result.py"),
            *("tests/fit/test_harmonics.py", "tests/fit/test_bumps.py", "tests/fit/test_bench.py"),
            *("tests/effects/test_roughness.py", "tests/component/test_start.py"),
            *("tests/diagnose/test_rotate.py", "tests/diagnose/test_score.py", "tests/fit"),
        ),
    ),
    "floor": Part(
        ("compare/floor.py",), ("tests/compare/test_floor.py", "tests/compare/test_scale_floor.py")
    ),
}

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    **{ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt},
    **{ast.Eq: ast.NotEq, ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is},
    **{ast.In: ast.NotIn, ast.NotIn: ast.In},
}
OPERATORS: dict[type[ast.operator], type[ast.operator]] = {
    **{ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult},
}


@dataclass(frozen=True)
class Mutant:
    """A file of the host with one mistake in it; `words` say which."""

    part: str
    file: Path
    source: str
    words: str


REMEMBERED = (
    ("formats", "files/units.py", '1e-2, "centimetres per s', '1e-1, "centimetres per s'),
    ("score", "diagnose/score.py", "tried * float(np.exp", "float(np.exp"),
    ("score", "diagnose/score.py", "run.charged / (1.0 - spent)", "run.charged"),
    ("score", "diagnose/score.py", "run.heights.penalty - run.heights.log_volume", "0.0"),
)
"""Mistakes that were once not seen: a factor of a unit, no Bonferroni, heights free of charge."""


def main() -> int:
    """Plant mistakes, print those that no test has seen; exit code 1 if fewer than nine of ten
    were caught."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--part", choices=PARTS, action="append", help="default: all")
    parser.add_argument("--count", type=int, default=20, help="of each part (default 20)")
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    caught = tried = 0
    for part in arguments.part or PARTS:
        with tempfile.TemporaryDirectory() as place:
            tree = make_tree(Path(place))
            if not passes(tree, part):
                raise SystemExit(f"{part}: its tests fail before anything is changed")
            drawn = list(mutants(part))
            random.Random(arguments.seed).shuffle(drawn)
            chosen = [*remembered(part), *drawn[: arguments.count]]
            seen = 0
            for mutant in chosen:
                if survives(tree, mutant):
                    print(f"not seen: {mutant.file.relative_to(ROOT / HOST)}: {mutant.words}")
                else:
                    seen += 1
        print(f"{part}: {seen} of {len(chosen)} caught; {len(drawn)} could be planted", flush=True)
        caught, tried = caught + seen, tried + len(chosen)
    print(f"{caught} of {tried} caught, {caught / tried:.0%}")
    return 0 if caught >= 0.9 * tried else 1


def make_tree(place: Path) -> Path:
    """A source tree whose host is a copy and whose other folders are those of this one."""
    subprocess.run(["cp", "-r", str(ROOT / "host"), str(place)], check=True)
    for name in LINKED:
        (place / name).symlink_to(ROOT / name)
    return place


def passes(tree: Path, part: str) -> bool:
    """Whether the part's tests pass in a tree; not if they take ten times as long as ever."""
    paths = (tree / name for name in ("host", "calibration", "hil_sim", ""))
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    try:
        done = subprocess.run(
            [*command, *PARTS[part].tests],
            cwd=tree,
            env=os.environ | {"PYTHONPATH": ":".join(map(str, paths))},
            capture_output=True,
            timeout=1200,
        )
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def survives(tree: Path, mutant: Mutant) -> bool:
    """Whether no test sees the mistake."""
    place = tree / mutant.file.relative_to(ROOT)
    before = place.read_text(encoding="utf-8")
    try:
        place.write_text(mutant.source, encoding="utf-8")
        return passes(tree, mutant.part)
    finally:
        place.write_text(before, encoding="utf-8")


def remembered(part: str) -> Iterator[Mutant]:
    """The mistakes in this part that were once not seen."""
    for where, name, right, wrong in REMEMBERED:
        if where == part:
            file = ROOT / HOST / name
            text = file.read_text(encoding="utf-8")
            if text.count(right) != 1:
                raise SystemExit(f"{file}: not once in it: {right}")
            yield Mutant(part, file, text.replace(right, wrong), f"{right}  →  {wrong}")


def mutants(part: str) -> Iterator[Mutant]:
    """Every mistake that can be planted in a part."""
    for pattern in PARTS[part].files:
        for file in sorted((ROOT / HOST).glob(pattern)):
            text = file.read_text(encoding="utf-8")
            lines = text.split("\n")
            for node in code_of(ast.parse(text)):
                for changed in changes(node):
                    assert node.end_lineno is not None
                    first, last = lines[node.lineno - 1], lines[node.end_lineno - 1]
                    piece = [
                        _before(first, node.col_offset) + changed,
                        _behind(last, node.end_col_offset or 0),
                    ]
                    source = [*lines[: node.lineno - 1], "".join(piece), *lines[node.end_lineno :]]
                    words = f"{node.lineno}: {ast.unparse(node)[:60]}  →  {changed[:60]}"
                    yield Mutant(part, file, "\n".join(source), words)


def code_of(tree: ast.Module) -> Iterator[ast.expr | ast.stmt]:
    """What a module computes: not its types, its imports and its docstrings."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import | ast.ImportFrom | ast.Raise | ast.JoinedStr):
            continue
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.expr | ast.stmt):
            yield node
        for name, value in ast.iter_fields(node):
            if name not in ("annotation", "returns", "decorator_list", "bases"):
                children = value if isinstance(value, list) else [value]
                waiting += [child for child in children if isinstance(child, ast.AST)]


def changes(node: ast.expr | ast.stmt) -> Iterator[str]:
    """The mistakes that can be made of a node, each as its source text."""
    if isinstance(node, ast.Compare) and type(node.ops[0]) in COMPARISONS:
        ops = [COMPARISONS[type(node.ops[0])](), *node.ops[1:]]
        yield _text(ast.Compare(node.left, ops, node.comparators))
    elif isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        yield _text(ast.BinOp(node.left, OPERATORS[type(node.op)](), node.right))
    elif isinstance(node, ast.BoolOp):
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        yield _text(ast.BoolOp(other, node.values))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not | ast.USub):
        yield _text(node.operand)
    elif isinstance(node, ast.Constant) and isinstance(node.value, bool):
        yield str(not node.value)
    elif isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        yield _other_number(node.value)
    elif isinstance(node, ast.Expr | ast.AugAssign):
        yield "pass"


def _other_number(value: float) -> str:
    """Zero for one, which may be a flag; what is large, and often a limit, differs by much."""
    if isinstance(value, float):
        return repr(2.0 * value or 0.1)
    return str(0 if value == 1 else value + 1 if value < 10 else 2 * value)


def _text(node: ast.expr) -> str:
    return f"({ast.unparse(ast.fix_missing_locations(node))})"


def _before(line: str, column: int) -> str:
    """A column of a syntax tree counts bytes."""
    return line.encode()[:column].decode()


def _behind(line: str, column: int) -> str:
    return line.encode()[column:].decode()


if __name__ == "__main__":
    sys.exit(main())
