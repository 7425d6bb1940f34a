"""A boot loader on a pseudo-terminal: what Arduino boards answer to avrdude, as STK500 version 1.

The commands are those of Atmel's application note AVR061.
"""

import os
import pty
import termios
import threading
import tty

OK, IN_SYNC, END = b"\x10", b"\x14", 0x20
ATMEGA328P, ATMEGA2560 = b"\x1e\x95\x0f", b"\x1e\x98\x01"
ARGUMENTS = {0x30: 0, 0x41: 1, 0x42: 20, 0x45: 5, 0x50: 0, 0x51: 0, 0x55: 2, 0x56: 4, 0x75: 0}
SPEEDS = {termios.B57600: 57600, termios.B115200: 115200}


class Bootloader:
    """Answers on `port` until closed; `flash` is what has been written."""

    def __init__(self, signature=ATMEGA328P, baud=115200, corrupt=False):
        self.signature, self.baud, self.corrupt = signature, baud, corrupt
        self.flash = bytearray(b"\xff" * 32768)
        self.heard = bytearray()
        self.address = 0
        self.master, self.slave = pty.openpty()
        tty.setraw(self.slave)
        self.port = os.ttyname(self.slave)
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        os.close(self.slave)
        self.thread.join(5)
        os.close(self.master)

    def serve(self):
        """Until the other end hangs up."""
        try:
            while True:
                command = self.take(1)[0]
                if command == 0x64:
                    self.write_page()
                elif command == 0x74:
                    self.read_page()
                elif command in ARGUMENTS:
                    self.answer(command, self.take(ARGUMENTS[command]))
        except OSError:
            return

    def take(self, count):
        """Bytes, as far as they came at the right speed."""
        while len(self.heard) < count:
            data = os.read(self.master, 1024)
            if SPEEDS.get(termios.tcgetattr(self.slave)[5]) == self.baud:
                self.heard += data
        taken = bytes(self.heard[:count])
        del self.heard[:count]
        return taken

    def reply(self, data=b""):
        if self.take(1)[0] == END:
            os.write(self.master, IN_SYNC + data + OK)

    def answer(self, command, arguments):
        if command == 0x55:
            self.address = 2 * int.from_bytes(arguments, "little")
        self.reply({0x41: b"\x04", 0x56: b"\x00", 0x75: self.signature}.get(command, b""))

    def write_page(self):
        size = int.from_bytes(self.take(3)[:2], "big")
        page = self.take(size)
        self.flash[self.address : self.address + size] = page
        if self.corrupt:
            self.flash[self.address] ^= 1
        self.reply()

    def read_page(self):
        size = int.from_bytes(self.take(3)[:2], "big")
        self.reply(bytes(self.flash[self.address : self.address + size]))
