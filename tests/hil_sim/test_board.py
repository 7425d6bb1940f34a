"""The board: serial line, resets, power, button, sleep, stack, repeatability, speed."""

import os
import struct
import time

import pytest

from tests.firmware.promises.boot_loaders import LOADERS
from wheelhop.hil_sim import Board, CardImage, Event, SimulationError, sines
from wheelhop.hil_sim.program import read_elf
from wheelhop.hil_sim.terminal import Terminal

POWER_ON, EXTERNAL, BROWN_OUT, WATCHDOG = 1, 2, 4, 8  # MCUSR


def test_bytes_go_both_ways_at_20_us_each(probe):
    one = probe()
    count = 100
    one.board.serial.write(b"x" + struct.pack("<H", count) + bytes(range(count)))
    one.board.run(0.2)
    times, data = one.board.serial.read_timed()
    assert data == b"\xff" * count  # nothing in the card's socket
    steps = times[3:] - times[2:-1]
    assert steps == pytest.approx(20e-6, abs=1e-6)


def test_bytes_that_are_not_read_in_time_are_lost_and_counted(probe):
    one = probe()
    assert one.board.memory("overrun") == b"\0"
    one.board.serial.write(b"p" + struct.pack("<H", 2000))  # busy for about 0.6 ms
    one.board.serial.write(b"eA" * 20)
    one.board.run(0.01)
    assert one.board.counters().serial_overruns > 20
    assert one.board.memory("overrun") == b"\1"  # the receiver has told the program


def test_every_reset_leaves_its_cause(probe):
    one = probe()
    assert one.expect(b"m", 1) == bytes([POWER_ON])
    one.board.reset()
    one.expect(b"", 1)
    assert one.expect(b"m", 1) == bytes([EXTERNAL])
    one.board.reset("brown-out")
    one.expect(b"", 1)
    assert one.expect(b"m", 1) == bytes([BROWN_OUT])
    assert one.expect(b"w", 2) == b"w!"
    assert one.expect(b"m", 1) == bytes([WATCHDOG])
    assert one.board.counters().resets == 1


def test_a_boot_loader_runs_before_the_program_at_every_reset(probe):
    one = probe(boot_loader=LOADERS["Optiboot 4.4"])
    assert one.expect(b"m", 1) == b"\0"
    one.board.reset()
    one.expect(b"", 1)
    assert one.expect(b"m", 1) == b"\0"
    assert one.expect(b"w", 2) == b"w!"
    assert one.expect(b"m", 1) == b"\0"


def test_board_time_goes_on_over_resets_and_without_power(probe):
    one = probe()
    one.board.run(0.5)
    one.expect(b"w", 2)
    after_reset = one.board.time
    assert after_reset > 0.515
    one.board.cut_power()
    assert one.board.run(0.25) == "off"
    assert one.board.time == pytest.approx(after_reset + 0.25, abs=1e-6)
    one.board.power_on()
    times, data = one.board.serial.read_timed()
    assert data == b""
    one.board.run(0.01)
    times, data = one.board.serial.read_timed()
    assert data == b"!" and times[0] > after_reset + 0.25


def test_a_processor_that_sleeps_without_interrupts_is_halted(probe):
    one = probe()
    one.expect(b"h", 1)
    assert one.board.run(0.1) == "halted"
    one.board.power_on()
    one.expect(b"", 1)
    assert one.expect(b"eB", 1) == b"B"


def test_the_button_pulls_its_pin_down_while_it_is_held(probe):
    one = probe()
    assert one.expect(b"b", 1) == b"\x01"
    one.board.serial.write(b"b")
    one.board.press_button(0.05)
    assert one.board.serial.read() == b"\x00"
    assert one.expect(b"b", 1) == b"\x01"


@pytest.mark.parametrize("restart", ["reset", "power", "watchdog"])
def test_line_and_button_are_at_rest_after_a_restart(probe, restart):
    one = probe()
    assert one.expect(b"eA", 1) == b"A"
    one.board.serial.write(b"eBeC" if restart != "watchdog" else b"weBeC")
    one.board.run(50e-6)  # the rest is still on the wire
    if restart == "reset":
        one.board.reset()
    elif restart == "power":
        one.board.cut_power()
        one.board.power_on()
    one.board.run(0.1)
    one.board.serial.read()
    assert one.expect(b"b", 1) == b"\x01"


def test_the_led_is_in_the_trace(probe):
    one = probe(trace=True)
    one.expect(b"l\x01", 1)
    one.expect(b"l\x00", 1)
    assert [on for _, on in one.board.trace().led()] == [True, False]


