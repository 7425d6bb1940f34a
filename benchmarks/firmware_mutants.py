"""Mutants of the firmware: python -m benchmarks.firmware_mutants [--count N] [--seed N]

Small mistakes are planted, one at a time, in the parts that carry samples (ring, sdcard, logfile,
block, link): a comparison that is off by one, a sign, a condition turned round, another number,
a statement left out. Each mutant is compiled into the native tests with the sanitizers
watching. One that fails them, or does not come to an end, is caught; the others are listed.
`--part ring` draws from one part alone, `--all` takes every mutation there is.

A change that no compiler takes, or that leaves the machine code of both boards as it was, is no
mistake: another is drawn in its place.
"""

from __future__ import annotations

import argparse
import random
import re
import shlex
import shutil
import subprocess
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tools.firmware_build import CPP_ONLY, ROOT, compiler_flags, native_command, read_ini, sources

PARTS = ("ring", "sdcard", "logfile", "block", "link")
TESTS = ROOT / "tests/firmware/native/test_parts"

RULES = (
    (r"(?<= )<(?= )", "<="),
    (r"(?<= )<(?= )", ">"),
    (r"<=", "<"),
    (r"(?<= )>(?= )", ">="),
    (r"(?<= )>(?= )", "<"),
    (r"(?<= )>=", ">"),
    (r"==", "!="),
    (r"!=", "=="),
    (r"&&", "||"),
    (r"\|\|", "&&"),
    (r" \+ ", " - "),
    (r" - ", " + "),
    (r"\+= ", "-= "),
    (r"\+\+", "--"),
    (r"\btrue\b", "false"),
    (r"\bfalse\b", "true"),
    (r"(?<=[ (])!(?=[\w(])", ""),
    (r"(?<![\w.])(\d+)(?![\w.])", "number"),
)
"""What is found and what takes its place; of a number another one: see `other_number`."""

BOUNDARY = {"<": "<=", "<=": "<", ">": ">=", ">=": ">"}
TIME_LIMIT = re.compile(r" k\w+Ms\b")
MAXIMUM = re.compile(r"if \((\w+)([\w.]*) > (\w+)\2\) \3 = \1;")

STATEMENT = re.compile(
    r"^\s+(?!return|const|static|auto|uint|int|bool|Block|case|break)[\w(*+-].*;$"
)
"""A line that does something and declares nothing: it may be left out."""

OLD_RING = (
    (
        "    lost_ += number - next_;",
        "    const bool follows = number == next_; lost_ += number - next_;",
    ),
    ("    const bool follows = filling().first_scan + filling().count == number;", ""),
)
"""A mistake that was made: a scan follows if the one before it had the number before, even if that
one found no room."""


@dataclass(frozen=True)
class Mutant:
    """One line of a source file, changed."""

    file: Path
    line: int
    text: str

    @property
    def source(self) -> str:
        """The whole file with the change."""
        lines = self.file.read_text(encoding="utf-8").split("\n")
        lines[self.line - 1] = self.text
        return "\n".join(lines)

    def __str__(self) -> str:
        before = self.file.read_text(encoding="utf-8").split("\n")[self.line - 1].strip()
        where = self.file.relative_to(ROOT / "firmware/lib")
        return f"{where}:{self.line}: {before}  →  {self.text.strip() or '(left out)'}"


@dataclass(frozen=True)
class Remembered(Mutant):
    """A mistake that was made once, over several lines."""

    @property
    def source(self) -> str:
        """The whole file with the mistake."""
        text = self.file.read_text(encoding="utf-8")
        for right, wrong in OLD_RING:
            if right not in text:
                raise SystemExit(
                    f"{self.file}: the ring's rule is not where it was: {right.strip()}"
                )
            text = text.replace(right, wrong)
        return text

    def __str__(self) -> str:
        return self.text


REMEMBERED = Remembered(
    ROOT / "firmware/lib/ring/ring.cpp", 0, "ring/ring.cpp: the ring's earlier rule"
)


def other_number(text: str) -> str:
    """Zero for one, which may be a flag; else one larger; from ten on, where a number is a limit of
    time or patience, twice as large."""
    number = int(text)
    return str(0 if number == 1 else number + 1 if number < 10 else 2 * number)


def is_no_boundary(code: str, at: int) -> bool:
    """Whether nothing depends on a comparison of equals: of milliseconds with a limit of hundreds,
    or where the larger of two is kept."""
    return bool(TIME_LIMIT.match(code, at) or MAXIMUM.search(code))


def mutations(part: str) -> Iterator[Mutant]:
    """Every mutation of a part."""
    for file in sorted((ROOT / "firmware/lib" / part).glob("*.cpp")):
        for number, line in enumerate(file.read_text(encoding="utf-8").split("\n"), start=1):
            code = line.partition("//")[0]
            if not code.strip() or code.lstrip().startswith(("#", "/*", "*", "static_assert")):
                continue
            for pattern, new in RULES:
                for found in re.finditer(pattern, code):
                    if BOUNDARY.get(found[0]) == new and is_no_boundary(code, found.end()):
                        continue
                    put = other_number(found[0]) if new == "number" else new
                    changed = code[: found.start()] + put + code[found.end() :]
                    yield Mutant(file, number, changed.rstrip())
            if STATEMENT.match(code.rstrip()):
                yield Mutant(file, number, "")


def drawn(parts: tuple[str, ...], seed: int) -> Iterator[Mutant]:
    """All of them in random order, from each part in turn."""
    rng = random.Random(seed)
    pools = []
    for part in parts:
        pool = list(mutations(part))
        rng.shuffle(pool)
        pools.append(pool)
    while any(pools):
        yield from [pool.pop() for pool in pools if pool]


