"""Bound the stack of the firmware from its machine code: the Nano's, and the Mega's.

    python tools/firmware_stack.py

prints the deepest chain of calls, whether a test has met it or not, with what each function takes
of the stack, and what is left of the RAM below it and the largest interrupt.
"""

import re
import subprocess
import sys
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
ELF = ROOT / "build/firmware/nano/firmware.elf"

PUSHES = 18  # of libgcc's shared prologue (-mcall-prologues): r2 to r17, r28 and r29

# Calls through pointers: who calls, and whom.
POINTERS = {
    "Console::compose": {"pump"},
    "Console::stop": {"pump"},
    "Console::say_lines": {"report::header_line", "report::summary_line", "status_line"},
    "Session::take_config_line": {"tell_config_problem"},
    "put_lines": {"report::header_line", "report::summary_line"},
}
# Chains that the code has and no run takes. FatFs makes a directory grow when it makes an entry,
# which only logfile::create() asks for, not when it looks for one; and a file's chain when a place
# behind its end is looked for, which is nowhere that recovery looks.
NEVER = (
    ("follow_path", "create_chain"),
    ("Session::meet", "f_open", "create_chain"),
    ("Console::get", "f_open", "create_chain"),
    ("Console::stop", "f_open", "create_chain"),
    ("close", "f_lseek", "create_chain"),
)


class StackError(Exception):
    """Something in the machine code that this program has no rule for."""


@dataclass(frozen=True)
class Chip:
    """End of the RAM, and bytes of a return address."""

    ram_end: int
    return_address: int


ATMEGA328P, ATMEGA2560 = Chip(0x900, 2), Chip(0x2200, 3)


@dataclass
class Function:
    """The bytes that a function takes of the stack, and the addresses of those it calls."""

    name: str
    takes: int
    calls: set[int] = field(default_factory=set)
    by_pointer: bool = False


@dataclass(frozen=True)
class Instruction:
    """One line of the disassembly."""

    address: int
    code: str
    words: str


def read(elf: Path, chip: Chip) -> dict[int, Function]:
    """Disassemble: the functions by address."""
    command = ["avr-objdump", "-d", "-C", "--no-show-raw-insn", str(elf)]
    text = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    functions: dict[int, Function] = {}
    bodies: list[list[Instruction]] = []
    for line in text.splitlines():
        if start := re.match(r"([0-9a-f]{8}) <(.*)>:$", line):
            functions[int(start[1], 16)] = Function(plain(start[2]), chip.return_address)
            bodies.append([])
        elif found := re.match(r"\s+([0-9a-f]+):\t(\S+)\s*(.*)", line):
            bodies[-1].append(Instruction(int(found[1], 16), found[2], found[3]))
    starts = sorted(functions)
    for function, body in zip(functions.values(), bodies, strict=True):
        function.takes += sum(line.code == "push" for line in body) + frames(body)
        function.by_pointer = any(line.code in ("icall", "eicall") for line in body)
        for line in body:
            if line.code not in ("call", "rcall", "jmp", "rjmp"):
                continue
            target = jump_target(line)
            if "<__epilogue_restores__" in line.words:
                continue
            if "<__prologue_saves__" in line.words:
                function.takes += shared_prologue(line, body)
            elif line.code == "rcall" and target == line.address + 2:
                function.takes += chip.return_address  # a short way to make room
            elif target:  # 0: a function that is not there
                function.calls.add(starts[bisect_right(starts, target) - 1])
    return functions


def shared_prologue(jump: Instruction, body: list[Instruction]) -> int:
    """Bytes that libgcc's prologue takes: a push from where it is entered on, and the frame, which
    the caller has put into r26 and r27."""
    entered = re.search(r"<__prologue_saves__(?:\+0x([0-9a-f]+))?>", jump.words)
    before = body[: body.index(jump)]
    frame = {line.words.split(",")[0]: number(line) for line in before if line.code == "ldi"}
    if entered is None or not {"r26", "r27"} <= frame.keys():
        raise StackError(f"{jump.address:#x}: {jump.words}: which frame?")
    return PUSHES - int(entered[1] or "0", 16) // 2 + (frame["r27"] << 8 | frame["r26"])


