"""Host side of `probe.c`: commands by letter, and an SD card driver in Python on top of them."""

import struct

from wheelhop.hil_sim import Board

SLOW, FAST = 3, 4  # SPI clock / 128 and / 2


def crc7(data: bytes) -> int:
    """CRC7 by polynomial division, the way the specification defines it."""
    value = int.from_bytes(data) << 7
    for shift in range(value.bit_length() - 8, -1, -1):
        if value >> (shift + 7) & 1:
            value ^= 0x89 << shift
    return value << 1 | 1


class Probe:
    def __init__(self, elf, **options):
        self.board = Board(elf, **options)
        self.expect(b"", 1)

    def expect(self, request: bytes, count: int, timeout: float = 2.0) -> bytes:
        """Send, and run until so many bytes have come back."""
        answer = bytearray()
        self.board.serial.write(request)

        def complete() -> bool:
            answer.extend(self.board.serial.read())
            return len(answer) >= count

        assert self.board.run_until(complete, timeout, step=2e-4), (request, bytes(answer))
        assert len(answer) == count
        return bytes(answer)

    def convert(self, count: int) -> list[int]:
        """Codes of so many triggered conversions, in palindrome order."""
        answer = self.expect(b"c" + struct.pack("<H", count), 2 * count, timeout=20.0)
        return list(struct.unpack(f"<{count}H", answer))

    def exchange(self, data: bytes) -> bytes:
        return self.expect(b"x" + struct.pack("<H", len(data)) + data, len(data))

    def select(self, selected: bool) -> None:
        self.expect(b"s" + bytes([not selected]), 1)

    def clock(self, setting: int) -> None:
        self.expect(b"f" + bytes([setting]), 1)


class CardHost:
    """An SD card driver; every method says in assertions what it relies on."""

    def __init__(self, probe: Probe):
        self.probe = probe

    def command(self, number: int, argument: int = 0, count: int = 1) -> bytes:
        """R1 and what follows it, `count` bytes in all."""
        self.probe.select(True)
        frame = struct.pack(">BI", 0x40 | number, argument)
        answer = self.probe.exchange(frame + bytes([crc7(frame)]) + b"\xff" * (count + 8))[6:]
        start = next(i for i, byte in enumerate(answer) if byte != 0xFF)
        assert start <= 8  # N_CR
        return answer[start : start + count]

    def app_command(self, number: int, argument: int = 0) -> int:
        self.command(55)
        return self.command(number, argument)[0]

    def start_up(self) -> None:
        """From power-on to a card that is ready, as section 7.2.1 prescribes."""
        self.probe.clock(SLOW)
        self.probe.select(False)
        self.probe.exchange(b"\xff" * 10)
        assert self.command(0) == b"\x01"
        self.command(8, 0x1AA, 5)
        for _ in range(1000):
            if self.app_command(41, 0x40000000) == 0:
                break
        else:
            raise AssertionError("the card does not become ready")
        self.probe.clock(FAST)

    def await_token(self) -> None:
        for _ in range(2000):
            byte = self.probe.exchange(b"\xff")[0]
            if byte != 0xFF:
                assert byte == 0xFE
                return
        raise AssertionError("no data token")

    def data(self, count: int = 512) -> bytes:
        self.await_token()
        answer = self.probe.exchange(b"\xff" * (count + 2))
        return answer

    def begin_read(self, number: int, argument: int) -> None:
        self.probe.select(True)
        frame = struct.pack(">BI", 0x40 | number, argument)
        answer = self.probe.exchange(frame + bytes([crc7(frame)]) + b"\xff\xff")[6:]
        assert answer.lstrip(b"\xff")[:1] == b"\x00"

    def read(self, argument: int) -> bytes:
        self.begin_read(17, argument)
        return self.data()

    def send_block(self, data: bytes, token: int = 0xFE, crc: bytes = b"\0\0") -> int:
        """The data response."""
        return self.probe.exchange(b"\xff" + bytes([token]) + data + crc + b"\xff")[-1] & 0x1F

    def await_ready(self, timeout: float = 2.0) -> float:
        """Seconds for which the card was busy."""
        start = self.probe.board.time
        while self.probe.exchange(b"\xff") != b"\xff":
            assert self.probe.board.time - start < timeout
        return self.probe.board.time - start

    def write(self, argument: int, data: bytes) -> int:
        assert self.command(24, argument) == b"\x00"
        response = self.send_block(data)
        self.await_ready()
        return response