class Boards:
    """The machine code that the boards run, one source file at a time.

    What an optimizing compiler makes the same of two texts means the same: trivial compiler
    equivalence (Papadakis and others, ICSE 2015).
    """

    def __init__(self, folder: Path) -> None:
        ini = read_ini()
        self.folder = folder
        self.includes = [f"-I{path}" for path in sources(ini).folders]
        self.flags = []
        for env in ("nano", "mega"):
            flags = [flag for flag in compiler_flags(ini, env) if flag != "-flto"]
            self.flags.append([[*flags, "-w"], [*flags, "-w", "-O3"]])

    def code(self, file: Path, source: str, flags: list[str]) -> bytes:
        """The object file."""
        copy, target = self.folder / file.name, self.folder / "board.o"
        copy.write_text(source, encoding="utf-8")
        command = ["avr-g++", *shlex.split(CPP_ONLY), *flags, *self.includes, "-c"]
        subprocess.run([*command, copy, "-o", target], cwd=ROOT, check=True)
        return target.read_bytes()

    def run_the_same(self, mutant: Mutant) -> bool:
        """Whether a mutant changes nothing, on either board."""
        text = mutant.file.read_text(encoding="utf-8")

        def same(flags: list[str]) -> bool:
            unchanged = self.code(mutant.file, text, flags)
            return self.code(mutant.file, mutant.source, flags) == unchanged

        return all(any(same(flags) for flags in board) for board in self.flags)


class Workbench:
    """The native tests, compiled once; a mutant replaces one object."""

    def __init__(self, folder: Path) -> None:
        command = native_command(TESTS, folder / "unused")
        command = command[: command.index("-o")]
        self.sources = [Path(a) for a in command if a.endswith((".cpp", ".c"))]
        self.flags = [a for a in command if not a.endswith((".cpp", ".c"))] + ["-O1"]
        self.folder = folder
        self.order: list[str] = []
        self.objects = {}
        for i, source in enumerate(self.sources):
            whole = (ROOT / source).resolve()
            self.objects[whole] = folder / f"{i}.o"
            self._compile(whole, self.objects[whole])
        self.image = folder / "card.img"
        vfat = shutil.which("mkfs.vfat", path="/usr/sbin:/sbin:/usr/bin") or "mkfs.vfat"
        empty = [vfat, "--invariant", "-F", "16", "-s", "1", "-C", str(self.image), "8192"]
        subprocess.run(empty, check=True, capture_output=True)

    def _compile(self, source: Path, target: Path, check: bool = True) -> bool:
        command = [*self.flags, "-c", str(source), "-o", str(target)]
        done = subprocess.run(command, check=check, cwd=ROOT, capture_output=True)
        return done.returncode == 0

    def _run(self, objects: dict[Path, Path]) -> subprocess.CompletedProcess[str]:
        program = self.folder / "parts"
        link = [self.flags[0], "-fsanitize=address,undefined", *map(str, objects.values())]
        subprocess.run([*link, "-o", str(program)], check=True, capture_output=True)
        return subprocess.run(
            [program, self.image, *self.order], capture_output=True, text=True, errors="replace"
        )

    def prepare(self) -> None:
        """The tests pass without a mutant; what takes long is asked last."""
        done = self._run(self.objects)
        if done.returncode:
            raise SystemExit("the tests fail without any mutant")
        taken_us = re.findall(r"^(\w+) took (\d+) us", done.stdout, re.MULTILINE)
        self.order = [name for name, _ in sorted(taken_us, key=lambda test: int(test[1]))]

    def outcome(self, mutant: Mutant) -> str:
        """The test that fails with it; "survived", or "no program" where it does not compile."""
        source = self.folder / mutant.file.name
        source.write_text(mutant.source, encoding="utf-8")
        changed = self.folder / "mutant.o"
        if not self._compile(source, changed, check=False):
            return "no program"
        try:
            done = self._run({**self.objects, mutant.file: changed})
        except subprocess.CalledProcessError:
            return "no program"
        if not done.returncode:
            return "survived"
        failed = re.search(r"^(\w+):FAILED", done.stdout, re.MULTILINE)
        return failed[1] if failed else "broken off"


def main() -> None:
    """Draw, plant, count."""
    parser = argparse.ArgumentParser(description="Mutants of the firmware that its tests catch")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--part", choices=PARTS, action="append")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--verbose", action="store_true", help="say what catches each")
    arguments = parser.parse_args()
    parts = tuple(arguments.part or PARTS)
    count = 10**6 if arguments.all else arguments.count
    caught: Counter[str] = Counter()
    survived: Counter[str] = Counter()
    redrawn = 0
    with tempfile.TemporaryDirectory() as name:
        boards, bench = Boards(Path(name)), Workbench(Path(name))
        bench.prepare()
        if "ring" in parts:
            print(f"{REMEMBERED}: {bench.outcome(REMEMBERED)}", flush=True)
        for mutant in drawn(parts, arguments.seed):
            if caught.total() + survived.total() == count:
                break
            outcome = bench.outcome(mutant)
            survives = outcome == "survived"
            if outcome == "no program" or (survives and boards.run_the_same(mutant)):
                redrawn += 1
                continue
            (survived if survives else caught)[mutant.file.parent.name] += 1
            if survives or arguments.verbose:
                print(f"{outcome}: {mutant}", flush=True)
    for part in parts:
        print(f"{part:8} {caught[part]} of {caught[part] + survived[part]} caught")
    total = caught.total() + survived.total()
    print(f"{caught.total()} of {total} caught, {caught.total() / total:.0%}; {redrawn} redrawn")


if __name__ == "__main__":
    main()
