"""Where a program reaches the double: a pseudo-terminal, or a TCP port."""

import os
import select
import socket
import tempfile
from pathlib import Path
from typing import Protocol

CHUNK = 4096
BACKLOG = 1 << 20  # bytes that wait for a slow reader; then they are lost, as with a real port


class Door(Protocol):
    """One end of a line that can be torn and joined again, under the same `url`."""

    url: str

    def join(self) -> None:
        """Let programs in."""

    def tear(self) -> None:
        """Throw everybody out."""

    def read(self, timeout_s: float) -> bytes:
        """What has come, after a wait of at most so long."""

    def write(self, data: bytes) -> None:
        """Send; what nobody reads is lost in the end."""

    def close(self) -> None:
        """For good."""


class PtyDoor:
    """A pseudo-terminal; `url` is a link to it that stays the same when the line was torn."""

    def __init__(self, link: Path | None = None) -> None:
        self._folder = None if link else Path(tempfile.mkdtemp(prefix="wheelhop-"))
        self._link = link or Path(str(self._folder)) / "port"
        self.url = str(self._link)
        self._ends: tuple[int, int] | None = None
        self._waiting = b""
        self.join()

    def join(self) -> None:
        """Make a terminal."""
        import tty

        near, far = os.openpty()
        tty.setraw(far)
        os.set_blocking(near, False)
        self._ends, self._waiting = (near, far), b""
        self._link.unlink(missing_ok=True)
        self._link.symlink_to(os.ttyname(far))

    def tear(self) -> None:
        """Hang up."""
        self._link.unlink(missing_ok=True)
        for end in self._ends or ():
            os.close(end)
        self._ends = None

    def read(self, timeout_s: float) -> bytes:
        """What has been written to the terminal."""
        assert self._ends is not None
        if not select.select([self._ends[0]], [], [], timeout_s)[0]:
            return b""
        return os.read(self._ends[0], CHUNK)

    def write(self, data: bytes) -> None:
        """To the terminal."""
        assert self._ends is not None
        self._waiting = (self._waiting + data)[-BACKLOG:]
        try:
            while self._waiting:
                self._waiting = self._waiting[os.write(self._ends[0], self._waiting) :]
        except BlockingIOError:
            return

    def close(self) -> None:
        """Remove the link, too."""
        if self._ends:
            self.tear()
        if self._folder:
            self._folder.rmdir()


class TcpDoor:
    """A TCP port of this machine; one program at a time, the newest."""

    def __init__(self, port: int = 0) -> None:
        self._port = port
        self._peer: socket.socket | None = None
        self._listener: socket.socket | None = None
        self._waiting = b""
        self.join()
        self.url = f"socket://127.0.0.1:{self._port}"

    def join(self) -> None:
        """Listen."""
        listener = socket.create_server(("127.0.0.1", self._port))
        listener.setblocking(False)
        self._port = listener.getsockname()[1]
        self._listener = listener

    def tear(self) -> None:
        """Hang up, and listen no longer."""
        for end in (self._peer, self._listener):
            if end:
                end.close()
        self._peer = self._listener = None

    def read(self, timeout_s: float) -> bytes:
        """What has come from the program that is connected."""
        assert self._listener is not None
        ends = [self._listener, *([self._peer] if self._peer else [])]
        ready = select.select(ends, [], [], timeout_s)[0]
        if self._listener in ready:
            if self._peer:
                self._peer.close()
            self._peer, self._waiting = self._listener.accept()[0], b""
            self._peer.setblocking(False)
            self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return b""
        if self._peer not in ready or self._peer is None:
            return b""
        try:
            data = self._peer.recv(CHUNK)
        except OSError:
            data = b""
        if not data:
            self._peer.close()
            self._peer = None
        return data

    def write(self, data: bytes) -> None:
        """To the program that is connected; lost if there is none."""
        if self._peer is None:
            return
        self._waiting = (self._waiting + data)[-BACKLOG:]
        try:
            while self._waiting:
                self._waiting = self._waiting[self._peer.send(self._waiting) :]
        except BlockingIOError:
            return
        except OSError:
            self._peer.close()
            self._peer = None

    def close(self) -> None:
        """Stop listening."""
        self.tear()
