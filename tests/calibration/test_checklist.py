"""The checklist: what is planted into a session at rest fails its own step and no other."""

import json
from argparse import Namespace
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from tests.calibration.strikes import FINE_HZ, NOTES, POINTS, codes, struck
from tests.firmware.promises.conftest import SMALL, built
from tests.firmware.promises.logger import Logger, configure, last_session
from tests.logger.session import session
from wheelhop.calibration.health.checklist import check_commissioning
from wheelhop.calibration.health.taps import Taps, find_taps
from wheelhop.cli import health
from wheelhop.files import InputError
from wheelhop.hil_sim import CardImage, Signals
from wheelhop.logger.recording import ACCELERATION, CODE, Channel, Recording

STEPS = ("settings", "supply", "card", "clock", "quiet", "places", "upright")


def verdicts(recording):
    """Steps that have not passed, and their verdicts."""
    checks = check_commissioning(recording)
    assert tuple(check.step for check in checks) == STEPS
    assert all(bool(check.remedies) == (check.verdict != "pass") for check in checks)
    return {check.step: check.verdict for check in checks if check.verdict != "pass"}


@pytest.mark.parametrize("rate_hz", [100, 200, 400])
def test_a_good_session_passes(rate_hz):
    for seed in (0, 1, 45):  # 45 has an axle that rings on, and faster than it began
        assert verdicts(struck(seed, rate_hz=rate_hz)) == {}


@pytest.mark.parametrize("seed", range(10))
def test_exchanged_plugs_and_inverted_sensors_are_named(seed):
    draw = np.random.default_rng(seed)
    one, other = draw.choice(8, 2, replace=False)
    channels = np.arange(8)
    channels[[one, other]] = other, one
    inverted = draw.choice(8, 1 + seed % 3, replace=False)
    checks = {
        check.step: check
        for check in check_commissioning(struck(seed, channels=channels, inverted=inverted))
    }
    assert [s for s in STEPS if checks[s].verdict != "pass"] == ["places", "upright"]
    felt = [POINTS[k] for k in np.argsort(channels)]
    assert f"felt by {' '.join(felt)} (" in checks["places"].seen
    plugs = sorted(POINTS[int(np.flatnonzero(channels == point)[0])] for point in inverted)
    assert checks["upright"].remedies[0].startswith(f"{', '.join(plugs)} rose")


@pytest.mark.parametrize("seed", range(3))
def test_all_sensors_upside_down_are_found_which_no_drive_tells(seed):
    assert verdicts(struck(seed, inverted=range(8))) == {"upright": "fail"}


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 5))
def test_the_right_pairing_has_the_largest_product_in_any_structure(seed, size):
    """Any mass matrix, any strengths of strikes, any gains; tried against all pairings."""
    draw = np.random.default_rng(seed)
    root = draw.normal(size=(size, size))
    mobility = root @ root.T + 0.05 * np.eye(size)
    felt = np.exp(draw.normal(size=(size, 1))) * mobility * np.exp(draw.normal(size=size))
    felt /= np.abs(felt).min()  # nothing below the floor at which rounding decides
    shuffled = draw.permutation(size)
    pairing, surer = Taps(np.arange(size), felt[:, shuffled]).pairing()
    assert np.array_equal(shuffled[pairing], np.arange(size))
    products = sorted(np.prod(np.abs(felt[range(size), p])) for p in permutations(range(size)))
    assert surer == pytest.approx(min(products[-1] / products[-2], 1e6), rel=1e-6)


@pytest.mark.parametrize(("order", "count"), [(range(7), 7), ([*range(8), 0], 9), ((), 0)])
def test_too_few_and_too_many_strikes_are_counted(order, count):
    recording = struck(1, order=order)
    assert find_taps(recording, 8) == count
    assert verdicts(recording) == {"places": "open", "upright": "open"}


@pytest.mark.parametrize(
    ("changes", "failed"),
    [
        ({"device": "0"}, {"settings": "fail"}),
        ({"calibration": ""}, {"settings": "fail"}),
        ({"config_errors": "2"}, {"settings": "fail"}),
        ({"supply_mv": "3300", "end_supply_mv": "3100"}, {"supply": "fail"}),
        ({"supply_mv": "0", "end_supply_mv": "0"}, {"supply": "open"}),
        ({"reset": "brown-out"}, {"supply": "fail"}),
        ({"reset": "watchdog"}, {"supply": "fail"}),
        ({"end": "recovered"}, {"card": "fail"}),
        ({"end": ""}, {"card": "fail"}),
        ({"lost": "3"}, {"card": "fail"}),
        ({"card_errors": "1"}, {"card": "fail"}),
        ({"source": "stream"}, {"card": "open"}),
        ({"clock_ppm": ""}, {"clock": "fail"}),
        ({"late": "1"}, {"clock": "fail"}),
    ],
)
def test_each_note_of_the_log_fails_its_own_step(changes, failed):
    assert verdicts(struck(2, notes=NOTES | changes)) == failed


