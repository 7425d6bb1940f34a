"""A file that the real firmware has written, on a simulated board, and the card it lies on."""

import numpy as np

from tests.firmware.promises.conftest import card, elf, logger  # noqa: F401
from tests.firmware.promises.logger import last_session
from wheelhop.hil_sim import ramp
from wheelhop.logger import describe, read_log, recover

SIGNALS = ramp(200.5, [20 + k for k in range(8)], seconds=30.0)


def test_the_firmwares_file_holds_what_the_specification_says(logger, card, tmp_path):  # noqa: F811
    one = logger(card, signals=SIGNALS)
    for _ in range(2):
        assert one.command("start").ok
        one.run(3.0)
        assert one.command("stop").ok
    expected = one.log()
    file = tmp_path / last_session(card.files())
    file.write_bytes(card.read(file.name))

    log = read_log(file)
    recording = log.recording()
    said = {key: value for key, value in expected.header.items() if value}
    ends = {key: value for key, value in (expected.summary or {}).items() if value}
    assert (log.session, log.header, log.summary) == (expected.session, said, ends)
    assert log.damage == () and log.missing == 0
    sums = np.array([expected.scans[i] for i in range(len(expected.scans))])
    assert np.array_equal(recording.values * 8, sums)
    # SPEC.md, "Scans": the mean instant of a scan; the ramp tells time.
    slopes = np.polynomial.polynomial.polyfit(recording.time_s, recording.values, 1)[1]
    assert np.allclose(slopes, [20 + k for k in range(8)], rtol=2e-3)
    assert f"{len(sums)} due, {len(sums)} written, 0 missing" in describe(log)

    found = list(recover(card.path, tmp_path / "recovered"))
    assert len(found) == 2 and all(session.complete for session in found)
    assert found[1].path.read_bytes() == file.read_bytes()
