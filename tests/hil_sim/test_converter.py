"""The converter: exact codes, exact times, and no trigger lost unseen."""

import struct

import numpy as np
import pytest

from wheelhop.hil_sim import Event, Faults, constant, from_volts, ramp, sines

ADC_VECTOR, TIMER1_COMPA_VECTOR = 21, 11
OCF1A = 1 << 1
PALINDROME = [0, 1, 2, 3, 4, 5, 6, 7, 7, 6, 5, 4, 3, 2, 1, 0]
SAMPLE_DELAY = 2 * 128 + 3  # cycles from the trigger: data sheet 24.4, table 24-1
CPU_HZ = 16e6


@pytest.mark.parametrize(
    ("level", "code"),
    [(-3.0, 0), (0.0, 0), (0.999, 0), (1.0, 1), (511.5, 511), (1023.0, 1023), (2000.0, 1023)],
)
def test_a_code_is_the_next_lower_integer_within_ten_bits(probe, level, code):
    assert set(probe(signals=constant(level)).convert(16)) == {code}


def test_every_input_is_read_at_its_own_place_in_the_palindrome(probe):
    codes = probe(signals=constant(np.arange(8) * 100 + 50.5)).convert(48)
    assert codes == [channel * 100 + 50 for channel in PALINDROME * 3]


def test_a_voltage_becomes_its_share_of_the_reference(probe):
    volts = [[0.0, 0.4125, 0.825, 1.65, 2.475, 3.2, 3.299, 3.4]]
    one = probe(signals=from_volts(volts, 1.0))
    assert one.convert(8) == [0, 128, 256, 512, 768, 992, 1023, 1023]


@pytest.mark.parametrize("reference_volts", [3.0, 3.3, 5.0])
def test_the_internal_1100_mv_reference_shows_what_aref_is(probe, reference_volts):
    one = probe(reference_volts=reference_volts)
    code, _ = struct.unpack("<HH", one.expect(b"a\x0e", 4))
    assert code == int(1.1 / reference_volts * 1024)


def test_a_conversion_started_by_hand_takes_13_converter_clocks(probe):
    one = probe()
    _, cycles = struct.unpack("<HH", one.expect(b"a\x00", 4))
    assert 13 * 128 <= cycles < 13 * 128 + 20  # the loop that waits has its own grain


def test_triggers_come_every_2500_cycles_without_jitter(probe):
    one = probe(trace=True)
    one.convert(200)
    conversions = one.board.trace().of(Event.CONVERSION)[1:]
    assert set(np.diff(conversions["cycle"].astype(int))) == {2500}
    assert list(conversions["which"][:15]) == PALINDROME[1:]