def test_the_share_of_sleep_is_counted(probe):
    one = probe()
    one.board.run(1.0)
    assert one.board.counters().idle_cycles == 0  # it polls the serial line
    start = one.board.time
    one.convert(200)
    busy = 1 - one.board.counters().idle_cycles / (200 * 2500)
    assert one.board.time > start
    assert 0.03 < busy < 0.3  # an interrupt of about 100 cycles in 2500, and the start


def test_stack_left_is_what_the_deepest_call_has_not_touched(probe):
    one = probe()
    left = one.board.stack_left()
    assert 300 < left < 430  # 2048 bytes less 1621 of variables and some stack
    frames = []
    for depth in (4, 8, 12):
        one.expect(b"r" + bytes([depth]), 1)
        frames.append(one.board.stack_left())
    steps = {frames[0] - frames[1], frames[1] - frames[2]}
    assert len(steps) == 1 and steps.pop() >= 4 * 18  # 16 bytes and a return address each
    one.expect(b"r\x01", 1)
    assert one.board.stack_left() == frames[-1]  # it remembers


def test_the_ram_holds_noise_at_power_on_and_keeps_its_content_over_a_reset(probe):
    one = probe()
    noise = one.expect(b"n", 4)
    assert len(set(noise)) > 1
    one.expect(b"w", 2)
    assert one.expect(b"n", 4) == noise


def test_the_eeprom_survives_power_cuts_and_moves_to_another_board(probe):
    one = probe(eeprom=bytes(range(256)) * 4)
    assert one.board.eeprom()[:256] == bytes(range(256))
    one.expect(b"k\x05\xaa", 1)
    one.board.run(0.01)
    one.board.cut_power()
    one.board.power_on()
    one.expect(b"", 1)
    assert one.board.eeprom()[:7] == b"\x00\x01\x02\x03\x04\xaa\x06"
    other = probe(eeprom=one.board.eeprom())
    assert other.board.eeprom() == one.board.eeprom()
    with pytest.raises(SimulationError, match="the EEPROM has 1024 bytes"):
        probe(eeprom=b"short")


def test_variables_can_be_read_and_set_by_name(probe):
    one = probe()
    assert one.board.memory("reset_cause") == bytes([POWER_ON])
    one.board.set_memory("reset_cause", b"\x2a")
    assert one.expect(b"m", 1) == b"\x2a"
    with pytest.raises(SimulationError, match="no variable nonsense"):
        one.board.memory("nonsense")


def test_the_same_inputs_give_the_same_bytes(probe, tmp_path):
    def session(name):
        one = probe(signals=sines(3.0), card=CardImage.unformatted(tmp_path / name, 1), trace=True)
        one.convert(200)
        one.expect(b"w", 2)
        return one.board.trace().events.tobytes(), one.board.time

    assert session("a") == session("b")


def test_how_the_time_is_cut_into_pieces_changes_nothing(probe):
    def codes(pieces):
        one = probe(signals=sines(3.0))
        one.board.serial.write(b"c" + struct.pack("<H", 128))
        for _ in range(pieces):
            one.board.run(0.06 / pieces)
        return one.board.serial.read()

    assert codes(1) == codes(7) == codes(600)


def test_a_pseudo_terminal_stands_for_the_port(probe):
    one = probe()
    with Terminal(one.board) as terminal:
        port = os.open(terminal.path, os.O_RDWR | os.O_NOCTTY)
        os.write(port, b"eQ")
        terminal.serve(0.01, paced=False)
        assert os.read(port, 10) == b"Q"
        start, origin = time.monotonic(), one.board.time
        terminal.serve(0.2)
        assert time.monotonic() - start > 0.19  # not faster than real time
        assert one.board.time - origin == pytest.approx(0.2, abs=0.01)
        os.close(port)


def test_what_cannot_run_is_said_in_one_line(tmp_path, probe_elf):
    with pytest.raises(SimulationError, match="No such file"):
        Board(tmp_path / "none.elf")
    other = tmp_path / "other.elf"
    other.write_bytes(b"#!/bin/sh\n" * 20)
    with pytest.raises(SimulationError, match=r"other\.elf: not the ELF of an AVR program"):
        Board(other)
    other.write_bytes(probe_elf.read_bytes()[:60])
    with pytest.raises(SimulationError, match="cut short"):
        Board(other)
    with pytest.raises(SimulationError, match="nowhere"):
        Board(probe_elf, card=tmp_path / "nowhere.img")
    assert read_elf(probe_elf).mcu == "atmega328p"


def test_a_missed_trigger_event_names_its_cycle(probe):
    one = probe(trace=True)
    one.convert(16)
    missed = one.board.trace().of(Event.MISSED)
    assert len(missed) == 1 == one.board.counters().missed
