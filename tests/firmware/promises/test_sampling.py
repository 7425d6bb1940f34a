"""Promise 1: all channels have the same mean instant. Promise 6: jitter is bounded in cycles."""

import numpy as np
import pytest

from tests.firmware.promises.logger import ADC_VECTOR, configure
from tests.firmware.promises.reader import parse_text
from wheelhop.hil_sim import Event, constant, from_array
from wheelhop.logger import read_log as wheelhop_log

CPU_HZ = 16e6
SAMPLE_DELAY_S = 259 / CPU_HZ  # from the trigger: ATmega328P data sheet, table 24-1
CONVERSION_S = 2500 / CPU_HZ
CONVERSION_CYCLES = 1731  # from trigger to result: 13.5 of 128 cycles, and 3 to synchronise
OTHER_VECTORS = (14, 18, 19)  # the clock's, the receiver's, the transmitter's
# 3983 codes per second: 4.4 codes in the 1.09 ms between first and last channel, and no multiple
# of the scan rate, so that scans meet the steps of the converter at every phase.
LOW, HIGH, RISE_S = 100.3, 900.7, 0.201


def triangle():
    """All channels rise and fall together, for ever."""
    rows = np.array([LOW, HIGH])[:, None] * np.ones(8)
    return from_array(rows, 1 / RISE_S, repeat=True)


def triangle_at(time_s):
    phase = np.mod(time_s / RISE_S, 2.0)
    return LOW + (HIGH - LOW) * np.where(phase < 1, phase, 2 - phase)


def session(logger, card, seconds=2.0, **options):
    """A session, its file, and its triggers in seconds of board time."""
    one = logger(card, trace=True, **options)
    one.board.trace()
    assert one.command("start").ok
    one.run(seconds)
    assert one.command("stop").ok
    return one, one.log(), one.board.trace()


def triggers_of(trace, log):
    """Times of the conversions of the session, the last uninterrupted run of triggers."""
    events = trace.of(Event.CONVERSION)
    cycles = events["cycle"][events["which"] < 8].astype(np.int64)
    pauses = np.flatnonzero(np.diff(cycles) > 10000) + 1  # the supply's reading takes 8700
    runs = np.split(cycles, pauses)
    needed = len(log.scans) * int(log.header["conversions"]) * 8
    return max(runs, key=len), needed


def test_on_a_ramp_all_channels_have_the_same_mean(logger, card):
    _, log, _ = session(logger, card, signals=triangle())
    straight = 0
    for sums in log.scans.values():
        if min(sums) > 8 * (LOW + 60) and max(sums) < 8 * (HIGH - 60):
            straight += 1
            assert max(sums) - min(sums) <= 8, sums  # means within one code
    assert straight > 100


@pytest.mark.parametrize("rate", [100, 200, 400])
def test_a_scan_is_the_mean_about_the_instant_that_the_specification_gives(logger, card, rate):
    configure(card, f"size_mb = 1\nstream = on\nrate = {rate}\n")
    _, log, trace = session(logger, card, 1.0, signals=triangle())
    conversions = int(log.header["conversions"])
    assert rate * conversions == 800
    triggers, needed = triggers_of(trace, log)
    first_s = triggers[0] / CPU_HZ
    if len(triggers) > needed and triggers[1] - triggers[0] != 2500:
        first_s = triggers[1] / CPU_HZ  # a conversion by hand went before
    half = 8 * conversions // 2
    for number, sums in log.scans.items():
        if not conversions * (LOW + 60) < min(sums) <= max(sums) < conversions * (HIGH - 60):
            continue
        centre = first_s + (number * 2 * half + (2 * half - 1) / 2) * CONVERSION_S
        truth = triangle_at(centre + SAMPLE_DELAY_S)
        means = np.array(sums) / conversions + 0.5  # codes are rounded down
        assert np.abs(means - truth).max() < 0.6 + 1 / conversions, number


