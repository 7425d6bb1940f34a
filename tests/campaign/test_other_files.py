"""Runs that are the logger's own files, or another recorder's, in a campaign folder."""

import numpy as np
import pytest

from tests.campaign.build import POINTS, edit, write_campaign
from tests.logger.session import NAMES, session
from wheelhop.calibration import nominal_constants, write_constants
from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.files.units import STANDARD_GRAVITY_M_S2
from wheelhop.formats import write
from wheelhop.logger.recording import Channel, Recording

CODES_PER_G = 57e-3 / 3.0 * 1024


@pytest.fixture
def folder(tmp_path):
    return write_campaign(tmp_path / "c")


def replace_slow(folder, suffix):
    (folder / "runs/slow.csv").unlink()
    edit(folder / "campaign.toml", "slow.csv", f"slow{suffix}")
    return folder / f"runs/slow{suffix}"


def slow_sines(amplitude_code=60.0, hz=2.0, rows=600):
    """Far below the sensors' corner, so that what they take away is known to be small."""
    code = 531.0 + amplitude_code * np.sin(2 * np.pi * hz * np.arange(rows) / 100)
    return np.repeat(np.round(8 * code).astype(int)[:, None], 8, axis=1)


def test_a_log_of_codes_with_its_constants_is_in_m_s2(folder):
    log = session(slow_sines(), calibration="", device=0, clock_ppm="", close=False)
    replace_slow(folder, ".hop").write_bytes(log)
    write_constants(nominal_constants(NAMES), folder / "calibration.toml")
    campaign = read_campaign(folder)
    slow, fast = campaign.runs  # the other one is a csv, in m/s² already
    wanted = 60.0 / CODES_PER_G * STANDARD_GRAVITY_M_S2
    assert np.allclose(slow.record.std(axis=0) * np.sqrt(2), wanted, rtol=0.01)
    assert fast.record.shape[1] == len(campaign.channels) == 8


def test_a_log_without_constants_says_what_to_do(folder):
    log = session(slow_sines(), calibration="", device=0, clock_ppm="", close=False)
    replace_slow(folder, ".hop").write_bytes(log)
    with pytest.raises(CampaignError, match=r"slow\.hop: holds codes.*copy the one of this logger"):
        read_campaign(folder)


def test_a_log_with_a_gap_says_where(folder):
    log = session(
        slow_sines(), lost=range(200, 220), calibration="", device=0, clock_ppm="", close=False
    )
    replace_slow(folder, ".hop").write_bytes(log)
    write_constants(nominal_constants(NAMES), folder / "calibration.toml")
    with pytest.raises(CampaignError, match=r"slow\.hop: row 201: .* is nan; cut the run"):
        read_campaign(folder)


@pytest.mark.parametrize("constants", [False, True])
def test_another_recorder_s_mf4_is_taken_as_it_is(folder, constants):
    values = np.random.default_rng(0).normal(size=(500, 8))
    channels = tuple(Channel(name, "m/s²") for name in POINTS)
    write(Recording(values, 100.0, channels), replace_slow(folder, ".mf4"))
    if constants:
        write_constants(nominal_constants(POINTS), folder / "calibration.toml")
    assert np.array_equal(read_campaign(folder).runs[0].record, values)


@pytest.mark.parametrize("unit", ["mm", "V", "deg/s", "code"])
def test_a_recording_that_says_another_unit_is_not_taken_for_accelerations(folder, unit):
    values = np.random.default_rng(0).normal(size=(500, 8))
    channels = tuple(Channel(name, unit if name == "A1" else "m/s²") for name in POINTS)
    write(Recording(values, 100.0, channels), replace_slow(folder, ".mf4"))
    with pytest.raises(CampaignError, match=r"slow\.mf4: ") as caught:
        read_campaign(folder)
    assert unit == "code" or "A1 is in" in str(caught.value)


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_what_is_said_beside_the_samples_counts(folder, suffix):
    """Codes that convert has written as CSV or Parquet say so in their header."""
    values = np.random.default_rng(0).normal(512.0, 9.0, size=(500, 8))
    channels = tuple(Channel(name, "code") for name in POINTS)
    write(Recording(values, 100.0, channels), replace_slow(folder, suffix))
    with pytest.raises(CampaignError, match=r"slow\.\w+: .* is in code"):
        read_campaign(folder)


@pytest.mark.parametrize("name", ["acc [g]", "acc (mg)", "acc_g", "pot [mm]", "pot [%]"])
def test_a_column_whose_name_says_another_unit_is_no_acceleration(folder, name):
    for file in folder.glob("runs/*.csv"):
        file.write_text(file.read_text().replace("A1", name, 1))
    points = {name if point == "A1" else point: point for point in POINTS}
    table = "".join(f'"{column}" = "{point}"\n' for column, point in points.items())
    text = (folder / "campaign.toml").read_text()
    (folder / "campaign.toml").write_text(
        text.replace("[[run]]", f"[channels]\n{table}\n[[run]]", 1)
    )
    with pytest.raises(CampaignError, match=r"slow\.csv: column .* campaign takes m/s²"):
        read_campaign(folder)
