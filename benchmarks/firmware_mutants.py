"""Mutants of the firmware: python -m benchmarks.firmware_mutants [--count N] [--seed N]

Small mistakes are planted, one at a time, in every part that is not the chip's own (`board`) and
has tests without a board (all but `console`): a comparison that is off by one, a sign, a condition
turned round, another number, a statement left out. Each mutant is compiled into the native tests
with the sanitizers watching; what stands in a header, into everything that includes it. One that
fails them, or does not come to an end, is caught; the others are listed. `--part ring` draws from
one part alone, `--all` takes every mutation there is. Ctrl-C ends it with the table so far.

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
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from tools.firmware_build import CPP_ONLY, ROOT, compiler_flags, native_command, read_ini, sources

PARTS = (
    *("ring", "sdcard", "logfile", "block", "link", "session", "sampler", "beside", "config"),
    *("panel", "text", "crc"),
)
"""All but `console`, which the tests on the simulated board hold, and `board` itself."""
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
    folder = ROOT / "firmware/lib" / part
    for file in sorted([*folder.glob("*.cpp"), *folder.glob("*.h")]):
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


class Sources:
    """A copy of the firmware's sources, in which mistakes are planted, and what includes what."""

    def __init__(self, folder: Path, tests: Path) -> None:
        self.root = folder / "firmware"
        shutil.copytree(ROOT / "firmware", self.root)
        command = [self._moved(part) for part in native_command(tests, folder / "unused")]
        command = command[: command.index("-o")]
        self.files = [(ROOT / part).resolve() for part in command if part.endswith((".cpp", ".c"))]
        self.flags = [part for part in command if not part.endswith((".cpp", ".c"))] + ["-O1"]
        self.includes = {file: self._includes(file) for file in self.files}

    def _moved(self, part: str) -> str:
        return part.replace(str(ROOT / "firmware"), str(self.root))

    def _includes(self, file: Path) -> set[Path]:
        command = [*self.flags, "-MM", str(file)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        words = done.stdout.replace("\\\n", " ").split()[1:]
        return {(ROOT / word).resolve() for word in words}

    def place(self, mutant: Mutant) -> Path:
        """Where the file that a mutant changes stands in the copy."""
        return Path(self._moved(str(mutant.file)))

    def dependent(self, mutant: Mutant) -> list[Path]:
        """The files to be compiled with it."""
        place = self.place(mutant)
        return [file for file in self.files if file == place or place in self.includes[file]]

    @contextmanager
    def planted(self, mutant: Mutant) -> Iterator[None]:
        """The copy has the mistake while the block runs."""
        place = self.place(mutant)
        place.write_text(mutant.source, encoding="utf-8")
        try:
            yield
        finally:
            shutil.copyfile(mutant.file, place)


class Boards:
    """The machine code that the boards run, one source file at a time.

    What an optimizing compiler makes the same of two texts means the same: trivial compiler
    equivalence (Papadakis and others, ICSE 2015).
    """

    def __init__(self, tree: Sources) -> None:
        ini = read_ini()
        self.tree = tree
        self.includes = [
            f"-I{tree.root / path.relative_to(ROOT / 'firmware')}" for path in sources(ini).folders
        ]
        self.flags = []
        for env in ("nano", "mega"):
            flags = [flag for flag in compiler_flags(ini, env) if flag != "-flto"]
            self.flags.append([[*flags, "-w"], [*flags, "-w", "-O3"]])

    def code(self, mutant: Mutant, flags: list[str]) -> list[bytes]:
        """The object files of what a mutant may change."""
        target = self.tree.root / "board.o"
        ours = [f for f in self.tree.dependent(mutant) if f.is_relative_to(self.tree.root / "lib")]
        codes = []
        for file in ours:
            command = ["avr-g++", *shlex.split(CPP_ONLY), *flags, *self.includes, "-c"]
            subprocess.run([*command, file, "-o", target], cwd=ROOT, check=True)
            codes.append(target.read_bytes())
        return codes

    def run_the_same(self, mutant: Mutant) -> bool:
        """Whether a mutant changes nothing, on either board."""

        def same(flags: list[str]) -> bool:
            unchanged = self.code(mutant, flags)
            with self.tree.planted(mutant):
                return self.code(mutant, flags) == unchanged

        return all(any(same(flags) for flags in board) for board in self.flags)


class Workbench:
    """The native tests, compiled once; a mutant replaces the objects that depend on it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.tree = Sources(folder, TESTS)
        self.order: list[str] = []
        self.objects = {file: folder / f"{i}.o" for i, file in enumerate(self.tree.files)}
        for file, target in self.objects.items():
            self._compile(file, target)
        self.image = folder / "card.img"
        vfat = shutil.which("mkfs.vfat", path="/usr/sbin:/sbin:/usr/bin") or "mkfs.vfat"
        empty = [vfat, "--invariant", "-F", "16", "-s", "1", "-C", str(self.image), "8192"]
        subprocess.run(empty, check=True, capture_output=True)

    def _compile(self, source: Path, target: Path, check: bool = True) -> bool:
        command = [*self.tree.flags, "-c", str(source), "-o", str(target)]
        done = subprocess.run(command, check=check, cwd=ROOT, capture_output=True)
        return done.returncode == 0

    def _run(self, objects: dict[Path, Path]) -> subprocess.CompletedProcess[str]:
        program = self.folder / "parts"
        link = [self.tree.flags[0], "-fsanitize=address,undefined", *map(str, objects.values())]
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
        changed = dict(self.objects)
        with self.tree.planted(mutant):
            for number, file in enumerate(self.tree.dependent(mutant)):
                changed[file] = self.folder / f"mutant{number}.o"
                if not self._compile(file, changed[file], check=False):
                    return "no program"
        try:
            done = self._run(changed)
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
    with tempfile.TemporaryDirectory() as name, suppress(KeyboardInterrupt):
        bench = Workbench(Path(name))
        boards = Boards(bench.tree)
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
