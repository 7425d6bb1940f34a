"""Mutants of the firmware: python -m benchmarks.firmware_mutants [--count N] [--seed N]

Small mistakes are planted, one at a time, in the parts that carry samples (ring, sdcard, logfile,
block, link): a comparison that is off by one, a sign, a condition turned round, a number one
larger, a statement left out. Each mutant is compiled into the native tests with the sanitizers
watching. One that fails them, or does not come to an end, is caught; the others are listed.
`--part ring` draws from one part alone, `--all` takes every mutation there is.
"""

from __future__ import annotations

import argparse
import random
import re
import shutil
import subprocess
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tools.firmware_build import ROOT, native_command
from tools.firmware_fatfs import fetch

PARTS = ("ring", "sdcard", "logfile", "block", "link")
TESTS = ROOT / "tests/firmware/native/test_parts"
PATIENCE = 10  # times what the tests take without a mutant, 10 s at least

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
    (r"(?<![\w.])(\d+)(?![\w.])", "+1"),
)
"""What is found and what takes its place; "+1": the number, one larger."""

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


def mutations(part: str) -> Iterator[Mutant]:
    """Every mutation of a part."""
    for file in sorted((ROOT / "firmware/lib" / part).glob("*.cpp")):
        for number, line in enumerate(file.read_text(encoding="utf-8").split("\n"), start=1):
            code = line.partition("//")[0]
            if not code.strip() or code.lstrip().startswith(("#", "/*", "*", "static_assert")):
                continue
            for pattern, new in RULES:
                for found in re.finditer(pattern, code):
                    put = str(int(found[0]) + 1) if new == "+1" else new
                    changed = code[: found.start()] + put + code[found.end() :]
                    yield Mutant(file, number, changed.rstrip())
            if STATEMENT.match(code.rstrip()):
                yield Mutant(file, number, "")


def drawn(parts: tuple[str, ...], count: int, seed: int) -> list[Mutant]:
    """So many, evenly from the parts."""
    rng = random.Random(seed)
    pools = []
    for part in parts:
        pool = list(mutations(part))
        rng.shuffle(pool)
        pools.append(pool)
    found: list[Mutant] = []
    while len(found) < count and any(pools):
        found += [pool.pop() for pool in pools if pool]
    return found[:count]


class Workbench:
    """The native tests, compiled once; a mutant replaces one object."""

    def __init__(self, folder: Path) -> None:
        command = native_command(TESTS, folder / "unused")
        command = command[: command.index("-o")]
        self.sources = [Path(a) for a in command if a.endswith((".cpp", ".c"))]
        self.flags = [a for a in command if not a.endswith((".cpp", ".c"))]
        self.folder = folder
        self.longest_s = 600.0
        self.objects = {}
        for i, source in enumerate(self.sources):
            whole = (ROOT / source).resolve()
            self.objects[whole] = folder / f"{i}.o"
            self._compile(whole, self.objects[whole], check=True)

    def _compile(self, source: Path, target: Path, check: bool = False) -> bool:
        command = [*self.flags, "-c", str(source), "-o", str(target)]
        return subprocess.run(command, check=check, cwd=ROOT, capture_output=True).returncode == 0

    def check_unchanged(self) -> None:
        """The tests pass without a mutant; how long they take says how long one may take."""
        begun_s = time.monotonic()
        if self.outcome(None) != "survived":
            raise SystemExit("the tests fail without any mutant")
        self.longest_s = max(PATIENCE * (time.monotonic() - begun_s), 10.0)

    def outcome(self, mutant: Mutant | None) -> str:
        """ "caught", "survived", or "no program" where it does not compile."""
        objects = dict(self.objects)
        if mutant is not None:
            source = self.folder / mutant.file.name
            source.write_text(mutant.source, encoding="utf-8")
            objects[mutant.file] = self.folder / "mutant.o"
            if not self._compile(source, objects[mutant.file]):
                return "no program"
        program, image = self.folder / "parts", self.folder / "card.img"
        link = [self.flags[0], "-fsanitize=address,undefined", *map(str, objects.values())]
        subprocess.run([*link, "-o", str(program)], check=True, capture_output=True)
        image.unlink(missing_ok=True)
        vfat = shutil.which("mkfs.vfat", path="/usr/sbin:/sbin:/usr/bin") or "mkfs.vfat"
        empty = [vfat, "--invariant", "-F", "16", "-s", "1", "-C", str(image), "8192"]
        subprocess.run(empty, check=True, capture_output=True)
        try:
            done = subprocess.run([program, image], capture_output=True, timeout=self.longest_s)
        except subprocess.TimeoutExpired:
            return "caught"
        return "survived" if done.returncode == 0 else "caught"


def main() -> None:
    """Draw, plant, count."""
    parser = argparse.ArgumentParser(description="Mutants of the firmware that its tests catch")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--part", choices=PARTS, action="append")
    parser.add_argument("--all", action="store_true")
    arguments = parser.parse_args()
    parts = tuple(arguments.part or PARTS)
    chosen = drawn(parts, 10**6 if arguments.all else arguments.count, arguments.seed)
    if "ring" in parts:
        ring = ROOT / "firmware/lib/ring/ring.cpp"
        chosen = [Remembered(ring, 0, "ring/ring.cpp: the ring's earlier rule"), *chosen]
    fetch(ROOT)
    counts: Counter[tuple[str, str]] = Counter()
    with tempfile.TemporaryDirectory() as folder:
        bench = Workbench(Path(folder))
        bench.check_unchanged()
        for mutant in chosen:
            outcome = bench.outcome(mutant)
            counts[mutant.file.parent.name, outcome] += 1
            if outcome == "survived":
                print(f"survived: {mutant}", flush=True)
    for part in parts:
        caught, survived = counts[part, "caught"], counts[part, "survived"]
        print(f"{part:8} {caught} of {caught + survived} caught")
    caught = sum(n for (_, outcome), n in counts.items() if outcome == "caught")
    total = caught + sum(n for (_, outcome), n in counts.items() if outcome == "survived")
    dropped = sum(counts.values()) - total
    print(f"{caught} of {total} caught, {caught / total:.0%}; {dropped} did not compile")


if __name__ == "__main__":
    main()