def test_conversions_start_without_jitter_while_card_and_line_are_busy(logger, card, capsys):
    one = logger(card, trace=True, signals=triangle())
    assert one.command("start").ok
    one.board.trace()
    for _ in range(6):
        one.run(0.4)
        assert one.command("status").ok
    trace = one.board.trace()
    conversions = trace.of(Event.CONVERSION).size
    runs = trace.interrupts(ADC_VECTOR)
    took = runs[:, 1] - runs[:, 0]
    idle = one.board.counters().idle_cycles / (one.board.time * CPU_HZ)
    with capsys.disabled():
        print(
            f"\nfirmware: jitter {trace.conversion_jitter()} cycles over {conversions} conversions,"
            f" interrupt at most {took.max()} cycles, idle {idle:.0%} of the time since power-on, "
            f"{one.board.stack_left()} bytes of RAM never touched"
        )
    assert trace.conversion_jitter() == 0
    assert trace.of(Event.MISSED).size == 0
    assert took.max() < 2500 - 13.5 * 128  # or else the next trigger meets a raised flag


def test_nothing_offends_the_card_or_the_converter(logger, card):
    one, log, _ = session(logger, card)
    counters = one.board.counters()
    assert (counters.card_violations, one.board.last_violation()) == (0, "")
    assert counters.reference_conflicts == 0  # AREF is driven from outside
    assert (counters.spi_collisions, counters.serial_overruns, counters.missed) == (0, 0, 0)
    assert log.summary["late"] == "0"


def steps_of_the_inputs():
    """A voltage of its own at every input, so that a neighbour's shows in the sums."""
    return constant(np.arange(8) * 100 + 50.5)


def scans_with_another_inputs_voltage(log):
    conversions = int(log.header["conversions"])
    right = tuple(conversions * (100 * k + 50) for k in range(8))
    return {number: sums for number, sums in log.scans.items() if sums != right}


def lost_triggers(trace):
    """simavr tells of one trigger twice if the timer's top is written at that moment."""
    cycles = trace.of(Event.MISSED)["cycle"].astype(np.int64)
    return int(np.count_nonzero(np.diff(cycles, prepend=-1000) > 100))


@pytest.mark.parametrize("cycles", [900, 1600, 2200])
def test_triggers_that_are_lost_are_counted(logger, card, cycles):
    """As if something kept the interrupt waiting, at every phase of the period."""
    one = logger(card, trace=True, signals=steps_of_the_inputs())
    assert one.command("start").ok
    one.board.trace()
    for _ in range(50):
        one.run(0.01 + 2500 / CPU_HZ / 50)
        one.board.hold_cpu(cycles)
    one.run(0.1)
    missed = lost_triggers(one.board.trace())
    assert missed >= 2  # at 900 cycles, one phase in twenty
    assert one.command("stop").ok
    log = one.log()
    assert int(log.summary["late"]) == missed
    assert int(log.summary["due"]) == len(log.scans) + int(log.summary["lost"])
    late = [block.late for block in log.blocks]
    assert late == sorted(late) and late[-1] == missed
    assert scans_with_another_inputs_voltage(log) == {}


def test_scans_behind_late_triggers_are_decoded_at_their_times(logger, card):
    wave_hz = 4.0
    steps = np.arange(2000)[:, None] * np.ones(8) * 0.5e-3
    wave = from_array(512 + 400 * np.sin(2 * np.pi * wave_hz * steps), 2000.0, repeat=True)
    one = logger(card, trace=True, signals=wave)
    one.board.trace()
    assert one.command("start").ok
    one.run(0.2)
    for _ in range(80):
        one.run(0.005 + 0.618 * 2500 / CPU_HZ)  # no simple part of the clock's round
        one.board.hold_cpu(2000)
    one.run(2.0)
    assert one.command("stop").ok
    log = wheelhop_log(card.read("HOP00001.HOP"))
    assert log.late > 40  # nearly a scan
    triggers, _ = triggers_of(one.board.trace(), one.log())
    first_s = triggers[int(triggers[1] - triggers[0] != 2500)] / CPU_HZ  # one was by hand
    recording = log.recording()
    at_s = first_s + SAMPLE_DELAY_S + recording.time_s
    truth = 512 + 400 * np.sin(2 * np.pi * wave_hz * at_s)
    off = np.abs(recording.values + 0.5 - truth[:, None])
    assert np.nanmax(off[-150:-10]) < 2  # codes; left by number, they are 80 off


