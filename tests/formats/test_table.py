"""What was found in a file becomes a recording: picked, placed, in SI, and told."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wheelhop.formats import ExchangeError, Map, Pick
from wheelhop.formats.table import Table, choose, plain_channel, to_recording
from wheelhop.logger.recording import Channel


def table(*channels, group=""):
    values = np.arange(2.0 * len(channels)).reshape(2, -1)
    return Table(Path("drive.mf4"), "MDF", channels, values, rate_hz=100.0, group=group)


@pytest.mark.parametrize("name", ["A1", "A2", "A3", "A4", "B1", "B2", "B3", "B4", "body"])
def test_a_channel_that_is_called_as_a_place_is_there_in_the_unit_that_is_said(name):
    """Of a file that says no unit none is known: an axle's pot may be called A1, too."""
    assert plain_channel(name) == Channel(name, "", name)
    assert plain_channel(name, "V").unit == "V"


@pytest.mark.parametrize("name", ["A0", "A5", "B0", "B5", "seat"])
def test_other_names_are_no_places(name):
    assert plain_channel(name) == Channel(name, "")


def test_what_is_in_si_already_is_not_told_to_be_converted():
    recording = to_recording(table(Channel("A1", "m/s²", "A1"), Channel("n", "1/min")), None)
    assert recording.history == ("imported from drive.mf4 (MDF)",)


@pytest.mark.parametrize(
    ("pick", "told", "second"),
    [
        (Pick("x", scale=2.0), "x: × 2 + 0 = mm, mm × 0.001 = m", 0.002),
        (Pick("x", offset=0.5), "x: × 1 + 0.5 = mm, mm × 0.001 = m", 0.0015),
        (Pick("x", unit="m", scale=1e-3), "x: × 0.001 + 0 = m", 0.001),
        (Pick("x", unit="m"), "x: the file says mm, the mapping m", 1.0),
        (Pick("x", unit="furlong"), "x: the file says mm, the mapping furlong", 1.0),
    ],
)
def test_what_a_mapping_does_to_numbers_is_told(pick, told, second):
    recording = to_recording(table(Channel("x", "mm")), Map(picks=(pick,)))
    assert recording.history[1:] == ((told,) if told else ())
    assert recording.values[1, 0] == pytest.approx(second, rel=1e-12)


def test_a_mapping_says_who_measured_and_what_it_does_not_say_stays():
    old = Channel("x", "g", "A1", "ADXL-1", "bench-1")
    said = Pick("x", "y", "mg", "A2", "ADXL-2", "bench-2")
    assert to_recording(table(old), Map(picks=(said,))).channels == (
        Channel("y", "m/s²", "A2", "ADXL-2", "bench-2"),
    )
    kept = replace(old, unit="m/s²")
    assert to_recording(table(old), Map(picks=(Pick("x"),))).channels == (kept,)


def test_no_two_channels_are_guessed_to_sit_in_one_place():
    """Somebody has told where the first is."""
    names = (Channel("accelerometer", "g", "A1"), Channel("axle FL", "g"), Channel("axle FR", "g"))
    recording = to_recording(table(*names), None)
    assert [channel.point for channel in recording.channels] == ["A1", "", "A2"]


def test_a_group_is_chosen_by_its_name():
    car, engine = (
        table(Channel("x", ""), group="car"),
        table(Channel("n", ""), Channel("p", ""), group="engine"),
    )
    file = Path("drive.mf4")
    assert choose([car, engine], "car", file) is car
    assert choose([car, engine], "engine", file) is engine
    assert choose([car], "", file) is car
    said = (
        r'drive\.mf4: has no group "seat": choose .* "car" \(1 channels\), "engine" \(2 channels\)'
    )
    with pytest.raises(ExchangeError, match=said):
        choose([car, engine], "seat", file)
    with pytest.raises(ExchangeError, match=r"drive\.mf4: holds no channels of numbers"):
        choose([], "car", file)


@pytest.mark.parametrize(
    ("unit", "word"),
    [("mm", "travel:1"), ("kN", "force:1"), ("km/h", "speed"), ("rad/s", "rate:pitch or")],
)
def test_what_is_no_acceleration_sits_at_no_place_and_says_what_it_is_good_for(unit, word):
    """Nor where its name is a place: an axle's pot may be called A1."""
    named = Channel("pot FL", unit)
    with pytest.raises(ExchangeError, match=f"cannot sit at A1: .* good as {word}"):
        to_recording(table(named), Map(picks=(Pick("pot FL", point="A1"),)))
    assert to_recording(table(Channel("A1", unit, "A1")), None).channels[0].point == ""
    assert to_recording(table(Channel("A1", "V", "A1")), None).channels[0].point == "A1"