def test_the_interrupt_comes_when_13_and_a_half_converter_clocks_are_over(probe):
    one = probe(trace=True)
    one.convert(64)
    trace = one.board.trace()
    triggers = trace.of(Event.CONVERSION)["cycle"].astype(int)
    starts = trace.interrupts(ADC_VECTOR)[:, 0]
    late = starts[1:] - triggers[1 : len(starts)] - (27 * 128 // 2 + 3)
    assert late.min() >= 0 and late.max() <= 8  # the instruction under way, and waking up


def test_the_input_is_sampled_259_cycles_after_the_trigger(probe):
    one = probe(signals=ramp(0, 1000, seconds=1.0), trace=True)
    codes = one.convert(120)
    triggers = one.board.trace().of(Event.CONVERSION)["cycle"].astype(float)
    expected = np.floor((triggers[1:] + SAMPLE_DELAY) / CPU_HZ * 1000)
    assert codes[1:] == expected[: len(codes) - 1].astype(int).tolist()


def test_equal_ramps_have_equal_means_over_the_palindrome(probe):
    codes = np.array(probe(signals=ramp(100, 5000, seconds=0.18)).convert(240)[48:112])
    order = np.array(PALINDROME * 4)
    means = [codes[order == channel].mean() for channel in range(8)]
    assert max(means) - min(means) <= 1.0
    plain = [codes[:8][channel] for channel in range(8)]
    assert max(plain) - min(plain) >= 4  # what plain order would make of it


def test_a_trigger_while_its_flag_is_up_or_a_conversion_runs_is_lost_and_counted(probe):
    one = probe(signals=constant(np.arange(8) * 100), trace=True)
    one.convert(32)
    assert one.board.counters().missed == 1  # the first conversion takes 25 clocks: 3267 cycles
    one.board.trace()
    dawdle = struct.pack("<HH", 20, 1500)  # about 5 cycles a loop, in the routine, flag cleared
    one.expect(b"d" + dawdle, 1)
    codes = one.convert(32)
    assert codes == [channel * 100 for channel in PALINDROME * 2]
    trace = one.board.trace()
    steps = np.diff(trace.of(Event.CONVERSION)["cycle"].astype(int))
    assert one.board.counters().missed > 2
    assert set(steps) - {2500} and all(step % 2500 == 0 for step in steps)


def test_a_one_written_to_the_flags_of_the_timer_clears_that_one(probe):
    one = probe(trace=True)
    after_b, after_interrupt = one.expect(b"i", 2)
    assert after_b == OCF1A
    assert after_interrupt & OCF1A == 0


def test_an_empty_interrupt_routine_takes_4_cycles_of_entry_and_3_of_jump(probe):
    one = probe(trace=True)
    one.expect(b"i", 2)
    spans = one.board.trace().interrupts(TIMER1_COMPA_VECTOR)
    assert set(spans[:, 1] - spans[:, 0]) == {4 + 3}


@pytest.mark.parametrize(("cycles", "lost"), [(600, 0), (6000, 2), (60_000, 23)])
@pytest.mark.parametrize("phase", [0.0, 0.2, 0.4, 0.6, 0.8])
def test_code_that_takes_too_long_loses_triggers(probe, cycles, lost, phase):
    """One conversion ends in that time, and waits; the triggers after it meet its flag."""
    one = probe(trace=True)
    one.board.serial.write(b"c" + struct.pack("<H", 128))
    one.board.run(10e-3 + phase * 156.25e-6)
    one.board.hold_cpu(cycles)
    one.board.run(20e-3)
    assert len(one.board.serial.read()) == 2 * 128
    assert one.board.counters().missed - 1 in (lost - 1, lost, lost + 1)  # the phase
    steps = np.diff(one.board.trace().of(Event.CONVERSION)["cycle"].astype(int))[1:]
    assert all(step % 2500 == 0 for step in steps)
    assert sum(step // 2500 - 1 for step in steps) == one.board.counters().missed - 1


def test_a_program_that_stands_still_has_its_interrupts_go_on(probe):
    one = probe(trace=True)
    begin = one.board.time
    one.board.faults = Faults(holds=[(begin + 5e-3, begin + 15e-3), (begin + 0.1, begin + 0.15)])
    one.convert(128)  # 20 ms
    assert one.board.counters().missed == 1  # of the first, as always
    one.board.run(begin + 0.11 - one.board.time)
    one.board.serial.write(b"m")
    one.board.run(0.1)
    (answered,), _ = one.board.serial.read_timed()
    assert begin + 0.15 < answered < begin + 0.151


def test_an_internal_reference_against_a_driven_aref_is_noticed(probe):
    one = probe()
    one.expect(b"a\x00", 4)
    assert one.board.counters().reference_conflicts == 0
    one.expect(b"a\xc0", 4)
    assert one.board.counters().reference_conflicts == 2


def test_sines_arrive_with_frequency_amplitude_and_phase(probe):
    one = probe(signals=sines(40.0, 300.0, 500.0, 0.3, seconds=0.2), trace=True)
    one.convert(250)
    events = one.board.trace().of(Event.CONVERSION)[1:]  # the first samples later
    time_s = (events["cycle"] + SAMPLE_DELAY) / CPU_HZ
    truth = 500 + 300 * np.sin(2 * np.pi * 40 * time_s + 0.3)
    error = events["value"] - truth
    assert (error <= 0.06).all() and (error > -1.06).all()  # rounding, and lines for arcs
