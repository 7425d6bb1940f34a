"""From bytes to a command, as the firmware's `line` and `link` do it."""

import re

from wheelhop.hil_sim.double.settings import Refusal
from wheelhop.logger.block import crc
from wheelhop.logger.frames import LONGEST_COMMAND

ENDS = b"\n\r"


class Line:
    """Collects bytes to lines; drops blanks before one, empty ones and comments."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def push(self, byte: int) -> bytes | None:
        """The line that this byte ends, if it does; kept no longer than it may be, and one."""
        if byte in ENDS:
            line = bytes(self._bytes)
            self._bytes.clear()
            # Behind bytes that are refused, blanks and a comment may still come.
            comment = re.match(rb"[^!-~]*#", line)
            return None if not line or comment else line
        if byte == ord("\t"):
            byte = ord(" ")
        if len(self._bytes) <= LONGEST_COMMAND and (self._bytes or byte != ord(" ")):
            self._bytes.append(byte)
        return None


def checked_command(line: bytes) -> str:
    """The command in a line, its check sum cut off. Raises Refusal."""
    if len(line) > LONGEST_COMMAND or not all(0x20 <= byte <= 0x7E for byte in line):
        raise Refusal("line too long or not plain text")
    text, star, told = line.rpartition(b"*")
    if not star:
        return line.decode("ascii")
    if not re.fullmatch(rb"[0-9A-Fa-f]{4}", told) or int(told, 16) != crc(text):
        raise Refusal("checksum")
    return text.decode("ascii")
