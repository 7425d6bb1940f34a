"""A dead sensor is told from a still one by its self-test."""

import numpy as np
import pytest

from wheelhop.cli.main import main
from wheelhop.hil_sim import constant, sines
from wheelhop.hil_sim.double import DoubleFaults, SerialDouble
from wheelhop.hil_sim.signals import SELF_TEST
from wheelhop.logger import LoggerError
from wheelhop.logger.link import connect
from wheelhop.logger.self_test import expected_codes, judged, self_test

FACTOR = 20.0


def test_what_is_expected_is_the_data_sheets_at_3_3_volts():
    """29, 105 and 190 mV at 3 V; the cube of 1.1; 1024 codes are 3.3 V."""
    assert expected_codes() == pytest.approx((11.98, 43.37, 78.47), abs=0.01)
    assert pytest.approx(expected_codes()[1], abs=0.5) == SELF_TEST


@pytest.mark.parametrize(
    ("shift", "verdict"),
    [
        *((43, "moves"), (12, "moves"), (78, "moves"), (1, "dead"), (-1, "dead"), (0, "dead")),
        *((6, "weak"), (9, "weak"), (-30, "inverted"), (85, "strong"), (160, "strong")),
    ],
)
def test_every_answer_has_its_word(shift, verdict):
    rest = np.full(50, 530.0) + np.tile([0.0, 0.2], 25)
    assert judged("B1", rest, rest + shift, rest).verdict == verdict


def test_who_moves_the_sensors_is_asked_to_wait():
    rest, moved = np.full(50, 530.0), np.linspace(500, 640, 50)
    assert judged("B1", rest, moved, rest).verdict == "unsteady"
    assert judged("B1", rest, rest + 43, rest + 60).verdict == "unsteady"
    noisy = rest + np.tile([-10.0, 10.0], 25)
    assert judged("B1", noisy, noisy + 4, noisy).verdict == "dead"  # within its noise


def test_a_dead_sensor_among_still_ones_is_found(tmp_path, capsys):
    faults = DoubleFaults(self_test=(43.0, 43.0, 0.0, 43.0, -20.0, 43.0, 43.0, 5.0))
    with SerialDouble(constant(531.0), tmp_path, faults, factor=FACTOR) as double:
        with connect(double.url) as link:
            found = {one.channel: one.verdict for one in self_test(link)}
            assert link.status()["state"] == "ready"
            link.start()
            with pytest.raises(LoggerError, match="a session runs"):
                self_test(link)
            link.stop()
        assert main(["logger", "selftest", "--port", double.url]) == 1
    assert found.pop("B3") == "dead" and found.pop("A1") == "inverted"
    assert found.pop("A4") == "weak" and set(found.values()) == {"moves"}
    printed = capsys.readouterr().out
    assert "B3" in printed and "does not answer" in printed and "none answers" not in printed


def test_sensors_that_none_answer_are_a_wire(capsys):
    faults = DoubleFaults(self_test=(0.0,) * 8)
    with SerialDouble(sines(3.0, 2.0), None, faults, factor=FACTOR) as double:
        assert main(["logger", "selftest", "--port", double.url]) == 1
    assert "D8 does not reach" in capsys.readouterr().out
