"""The simulated board as one object."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from wheelhop.files.closing import Closing
from wheelhop.hil_sim.card import CardImage
from wheelhop.hil_sim.faults import BLOCK_SIZE, Faults
from wheelhop.hil_sim.process import Process
from wheelhop.hil_sim.program import read_elf
from wheelhop.hil_sim.signals import SELF_TEST, Signals, constant
from wheelhop.hil_sim.trace import CPU_HZ, Trace

MIDDLE = 512.0  # code of a sensor at rest

State = Literal["off", "running", "halted", "crashed"]


@dataclass(frozen=True)
class Write:
    """One block as the card stored it: board time in seconds, block number, its 512 bytes."""

    time_s: float
    block: int
    data: bytes


@dataclass(frozen=True)
class Counters:
    """What the board has counted.

    Since power-on: `idle_cycles` asleep, `resets` after the first start. Since the card was
    inserted: `card_writes` and `card_reads` of blocks. Since the board was made: `conversions`;
    `missed` triggers of the converter; `reference_conflicts`, conversions with an internal
    reference while AREF is driven from outside; `spi_bytes`; `spi_collisions`, bytes written into
    a transfer; `serial_overruns`, bytes the program read too late; `card_violations`, offences
    against the card's protocol.
    """

    idle_cycles: int
    resets: int
    conversions: int
    missed: int
    reference_conflicts: int
    spi_bytes: int
    spi_collisions: int
    serial_overruns: int
    card_writes: int
    card_reads: int
    card_violations: int


class Serial:
    """The host's end of the serial line, in virtual time."""

    def __init__(self, process: Process):
        self._process = process

    def write(self, data: bytes) -> None:
        """Send; the bytes arrive one after another at the MCU's baud rate while the board runs."""
        self._process.ask("send", bytes(data))

    def read(self) -> bytes:
        """Everything the MCU has sent since the last call."""
        return self.read_timed()[1]

    def read_timed(self) -> tuple[NDArray[np.float64], bytes]:
        """`read`, with the board time in seconds at which each byte went to the UART."""
        raw = np.frombuffer(self._process.ask("take-serial")[1], dtype="<u8")
        return (raw >> 8) / CPU_HZ, (raw & 0xFF).astype(np.uint8).tobytes()