def plain(name: str) -> str:
    """A function's name without parameters, clones, and the namespace that has no name."""
    return re.split(r"[(.]", name.replace("(anonymous namespace)::", ""), maxsplit=1)[0]


def jump_target(line: Instruction) -> int:
    """Where a call or jump leads to."""
    found = re.search(r"; (?:0x)?([0-9a-f]+)", line.words)
    if found is None:
        raise StackError(f"{line.address:#x}: {line.code} {line.words}: where to?")
    return int(found[1], 16)


def frames(body: list[Instruction]) -> int:
    """Bytes by which a function lowers the stack pointer, whose low byte is register 0x3d."""
    total = 0
    for at, line in enumerate(body):
        if line.code != "out" or not line.words.startswith("0x3d"):
            continue
        register = line.words.split(",")[1].split(";")[0].strip()
        for one, other in pairwise(body[max(0, at - 7) : at]):
            if one.words.startswith(register) and one.code == "sbiw":
                total += number(one)
            elif one.words.startswith(register) and (one.code, other.code) == ("subi", "sbci"):
                wide = number(other) << 8 | number(one)
                total += wide if wide < 0x8000 else 0  # or else it is raised
    return total


def number(line: Instruction) -> int:
    """The constant in an instruction."""
    return int(line.words.split(",")[1].split(";")[0], 16)


def deepest(functions: dict[int, Function], start: int) -> tuple[int, tuple[Function, ...]]:
    """Bytes and functions of the deepest chain of calls from a function on."""
    named: dict[str, set[int]] = {}
    for address, function in functions.items():
        named.setdefault(function.name, set()).add(address)

    def called(function: Function) -> set[int]:
        if not function.by_pointer:
            return function.calls
        names = POINTERS.get(function.name, set())
        if not names or not names <= named.keys():
            raise StackError(f"{function.name} calls through a pointer: say whom in POINTERS")
        return function.calls.union(*(named[name] for name in names))

    @cache
    def below(address: int, met: tuple[int, ...]) -> tuple[int, tuple[Function, ...]]:
        """`met`: how much of each chain of NEVER lies above."""
        function = functions[address]
        met = tuple(k + (chain[k] == function.name) for k, chain in zip(met, NEVER, strict=True))
        if any(k == len(chain) for k, chain in zip(met, NEVER, strict=True)):
            return 0, ()
        chains = [below(other, met) for other in called(function) - {address}]
        most, chain = max(chains, key=lambda one: one[0], default=(0, ()))
        return function.takes + most, (function, *chain)

    return below(start, (0,) * len(NEVER))


def static_end(elf: Path) -> int:
    """The first address behind the variables."""
    done = subprocess.run(["avr-nm", str(elf)], capture_output=True, text=True, check=True)
    (end,) = re.findall(r"^0080([0-9a-f]+) . _end$", done.stdout, re.MULTILINE)
    return int(end, 16)


def bound(elf: Path = ELF, chip: Chip = ATMEGA328P) -> tuple[int, tuple[Function, ...]]:
    """Bytes of RAM that are left where the stack is deepest, and the chain of calls there."""
    functions = read(elf, chip)
    address = {function.name: start for start, function in functions.items()}
    main, chain = deepest(functions, address["main"])
    interrupts = [start for name, start in address.items() if re.match(r"__vector_\d+$", name)]
    interrupt = max(deepest(functions, start)[0] for start in interrupts)
    return chip.ram_end - static_end(elf) - main - interrupt, chain


def main() -> int:
    """Print the deepest chain."""
    try:
        left, chain = bound()
    except (StackError, OSError, subprocess.CalledProcessError) as error:
        print(f"firmware_stack: {error}", file=sys.stderr)
        return 2
    for function in chain:
        print(f"{function.takes:5}  {function.name}")
    print(f"{left} B of RAM are left")
    return 0


if __name__ == "__main__":
    sys.exit(main())
