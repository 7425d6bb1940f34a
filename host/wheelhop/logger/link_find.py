"""From a port's name, or from none, to a logger that answers."""

import time

from wheelhop.logger.emulated import emulated_ports
from wheelhop.logger.error import LoggerError
from wheelhop.logger.link import Link
from wheelhop.logger.port import BAUD, SerialPort, find_ports

FIRST_REPLY_S = 1.0
WAKE_TRIES = 8
"""Opening its port restarts many a board: boot loader and card take a few seconds."""
BACK_TRIES = 2


def connect(url: str | None = None, *, baud: int = BAUD, tries: int = WAKE_TRIES) -> Link:
    """Open a port, or the one port over USB (or of `wheelhop emulate`) that a logger answers on,
    and wait for the logger.

    Raises LoggerError where there is no port, it cannot be opened, or no logger answers.
    """
    if url is not None:
        return _open(url, baud, tries)
    ports = [*find_ports(), *emulated_ports()]
    if not ports:
        raise LoggerError(
            "no serial port over USB found: plug the logger in, or give --port PORT; to try without"
            " one, wheelhop emulate"
        )
    if len(ports) == 1:
        return _open(ports[0], baud, tries)
    links: list[Link] = []
    reasons: list[str] = []
    for port in ports:
        try:
            links.append(_open(port, baud, tries))
        except LoggerError as error:
            reasons.append(str(error))
    if len(links) == 1:
        return links[0]
    for link in links:
        link.close()
    if links:
        names = ", ".join(link.port.name for link in links)
        raise LoggerError(f"several loggers: {names}; say which one with --port")
    raise LoggerError(f"no logger answers: {'; '.join(reasons)}")


def reconnect(url: str, *, baud: int = BAUD, wait_s: float) -> Link | None:
    """Try for so long to open a port that was lost; None if it is not back."""
    deadline = time.monotonic() + wait_s
    while True:
        try:
            return _open(url, baud, BACK_TRIES)
        except LoggerError:
            if time.monotonic() > deadline:
                return None
            time.sleep(0.2)


def _open(url: str, baud: int, tries: int) -> Link:
    link = Link(SerialPort(url, baud))
    try:
        link.command("info", timeout_s=FIRST_REPLY_S, tries=tries)
    except BaseException:
        link.close()
        raise
    return link