def wait_in_a_scan_that_reads_the_supply(one, position, cycles):
    """At 400 scans a second, keep the interrupt waiting behind a conversion of the next such scan.

    Returns when the last reading before it began, and the trace up to the scan behind it.
    """
    one.board.trace()
    one.run(0.08)
    events = one.board.trace().of(Event.CONVERSION)
    reading = int(events["cycle"][events["which"] >= 8][-1])
    first = reading - 4500 - 7 * 2200
    starts = [first + 2200 * k for k in range(8)] + [reading]
    starts += [reading + 2200 * k for k in range(1, 9)]
    end = starts[position] + 32 * 40000 + CONVERSION_CYCLES
    one.run((end - 4) / CPU_HZ - one.board.time)
    one.board.hold_cpu(cycles)
    one.run(0.005)
    return reading, one.board.trace()


@pytest.mark.parametrize("cycles", [400, 440, 480])
def test_an_interrupt_too_late_for_the_supply_is_counted(logger, card, cycles):
    """Behind every conversion of a scan that has 469 cycles from there to the next trigger."""
    configure(card, "size_mb = 1\nrate = 400\n")
    one = logger(card, trace=True, signals=steps_of_the_inputs())
    assert one.command("start").ok
    lost, readings = [], []
    for position in range(17):
        reading, trace = wait_in_a_scan_that_reads_the_supply(one, position, cycles)
        readings.append(reading)
        lost.append(lost_triggers(trace))
    assert one.command("stop").ok
    log = one.log()
    assert lost == [1] * 17
    assert int(log.summary["late"]) == sum(lost)
    assert scans_with_another_inputs_voltage(log) == {}
    # Everything after a late trigger is 2500 cycles later, or up to 300 less.
    for was_lost, shift in zip(lost, np.diff(readings) % (32 * 40000), strict=False):
        assert 2200 * was_lost <= shift <= 2500 * was_lost


def test_no_cycle_is_too_late_for_the_input_and_too_early_to_be_counted(logger, card):
    """Cycle by cycle over the last moment at which the next trigger still starts a conversion."""
    configure(card, "size_mb = 1\nrate = 400\n")
    one = logger(card, trace=True, signals=steps_of_the_inputs())
    assert one.command("start").ok
    lost = [
        lost_triggers(wait_in_a_scan_that_reads_the_supply(one, 3, cycles)[1])
        for cycles in range(320, 370)
    ]
    assert one.command("stop").ok
    log = one.log()
    assert set(lost) == {0, 1} and lost[0] == 0 and lost[-1] == 1
    assert int(log.summary["late"]) == sum(lost)
    assert scans_with_another_inputs_voltage(log) == {}


def test_the_other_interrupts_together_make_no_trigger_late(logger, card):
    """At 400 scans a second, behind every conversion of a scan that reads the supply."""
    configure(card, "size_mb = 1\nrate = 400\n")
    one = logger(card, trace=True, signals=steps_of_the_inputs())
    assert one.command("start").ok
    one.board.trace()
    assert one.command("status").ok
    trace = one.board.trace()
    together = sum(int(np.diff(trace.interrupts(vector)).max()) for vector in OTHER_VECTORS)
    for position in range(17):
        tries = (wait_in_a_scan_that_reads_the_supply(one, position, together) for _ in range(2))
        # The clock's may come once more on top; by the next such scan it has moved on.
        assert 0 in (lost_triggers(trace) for _, trace in tries), (position, together)
    assert one.command("stop").ok
    assert scans_with_another_inputs_voltage(one.log()) == {}


@pytest.mark.parametrize("names", ["- - - - - - - X1", "B1 - B3 - A1 - A3 -"])
def test_chosen_channels_alone_are_recorded(logger, card, names):
    configure(card, f"size_mb = 1\nchannels = {names}\n")
    levels = np.arange(8) * 100 + 50.5
    _, log, _ = session(logger, card, 1.0, signals=constant(levels))
    chosen = [
        int(level) * 8 for level, name in zip(levels, names.split(), strict=True) if name != "-"
    ]
    assert log.header["channels"] == names
    assert set(log.scans.values()) == {tuple(chosen)}
    assert len(log.scans) >= 99


def test_full_scale_on_all_channels_is_stored_unharmed(logger, card):
    _, log, _ = session(logger, card, 1.0, signals=constant(2000.0))
    assert set(log.scans.values()) == {(8184,) * 8}