def test_what_is_wrong_at_rest_fails_the_quiet_step():
    good = struck(3, impulse=(6.0, 9.0))
    time = good.time_s[:, None]
    hum = np.zeros((len(time), 8))
    hum[:, 1:2] = 0.8 * np.sin(2 * np.pi * 60.05 * time)
    floating = np.where(np.arange(8) == 5, -400.0, 0.0)
    idling = 1.5 * np.random.default_rng(1).normal(size=(len(time), 8)) * (time < 10)
    for fault in (hum, floating, idling):
        assert verdicts(replace(good, values=good.values + fault)) == {"quiet": "fail"}
    at_once = replace(good, values=good.values[800:])
    assert verdicts(at_once) == {"quiet": "open"}
    gap = good.values.copy()
    gap[300:310] = np.nan
    assert verdicts(replace(good, values=gap)) == {"card": "fail"}


@settings(max_examples=60, deadline=None)
@given(
    arrays(
        np.float64,
        st.tuples(st.integers(0, 1500), st.integers(1, 4)),
        elements=st.sampled_from([512.0, 512.0, 512.125, 0.0, 1023.0, float("nan")]),
    )
)
def test_no_session_is_too_odd_to_check(values):
    channels = tuple(Channel(point, CODE) for point in POINTS[: values.shape[1]])
    values[np.isnan(values).any(axis=1)] = np.nan
    recording = Recording(values, 100.0, channels, notes=NOTES)
    if recording.missing.all():
        with pytest.raises(InputError, match="no scan"):
            check_commissioning(recording)
    else:
        verdicts(recording)


def run(file, *more, **options):
    given = {"recordings": [file, *more], "figure": None, "json": None, "checklist": True}
    return health.run(Namespace(**given | options))


def test_from_file_to_exit_status(tmp_path, capsys):
    file = tmp_path / "HOP00012.HOP"
    sums = np.round(8 * struck(4).values).astype(int)
    ready = session(sums)
    file.write_bytes(ready)
    assert run(file, json=tmp_path / "out.json") == 0
    assert "ready to drive" in capsys.readouterr().out
    result = json.loads((tmp_path / "out.json").read_text(encoding="utf-8"))
    assert result["passed"] and [check["step"] for check in result["checks"]] == list(STEPS)
    file.write_bytes(session(sums, device=0))
    assert run(file) == 1
    out = capsys.readouterr().out
    assert "not ready yet" in out and "wheelhop logger --set device=1" in out


def test_what_is_no_log_of_the_logger_is_refused(tmp_path):
    decoded = struck(5, order=())
    channels = tuple(Channel(point, ACCELERATION) for point in POINTS)
    for recording in (replace(decoded, channels=channels), replace(decoded, notes={})):
        with pytest.raises(InputError, match="own file"):
            check_commissioning(recording)
    with pytest.raises(InputError, match="only one"):
        run(tmp_path / "a.HOP", tmp_path / "b.HOP")
    with pytest.raises(InputError, match="not together"):
        run(tmp_path / "a.HOP", figure=tmp_path / "a.png")


def test_the_real_firmwares_file_passes_and_two_exchanged_plugs_fail(tmp_path):
    elf = built("nano", tmp_path)
    felt = codes(6)
    felt += 0.3 * np.random.default_rng(6).normal(size=felt.shape)  # the converter's own
    for channels, status in ((range(8), 0), ((0, 1, 2, 3, 5, 4, 6, 7), 1)):
        card = configure(CardImage.fat32(tmp_path / f"{status}.img"), SMALL)
        signals = Signals(felt[:, list(channels)], FINE_HZ)
        with Logger(elf, card, signals=signals) as logger:
            logger.boot()
            for key, value in (("device", 3), ("calibration", "cal-1"), ("clock_ppm", -812)):
                assert logger.command(f"set {key}={value}").ok
            logger.command("start")
            logger.run(len(felt) / FINE_HZ - 0.5)
            logger.command("stop")
            file = tmp_path / last_session(card.files())
            file.write_bytes(card.read(file.name))
        assert run(file) == status
