"""The program `board`: building it on demand, and talking to it."""

import shutil
import subprocess
import tempfile
from pathlib import Path

from wheelhop.files.closing import Closing
from wheelhop.hil_sim.program import SimulationError

SOURCES = Path(__file__).parents[2] / "board"
PROGRAM = Path(__file__).parents[3] / "build" / "hil_sim" / "board"
COMPILE = ("cc", "-std=gnu11", "-O2", "-Wall", "-Wextra")
LIBRARIES = ("-lsimavr", "-lelf", "-lm")
MISSING = (
    "the simulated board needs a C compiler, simavr and libelf; "
    "on Debian and Ubuntu: sudo apt-get install gcc libsimavr-dev libelf-dev"
)
ELSEWHERE = (
    "the simulated board is in wheelhop's source tree, not in its packages: git clone the"
    " repository, pip install -e . there, and make firmware"
)


def build() -> Path:
    """Compile the program if it is not there or older than its sources; return its path."""
    sources = sorted(SOURCES.glob("*.c"))
    if not sources:
        raise SimulationError(ELSEWHERE)
    newest = max(path.stat().st_mtime for path in SOURCES.iterdir())
    if PROGRAM.exists() and PROGRAM.stat().st_mtime >= newest:
        return PROGRAM
    if shutil.which(COMPILE[0]) is None:
        raise SimulationError(MISSING)
    PROGRAM.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=PROGRAM.parent) as folder:
        fresh = Path(folder) / "board"
        done = subprocess.run(
            [*COMPILE, "-o", fresh, *sources, *LIBRARIES], capture_output=True, text=True
        )
        if done.returncode != 0:
            missing = "simavr" in done.stderr or "-lelf" in done.stderr
            raise SimulationError(
                MISSING if missing else f"{SOURCES}: does not compile: {done.stderr}"
            )
        fresh.replace(PROGRAM)
    return PROGRAM


class Process(Closing):
    """One running `board`. A request is a line, with or without bytes; so is the answer."""

    def __init__(self, mcu: str, elf: Path):
        self._log = tempfile.TemporaryFile()  # noqa: SIM115 (as long as the process)
        self._process = subprocess.Popen(
            [build(), mcu, elf],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._log,
        )
        self._answer()

    def ask(self, request: str, payload: bytes | None = None) -> tuple[list[str], bytes]:
        """Values and bytes of the answer. Raises `SimulationError` with the program's words."""
        pipe = self._process.stdin
        assert pipe is not None
        try:
            pipe.write(f"{request}{'' if payload is None else f' +{len(payload)}'}\n".encode())
            pipe.write(payload or b"")
            pipe.flush()
        except (BrokenPipeError, ValueError):
            raise SimulationError(f"the simulated board has ended: {self._last_words()}") from None
        return self._answer()

    def _answer(self) -> tuple[list[str], bytes]:
        pipe = self._process.stdout
        assert pipe is not None
        status, *values = pipe.readline().decode().split() or ["gone"]
        if status == "error":
            raise SimulationError(" ".join(values))
        if status != "ok":
            raise SimulationError(f"the simulated board has ended: {self._last_words()}")
        if values and values[-1].startswith("+"):
            return values[:-1], pipe.read(int(values[-1]))
        return values, b""

    def _last_words(self) -> str:
        self._log.seek(0)
        lines = self._log.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else f"status {self._process.poll()}"

    def close(self) -> None:
        """End the program."""
        self._process.kill()
        self._process.communicate()
        self._log.close()
