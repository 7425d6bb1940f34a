"""Tables with a row for each value: channels by name, on their own clocks, or no table at all."""

import numpy as np
import pytest

from tests.formats.foreign import G, save
from tests.formats.logged import units_of
from wheelhop.formats import ExchangeError, Map, parse_mapping, read, understand
from wheelhop.formats.long_form import is_key

ROWS = 300
TIME_S = np.arange(ROWS) / 100.0
WAVES = {"front": np.sin(6.0 * TIME_S), "rear": np.cos(6.0 * TIME_S), "seat": 0.1 * TIME_S}


def in_turns(apart_s=0.0, every=1):
    """Sensors that send in turns, `apart_s` after each other, the last of them more rarely."""
    rows = ["Time [s],Sensor,Acc [g]"]
    for k, time_s in enumerate(TIME_S):
        for n, (name, wave) in enumerate(WAVES.items()):
            if name != "seat" or k % every == 0:
                rows.append(f"{time_s + n * apart_s:.4f},{name}:,{wave[k]:.5f}")
    return "\n".join(rows) + "\n"


def answered(path, **answers):
    return read(path, parse_mapping(understand(path, answers).text(), path))


def test_channels_that_share_their_stamps_are_one_recording(tmp_path):
    path = save(tmp_path, "run.csv", in_turns())
    assert not understand(path).questions
    found = answered(path)
    assert found.rate_hz == 100.0 and units_of(found) == dict.fromkeys(WAVES, "m/s²")
    for k, wave in enumerate(WAVES.values()):
        assert found.values[:, k] == pytest.approx(wave * G, abs=1e-4)


def test_channels_with_clocks_of_their_own_are_asked_about(tmp_path):
    path = save(tmp_path, "run.csv", in_turns(0.0033, every=5))
    asked = understand(path).questions
    assert [question.key for question in asked] == ["resample_hz"]
    assert "front, rear, seat have clocks of their own" in asked[0].words
    found = answered(path, resample_hz="100")
    for k, wave in enumerate(WAVES.values()):
        there = ~np.isnan(found.values[:, k])
        assert there.sum() > 290
        exact = np.interp(found.time_s, TIME_S + k * 0.0033, wave)[there]
        assert found.values[there, k] == pytest.approx(exact * G, abs=0.02 if k < 2 else 1e-3)
    with pytest.raises(ExchangeError, match="choose with group"):
        read(path, Map(time="Time [s]", by="Sensor"))


def test_blocks_of_channels_one_below_the_other(tmp_path):
    rows = ["t [ms],variable,value"]
    rows += [
        f"{1e3 * t:.1f},{name},{x:.5f}"
        for name, wave in WAVES.items()
        for t, x in zip(TIME_S, wave, strict=True)
    ]
    found = answered(save(tmp_path, "run.csv", "\n".join(rows) + "\n"))
    assert found.rate_hz == 100.0 and list(units_of(found)) == list(WAVES)
    assert found.values[:, 1] == pytest.approx(WAVES["rear"], abs=1e-4)


def test_several_numbers_in_a_row_are_named_by_both(tmp_path):
    rows = ["time_ms,id,x [g],y [g]"]
    rows += [f"{5 * k},{'S1' if k % 2 else 'S2'},{k % 7},{k % 5}" for k in range(400)]
    found = answered(save(tmp_path, "run.csv", "\n".join(rows) + "\n"), resample_hz="100")
    assert sorted(units_of(found)) == ["S1/x", "S1/y", "S2/x", "S2/y"]


@pytest.mark.parametrize(
    "word",
    [
        lambda k: "idle" if k < 100 else "run",  # a state
        lambda k: "ok" if k else "start",  # a remark
        lambda k: f"lap {k // 60}",
        lambda k: f"note {k}",
        lambda k: f"note {k % 150}",  # two of each
        lambda k: "low" if k // 3 % 2 else "high",  # a switch that lasts for three rows
    ],
)
def test_words_that_last_are_no_channels(word, tmp_path):
    rows = [
        f"{t:.2f},{word(k)},{x:.4f}"
        for k, t, x in zip(range(ROWS), TIME_S, WAVES["front"], strict=True)
    ]
    path = save(tmp_path, "run.csv", "\n".join(["Time [s],what,az [g]", *rows]) + "\n")
    found = answered(path)
    assert len(found.values) == ROWS and list(units_of(found)) == ["az"]


def test_scripts_are_not_guessed_for(tmp_path):
    path = save(tmp_path, "run.csv", in_turns())
    assert "a row holds a value of one channel" in understand(path).guesses


def test_few_rows_of_many_channels_are_enough():
    assert is_key([f"cell {k}" for k in range(100)] * 4, [])
    assert is_key(["a", "b", "b", "c", "a", "b", "c", "c"] * 5, [])  # not quite in turns
