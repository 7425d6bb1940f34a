"""Write the firmware into the logger, with avrdude, or with PlatformIO where only that is there.

Both talk to the boot loader over the serial port and read back what they have written.
"""

import importlib.util
import re
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

from wheelhop.files import TABLE, read_bytes
from wheelhop.logger.error import LoggerError
from wheelhop.logger.port import find_ports

SOURCE_TREE = Path(__file__).resolve().parents[3]
PACKAGED = Path(__file__).with_name("firmware")  # in a wheel
OLD_BOOTLOADER_BAUD = 57600  # ATmegaBOOT, on Nanos of before 2018


@dataclass(frozen=True)
class Board:
    """A board as its boot loader is spoken to; `part` and `programmer` are avrdude's names."""

    title: str
    part: str
    programmer: str
    baud: int


BOARDS = {
    "nano": Board("Arduino Nano", "m328p", "arduino", 115200),
    "mega": Board("Arduino Mega 2560", "m2560", "wiring", 115200),
}

# What avrdude says in a line, as a pattern, and what it means to somebody with a logger before
# them; the first that fits.
SILENT = "{title} does not answer: is it the right port?{hint}"
MEANINGS = (
    ("expected signature", "another controller answers than {title}'s: is --board right?"),
    ("verification", "what was written reads back differently: try again, with another cable"),
    ("permission denied", "permission denied: sudo usermod -a -G dialout $USER, and log in again"),
    ("busy", "another program uses the port: close it"),
    ("(port|device).*no such file", "there is no such port: is the logger plugged in?"),
    ("not in sync", SILENT),
    ("not responding", SILENT),
    ("timeout", SILENT),
)
OLD_BOOTLOADER_HINT = " A Nano with the old boot loader wants --old-bootloader"


@dataclass(frozen=True)
class Upload:
    """What will be done: the command, the folder it runs in, and how to tell a user."""

    board: Board
    port: str
    firmware: str
    command: tuple[str, ...]
    folder: Path
    old_bootloader: bool

    @property
    def tool(self) -> str:
        """The program that does it."""
        return Path(self.command[0]).name


def plan_upload(
    env: str, port: str | None = None, hex_file: Path | None = None, old_bootloader: bool = False
) -> Upload:
    """Find tool, port and firmware for a board, a key of `BOARDS`.

    Without `hex_file` it is the one that `make firmware` has built in the source tree, or else that
    of the package. Raises LoggerError where a tool, the port or the firmware is missing or unfit.
    """
    board = BOARDS[env]
    if old_bootloader and env != "nano":
        raise LoggerError(f"--old-bootloader: {board.title} has none; it is for the Nano")
    avrdude, pio = find_avrdude(), shutil.which("pio")
    if avrdude:
        firmware = hex_file or _built(env)
        check_hex(firmware)
        port = port or find_port()
        baud = OLD_BOOTLOADER_BAUD if old_bootloader else board.baud
        # -D: these boot loaders erase page by page. Verifying is avrdude's default.
        command = [avrdude, "-q", "-p", board.part, "-c", board.programmer, "-b", str(baud)]
        command += ["-P", port, "-D", "-U", f"flash:w:{firmware}:i"]
        return Upload(board, port, str(firmware), tuple(command), Path.cwd(), old_bootloader)
    if not pio:
        raise LoggerError(
            "neither avrdude nor PlatformIO is installed: sudo apt-get install avrdude (macOS: brew"
            " install avrdude; Windows: pip install avrdude-windows), or pip install platformio"
        )
    if hex_file or old_bootloader:
        option = "--hex" if hex_file else "--old-bootloader"
        raise LoggerError(f"{option} needs avrdude, and only PlatformIO is installed")
    if not (SOURCE_TREE / "platformio.ini").exists():
        raise LoggerError("PlatformIO needs wheelhop's source tree; with avrdude a .hex will do")
    port = port or find_port()
    command = [pio, "run", "--silent", "-e", env, "-t", "upload", "--upload-port", port]
    return Upload(board, port, f"as built from {SOURCE_TREE}", tuple(command), SOURCE_TREE, False)


def upload(plan: Upload) -> None:
    """Write and verify. Raises LoggerError with what went wrong, in a line."""
    done = subprocess.run(
        plan.command,
        cwd=plan.folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        encoding="utf-8",
        errors="replace",
    )
    if done.returncode:
        raise LoggerError(f"{plan.port}: {_meaning(done.stdout, plan)}")


def _meaning(output: str, plan: Upload) -> str:
    hint = OLD_BOOTLOADER_HINT if plan.board is BOARDS["nano"] and not plan.old_bootloader else ""
    for pattern, meaning in MEANINGS:
        if re.search(pattern, output.lower()):
            return meaning.format(title=plan.board.title, hint=hint)
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    reasons = [line for line in lines if "error" in line.lower()] or lines
    return f"{plan.tool} failed: {reasons[-1] if reasons else 'it does not say why'}"


def find_avrdude() -> str | None:
    """Return avrdude's path: the system's, or that of PyPI's avrdude-windows; None without one."""
    if system := shutil.which("avrdude"):
        return system
    package = importlib.util.find_spec("avrdude_windows")
    if package is None or package.origin is None:
        return None
    path = Path(package.origin).parent / "avrdude_binaries" / "x64" / "avrdude.exe"
    return str(path) if path.exists() else None


def find_port() -> str:
    """Return the only serial port over USB. Raises LoggerError if there is none, or several."""
    ports = find_ports()
    if not ports:
        raise LoggerError(
            "no serial port over USB found: plug the logger in, or give --port PORT (Linux:"
            " /dev/ttyUSB0 or /dev/ttyACM0; macOS: /dev/cu.usbserial-…; Windows: COM3)"
        )
    if len(ports) > 1:
        raise LoggerError(f"several serial ports: {', '.join(ports)}; say which one with --port")
    return ports[0]


def _built(env: str) -> Path:
    path = SOURCE_TREE / "build" / "firmware" / env / "firmware.hex"
    packaged = PACKAGED / f"wheelhop-logger-{env}.hex"
    for file in (path, packaged):
        if file.exists():
            return file
    raise LoggerError(
        f"no firmware has been built, and this package holds none: make firmware, or --hex"
        f" {packaged.name} from a release"
    )


def check_hex(file: Path) -> None:
    """Raise LoggerError unless a file is Intel HEX, whole and undamaged (a download may be torn).

    A record is `:` and bytes in hexadecimal: count, address (2), type, data, and a byte that makes
    the sum of all 0 modulo 256; type 1 ends the file.
    """
    try:
        lines = read_bytes(file, LoggerError, TABLE).decode("ascii").split()
    except UnicodeDecodeError:
        raise LoggerError(f"{file}: not a .hex file, but something binary") from None
    except OSError as error:
        raise LoggerError(f"{file}: {error.strerror}; see make firmware") from None
    for number, line in enumerate(lines, start=1):
        try:
            record = bytes.fromhex(line.removeprefix(":"))
        except ValueError:
            record = b""
        if line[0] != ":" or len(record) < 5 or len(record) != record[0] + 5 or sum(record) & 0xFF:
            raise LoggerError(
                f"{file}: line {number} is no record of Intel HEX: get the file again"
            )
    if not lines or lines[-1].upper() != ":00000001FF":
        raise LoggerError(f"{file}: the end is missing: get the file again")
