"""A serial port, whatever it is: a device, `socket://HOST:PORT`, `rfc2217://HOST:PORT`."""

import errno
import os
import select
import sys
from typing import TYPE_CHECKING, Protocol

from wheelhop.files import require
from wheelhop.logger.error import LoggerError

if TYPE_CHECKING:
    from serial import SerialBase

BAUD = 500_000
POLL_S = 0.05
WRITE_S = 2.0
CHUNK = 4096


class PortLost(LoggerError):
    """The port was there and is gone: unplugged, or the other end has hung up."""


class Port(Protocol):
    """What a link needs of a port. `name` is for messages."""

    name: str

    def read(self) -> bytes:
        """Wait at most about `POLL_S` for bytes; none if none came. Raises PortLost."""

    def write(self, data: bytes) -> None:
        """Send all of it. Raises PortLost."""

    def close(self) -> None:
        """Give the port back; never raises."""


class SerialPort:
    """A port of pyserial's.

    Raises LoggerError where there is no such port, it is not ours to open, or somebody has it.
    """

    def __init__(self, url: str, baud: int = BAUD) -> None:
        require("serial", "a serial port", "logger", LoggerError)
        from serial import serial_for_url

        self.name = url
        try:
            port = serial_for_url(url, do_not_open=True)
            port.baudrate, port.timeout, port.write_timeout = baud, POLL_S, WRITE_S
            port.exclusive = True
            # On many boards these lines restart the controller; where the system lets us, they
            # stay quiet.
            port.dtr = port.rts = False
            port.open()
        except (OSError, ValueError) as error:  # pyserial's own is an OSError
            raise LoggerError(f"{url}: {_meaning(error)}") from None
        self._port: SerialBase = port
        self._selectable = os.name == "posix" and hasattr(port, "fileno")
        if self._selectable:
            port.timeout = 0

    def read(self) -> bytes:
        """Wait at most `POLL_S` for bytes. Raises PortLost."""
        try:
            if not self._selectable:
                first = self._port.read(1)
                return bytes(first + self._port.read(self._port.in_waiting) if first else first)
            if not select.select([self._port.fileno()], [], [], POLL_S)[0]:
                return b""
            return bytes(self._port.read(CHUNK))
        except (OSError, TypeError, ValueError) as error:  # of a port that went meanwhile
            raise self._lost(error) from None

    def write(self, data: bytes) -> None:
        """Send. Raises PortLost, also where nobody takes it."""
        try:
            self._port.write(data)
        except (OSError, TypeError, ValueError) as error:
            raise self._lost(error) from None

    def close(self) -> None:
        """Give the port back."""
        try:
            self._port.close()
        except OSError:  # it went first
            return

    def _lost(self, error: Exception) -> PortLost:
        return PortLost(f"{self.name}: the connection is lost ({_reason(error)})")


def find_ports() -> list[str]:
    """The serial ports over USB, by name; raises LoggerError where pyserial is not installed."""
    require("serial", "to look for the logger", "logger", LoggerError)
    from serial.tools.list_ports import comports

    return sorted(port.device for port in comports() if port.vid is not None)


def _reason(error: Exception) -> str:
    text = str(error).strip()
    return "unplugged?" if not text or "readiness" in text else text.splitlines()[-1]


def _meaning(error: Exception) -> str:
    """What pyserial says, for somebody with a logger before them."""
    text = str(error)
    number = error.errno if isinstance(error, OSError) else None
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text or "busy" in text:
        return "another program uses the port: close it"
    if number == errno.EACCES or "PermissionError" in text:
        if sys.platform == "win32":
            return "another program uses the port: close it"
        return "permission denied: sudo usermod -a -G dialout $USER, and log in again"
    if number == errno.ENOENT or "FileNotFoundError" in text:
        return "there is no such port: is the logger plugged in?"
    if "refused" in text:
        return "nobody listens there"
    if "://" in text or "invalid URL" in text:
        return "not a port: write COM3, /dev/ttyUSB0, socket://HOST:PORT or rfc2217://HOST:PORT"
    return text.splitlines()[-1] if text else type(error).__name__
