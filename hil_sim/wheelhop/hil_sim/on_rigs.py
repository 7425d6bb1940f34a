"""An emulated logger on a calibrator's shaker or on the cantilever, and the files that go with it.

docs/calibration.md and docs/synchronicity.md tell how such a session goes; the shaker's truth is
drawn from a seed that nobody is told.
"""

from importlib.resources import as_file, files
from pathlib import Path

import numpy as np

from wheelhop.calibration.sync.beam_file import read_beam
from wheelhop.files import make_folder, replacing
from wheelhop.formats import write
from wheelhop.hil_sim.beam_rig import BeamRig
from wheelhop.hil_sim.rig import Rig, random_rig
from wheelhop.hil_sim.signals import CHANNELS, Signals
from wheelhop.logger.error import LoggerError

SHAKER, BEAM = "shaker", "beam"
RIGS = (SHAKER, BEAM)
SEED = 1967
RATE_HZ = 3200.0
BEAM_S = 20.0  # of noise, then again; the drive's frequencies come round in it, too
FORCES_N = (0.5, 0.5)
NOISE_CODES = 0.3


def shaker() -> Rig:
    """The shaker with eight sensors on its table."""
    return random_rig(np.random.default_rng(SEED), CHANNELS)


def on_rig(name: str, folder: Path) -> tuple[str, Signals]:
    """What happens in every session on a rig, in words and signals.

    Its files are put into `folder`; those that are there already stay as they are. Raises
    LoggerError where that cannot be.
    """
    make_folder(folder)
    if name == BEAM:
        _put("beam.toml", folder)
        return _on_beam(folder / "beam.toml")
    rig = shaker()
    _put("session.toml", folder)
    reference = folder / "reference.csv"
    if not reference.exists():
        write(rig.reference(np.random.default_rng(SEED + 1)), reference)
    frequencies = ", ".join(f"{frequency:g}" for frequency, _, _ in rig.shaking.steps)
    words = f"the shaker's table, {frequencies} Hz; {reference} is what its reference recorded"
    return words, rig.as_recorded(np.random.default_rng(SEED + 2), RATE_HZ)


def _on_beam(file: Path) -> tuple[str, Signals]:
    session = read_beam(file)
    forces = (FORCES_N * len(session.frequencies_hz))[: len(session.frequencies_hz)]
    signals = BeamRig(session, forces).signals(BEAM_S)
    noise = np.random.default_rng(SEED).normal(0.0, NOISE_CODES, signals.codes.shape)
    frequencies = " and ".join(f"{frequency:g}" for frequency in session.frequencies_hz)
    words = f"the beam of {file}, driven at {frequencies} Hz"
    return words, Signals(signals.codes + noise, signals.rate_hz, repeat=True)


def _put(name: str, folder: Path) -> None:
    target = folder / name
    if target.exists():
        return
    with as_file(files("wheelhop.hil_sim") / "rigs" / name) as shipped:
        text = shipped.read_text(encoding="utf-8")
    with replacing(target, LoggerError) as draft:
        draft.write_text(text, encoding="utf-8")
