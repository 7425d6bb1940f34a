"""The real firmware on the simulated board, on the beam: its eight channels are in step."""

from dataclasses import replace

import numpy as np

from tests.calibration.test_sync_planted import ruler
from tests.firmware.promises.conftest import SMALL, built
from tests.firmware.promises.logger import Logger, configure, last_session
from wheelhop.calibration.sync.check import check_synchronicity
from wheelhop.hil_sim import CardImage
from wheelhop.hil_sim.beam_rig import BeamRig
from wheelhop.logger import read_log

SECONDS = 12.0
NAMES = ("B1", "B2", "B3", "B4", "A1", "A2", "A3", "A4")


def test_the_real_logger_shows_no_skew(tmp_path):
    elf = built("nano", tmp_path)
    positions = tuple(np.linspace(0.25, 0.98, 8) * 0.6096)
    session = replace(ruler(positions, (15.0, 34.0)), channels=NAMES)
    signals = BeamRig(session, (0.5, 0.5)).signals(SECONDS)
    card = configure(CardImage.fat32(tmp_path / "card.img"), SMALL)
    with Logger(elf, card, signals=signals) as logger:
        logger.boot()
        logger.command("start")
        logger.run(SECONDS - 1.5)
        logger.command("stop")
        path = tmp_path / last_session(card.files())
        path.write_bytes(card.read(path.name))
    check = check_synchronicity(read_log(path).recording(), session)
    assert check.passed and check.ramp_s == 0.0
    skews = np.array([channel.skew_s for channel in check.channels])
    assert np.abs(skews).max() < 15e-6
