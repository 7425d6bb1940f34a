"""A calibration through the real firmware on the simulated board, and through the double."""

import numpy as np
import pytest

from tests.calibration.test_comparison import CONDITIONS, delay_at_10_hz, gain_at_10_hz
from tests.firmware.promises.conftest import SMALL, built
from tests.firmware.promises.logger import Logger, configure, last_session
from wheelhop.calibration.shaker.comparison import compare_with_reference
from wheelhop.hil_sim import CardImage
from wheelhop.hil_sim.rig import Rig, Sensor, Shaking
from wheelhop.hil_sim.stand_in import stand_in
from wheelhop.logger import connect, read_log

FREQUENCIES = (9.7, 3.7, 21.7, 43.3, 15.3)
SHAKING = Shaking(tuple((f, min(15.0, 0.012 * (2 * np.pi * f) ** 2), 5.0) for f in FREQUENCIES))
NAMES = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")


def through_the_firmware(signals, folder):
    card = configure(CardImage.fat32(folder / "card.img"), SMALL)
    with Logger(built("nano", folder), card, signals=signals) as logger:
        logger.boot()
        logger.command("start")
        logger.run(SHAKING.duration_s)
        logger.command("stop")
        path = folder / last_session(card.files())
        path.write_bytes(card.read(path.name))
    return path


def through_the_double(signals, folder):
    (folder / "card").mkdir()
    with stand_in(signals, folder / "card") as logger, connect(logger.url) as link:
        name = link.start()
        logger.wait(SHAKING.duration_s)
        link.stop()
    return folder / "card" / name


@pytest.mark.parametrize("record", [through_the_firmware, through_the_double])
def test_all_eight_inputs_of_the_logger_come_out_right(record, tmp_path):
    sensors = tuple(
        Sensor(name, gain_m_s2_per_code=0.48 + 0.01 * k, rest_code=531.3 + k, corner_hz=44 + 2 * k)
        for k, name in enumerate(NAMES)
    )
    rig = Rig(sensors, SHAKING)
    log = read_log(record(rig.signals(), tmp_path)).recording()
    found = compare_with_reference(rig.reference(np.random.default_rng(0)), log, CONDITIONS)
    assert found.findings == ()
    assert found.drift_ppm.value == pytest.approx(0, abs=5)
    delays = np.array([delay_at_10_hz(sensor) for sensor in sensors])
    for sensor, channel, delay in zip(sensors, found.channels, delays, strict=True):
        truth = gain_at_10_hz(sensor)
        assert abs(channel.sensitivity.value - truth) < channel.sensitivity.expanded
        assert channel.sensitivity.relative < 0.005
        assert channel.delay_s.value == pytest.approx(delay, abs=50e-6)
        assert channel.offset.value == pytest.approx(sensor.rest_code - 0.5, abs=0.3)