@pytest.mark.parametrize("volts", [2.8, 3.3, 3.6])
def test_the_supply_of_the_sensors_is_measured(logger, card, volts):
    _, log, _ = session(logger, card, 0.5, reference_volts=volts)
    assert abs(int(log.header["supply_mv"]) - 1000 * volts) < 15  # one code at 1.1 V


@pytest.mark.parametrize("rate", [100, 200, 400])
def test_reading_the_supply_leaves_every_mean_instant_where_it_was(logger, card, rate):
    configure(card, f"size_mb = 1\nstream = on\nrate = {rate}\n")
    _, log, trace = session(logger, card, 1.0)
    length = 8 * int(log.header["conversions"])
    events = trace.of(Event.CONVERSION)
    at = np.flatnonzero(events["which"] >= 8)
    at = at[at < len(events) - length]
    # Before and behind a session the reference is converted several times in a row.
    at = at[(events["which"][at - 1] < 8) & (events["which"][at + 1] < 8)]
    assert len(at) >= 3 * rate // 100
    for i in at:
        scan = np.delete(events[i - length // 2 : i + length // 2 + 1], length // 2)
        cycles = scan["cycle"].astype(np.int64) - int(scan["cycle"][0])
        assert list(scan["which"][:16]) == [*range(8), *range(7, -1, -1)]
        assert cycles[-1] == (length - 1) * 2500
        means = {cycles[scan["which"] == k].mean() for k in range(8)}
        assert means == {(length - 1) * 2500 / 2}
        # From the end of the conversion before, the reference has 170 µs.
        assert int(events["cycle"][i] - events["cycle"][i - 1]) > CONVERSION_CYCLES + 170 * 16
    runs = trace.interrupts(ADC_VECTOR)
    begun = events["cycle"].astype(np.int64)
    which = np.searchsorted(begun, runs[:, 1]) - 1
    # The interrupt's first 125 cycles make the next trigger ready; 50 are in hand.
    assert (runs[:, 0] - begun[which]).max() < 2500 - 300 - 125 - 50


def sag(one, volts, seconds):
    """The sensors' supply falls for so long."""
    one.board.reference_volts = volts
    one.run(seconds)
    one.board.reference_volts = 3.3


def told(log):
    """Scan and millivolts of the file's blocks about the supply."""
    texts = [parse_text(block.payload) for block in log.blocks if block.kind == b"V"]
    return [(int(text["scan"]), int(text["supply_mv"])) for text in texts]


@pytest.mark.parametrize("rate", [100, 200, 400])
def test_a_sag_of_the_supply_is_in_the_file_and_in_the_summary(logger, card, rate):
    configure(card, f"size_mb = 1\nstream = on\nrate = {rate}\n")
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    sag(one, 2.95, 0.5)
    one.run(1.2)
    assert abs(int(one.command("status").values["supply_mv"]) - 3300) < 15
    assert one.command("stop").ok
    log = one.log()
    (fell, low), (rose, again) = told(log)
    assert rate <= fell <= 1.4 * rate < 1.5 * rate <= rose <= 1.9 * rate
    assert abs(low - 2950) < 15 and abs(again - 3300) < 15
    assert int(log.summary["lowest_mv"]) == low
    assert abs(int(log.summary["supply_mv"]) - 3300) < 15
    assert log.summary["lost"] == "0" and log.summary["late"] == "0"
    assert sorted(log.scans) == list(range(int(log.summary["due"])))
    decoded = wheelhop_log(card.read("HOP00001.HOP"))
    assert decoded.missing == 0 and not decoded.damage


def test_a_sag_is_in_the_file_when_the_power_fails_behind_it(logger, card):
    one = logger(card)
    assert one.command("start").ok
    one.run(1.0)
    sag(one, 2.7, 1.0)
    one.board.cut_power()
    log = one.log()
    assert log.summary is None
    assert [abs(low - 2700) < 15 for _, low in told(log)] == [True]


def test_a_steady_supply_takes_no_room_in_the_file(logger, card):
    _, log, _ = session(logger, card)
    assert told(log) == []
    assert abs(int(log.summary["lowest_mv"]) - 3300) < 15