class Board(Closing):
    """A powered board with a firmware, to be used in a `with` statement.

    `card` is what lies in the socket: an image, its path (an SDHC card), or nothing. `signals` are
    the sensors, at mid-scale if not given. `trace` and `journal` record events and card writes.
    `eeprom` is the MCU's, erased if not given; it survives resets and power cuts. `boot_loader` is
    the boot section, the last bytes of the flash, where every reset starts; none if not given.
    `reference_volts` are at AREF. Assigning to it, to `signals` or `faults` changes them while the
    board runs.

    Raises `SimulationError` if the program cannot be built or the ELF not be used.
    """

    def __init__(
        self,
        elf: Path | str,
        card: CardImage | Path | str | None = None,
        signals: Signals | None = None,
        faults: Faults | None = None,
        *,
        trace: bool = False,
        journal: bool = False,
        reference_volts: float = 3.3,
        eeprom: bytes | None = None,
        boot_loader: bytes | None = None,
        powered: bool = True,
    ):
        self._program = read_elf(Path(elf))
        self._process = Process(self._program.mcu, Path(elf))
        self._cycle = 0
        self.state: State = "off"
        self._wheel_hz = self._temperature_code = 0.0
        self.serial = Serial(self._process)
        try:
            self._process.ask(f"record {trace:d} {journal:d}")
            self.reference_volts = reference_volts
            self.signals = signals or constant(MIDDLE)
            self.self_test = constant(SELF_TEST)
            self.faults = faults or Faults()
            self.insert(card)
            if eeprom is not None:
                self._process.ask("set-eeprom", eeprom)
            if boot_loader is not None:
                self._process.ask("boot-loader", boot_loader)
            if powered:
                self.power_on()
        except BaseException:
            self.close()
            raise

    @property
    def time(self) -> float:
        """Board time in seconds; it goes on over resets and while the power is off."""
        return self._cycle / CPU_HZ

    @property
    def reference_volts(self) -> float:
        """Volts at AREF. The signals are codes, a ratio to it: they stay."""
        return self._reference_volts

    @reference_volts.setter
    def reference_volts(self, volts: float) -> None:
        self._process.ask(f"reference {round(volts * 1000)}")
        self._reference_volts = volts

    @property
    def signals(self) -> Signals:
        """What the sensors put out."""
        return self._signals

    @signals.setter
    def signals(self, signals: Signals) -> None:
        table = np.ascontiguousarray(signals.codes, dtype="<f8").tobytes()
        self._process.ask(f"signals {signals.rate_hz!r} {signals.repeat:d}", table)
        self._signals = signals

    @property
    def self_test(self) -> Signals:
        """Codes by which the sensors' self-test shifts what they put out, in one row."""
        return self._self_test

    @self_test.setter
    def self_test(self, codes: Signals) -> None:
        self._process.ask("self-test", np.ascontiguousarray(codes.codes[0], dtype="<f8").tobytes())
        self._self_test = codes

    @property
    def wheel_hz(self) -> float:
        """Pulses a second of the wheel's sensor, at the Mega's D4; 0: the wheel stands."""
        return self._wheel_hz

    @wheel_hz.setter
    def wheel_hz(self, pulses_per_s: float) -> None:
        self._process.ask(f"wheel {round(CPU_HZ / pulses_per_s) if pulses_per_s else 0}")
        self._wheel_hz = pulses_per_s

    @property
    def temperature_code(self) -> float:
        """Code of what the temperature's sensor puts out, at the Mega's A8."""
        return self._temperature_code

    @temperature_code.setter
    def temperature_code(self, code: float) -> None:
        self._process.ask(f"temperature {code!r}")
        self._temperature_code = code

    @property
    def faults(self) -> Faults:
        """What goes wrong with the card."""
        return self._faults

    @faults.setter
    def faults(self, faults: Faults) -> None:
        for request in faults.requests(CPU_HZ):
            self._process.ask(request)
        self._faults = faults

    def insert(self, card: CardImage | Path | str | None) -> None:
        """Put a card into the socket in place of what is there, or nothing."""
        if card is None:
            self._process.ask("card none")
            return
        image = card if isinstance(card, CardImage) else CardImage(Path(card))
        self._process.ask(f"card {image.kind} {image.serial}", str(image.path).encode())

    def run(self, seconds: float) -> State:
        """Let `seconds` of board time pass, to the next instruction; return the state."""
        return self._run_to(self._cycle + round(seconds * CPU_HZ))

    def run_until(self, condition: Callable[[], bool], timeout: float, step: float = 1e-3) -> bool:
        """Run in steps until the condition holds. False if it does not within `timeout` seconds."""
        end = self._cycle + round(timeout * CPU_HZ)
        while not condition():
            if self._cycle >= end:
                return False
            self._run_to(min(end, self._cycle + round(step * CPU_HZ)))
        return True

    def _run_to(self, cycle: int) -> State:
        values, _ = self._process.ask(f"run {cycle}")
        self._cycle = int(values[0])
        states: dict[str, State] = {s: s for s in ("off", "running", "halted", "crashed")}
        self.state = states[values[1]]
        return self.state

    def power_on(self) -> None:
        """Start the MCU with noise in its RAM, and the card from its idle state."""
        self._process.ask("power on")
        self.state = "running"

    def cut_power(self) -> None:
        """Take the power from MCU and card at this moment."""
        self._process.ask("power off")
        self.state = "off"

    def reset(self, cause: Literal["external", "brown-out"] = "external") -> None:
        """Reset the MCU, not the card."""
        self._process.ask(f"reset {cause}")

    def hold_cpu(self, cycles: int) -> None:
        """Let the MCU run no code for so long, interrupts included; its peripherals go on."""
        self._process.ask(f"hold {cycles}")

    def press_button(self, seconds: float = 0.1) -> None:
        """Hold the start/stop button down for `seconds` of board time."""
        self._process.ask("press 1")
        self.run(seconds)
        self._process.ask("press 0")

    def press_mark(self, seconds: float = 0.1) -> None:
        """Hold the button for marks, at the Mega's D3, down for `seconds` of board time."""
        self._process.ask("press-mark 1")
        self.run(seconds)
        self._process.ask("press-mark 0")

    def trace(self) -> Trace:
        """The events since the last call, if the board was made with `trace`."""
        return Trace(self._process.ask("take-trace")[1])

    def journal(self) -> list[Write]:
        """The card writes since the last call, if the board was made with `journal`."""
        kind = np.dtype([("cycle", "<u8"), ("block", "<u8"), ("data", f"V{BLOCK_SIZE}")])
        entries = np.frombuffer(self._process.ask("take-journal")[1], dtype=kind)
        return [
            Write(int(e["cycle"]) / CPU_HZ, int(e["block"]), e["data"].tobytes()) for e in entries
        ]

    def stack_left(self) -> int:
        """Bytes of RAM that nothing has touched since power-on, above the static data."""
        return int(self._process.ask(f"untouched {self._program.static_end}")[0][0])

    def eeprom(self) -> bytes:
        """The content of the MCU's EEPROM."""
        return self._process.ask("take-eeprom")[1]

    def memory(self, symbol: str) -> bytes:
        """What a variable holds. Raises `SimulationError` if the firmware has none of this name."""
        address, size = self._program.variable(symbol)
        return self._process.ask(f"memory {address} {size}")[1]

    def set_memory(self, symbol: str, data: bytes) -> None:
        """Overwrite (the beginning of) a variable, to bring a counter to the verge of its wrap."""
        address, size = self._program.variable(symbol)
        self._process.ask(f"set-memory {address}", data[:size])

    def counters(self) -> Counters:
        """What the board has counted."""
        values = dict(item.split("=") for item in self._process.ask("counters")[0])
        return Counters(**{f.name: int(values[f.name]) for f in fields(Counters)})

    def last_violation(self) -> str:
        """The host's last offence against the card's protocol, in words."""
        return self._process.ask("last-violation")[1].decode()

    def close(self) -> None:
        """End the simulation; the card's image stays as it is."""
        self._process.close()
