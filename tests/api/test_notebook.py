"""The 25 tasks of docs/notebook.md: each is done in three lines, and does what it says."""

import re
from pathlib import Path

import control
import numpy as np
import openpyxl
import pandas as pd
import pytest
import scipy.io
import scipy.signal
from matplotlib.figure import Figure

import wheelhop as wh
from tests.report.small import write_small_campaign
from wheelhop.effects import Amplitude, law
from wheelhop.vehicle import ends, struts

PAGE = (Path(__file__).parents[2] / "docs/notebook.md").read_text(encoding="utf-8")
TASKS = {
    int(number): code
    for number, code in re.findall(r"^\*\*(\d+)\. .*?```python\n(.*?)```", PAGE, re.M | re.S)
}


@law
def orifice(x, v, dx, dt, z, p):
    return p[0] * v * abs(v), z


class OrificeDamper(wh.Effect):
    """A force proportional to velocity squared."""

    id, place = "orifice-damper", "suspension"
    title, equation, source = "turbulent flow", r"f = c_2 |\dot x| \dot x", "Bernoulli"

    def parameters_for(self, vehicle, channels):
        return tuple(
            Amplitude(f"{end}_N_s2_m2", "N·s²/m²", end, scale=strut.usual.damping_N_s_m, lower=0.0)
            for end, strut in ends(vehicle).items()
        )

    def modify(self, theta, vehicle, parts):
        for strut in struts(vehicle):
            parts.add_law(strut.row, orifice, (theta[f"{strut.end}_N_s2_m2"],))


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    """What the tasks have made, one after the other in one notebook."""
    folder = tmp_path_factory.mktemp("notebook")
    for name in ("my-campaign", "another-day"):
        write_small_campaign(folder / name)
    names = {"wh": wh, "np": np, "pd": pd, "scipy": scipy, "control": control}
    names["OrificeDamper"] = OrificeDamper
    names["strut"] = ["suspension.front.stiffness_N_m", "suspension.front.damping_N_s_m"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for number, code in TASKS.items():
            exec(compile(code, f"task {number}", "exec"), names)
    return {**names, "folder": folder}


def test_there_are_25_tasks_of_three_lines():
    assert list(TASKS) == list(range(1, 26))
    assert max(len(code.splitlines()) for code in TASKS.values()) <= 3


def test_a_campaign_is_looked_at(done):
    assert done["count"] == len(done["table"]) == 5 and done["known"]
    assert {run.track.kind for run in done["washboards"]} == {"washboard"}
    assert done["held_out"] == ["washboard-low-fast", "washboard-high-slow"]
    assert [c.name for c in done["body"].channels] == ["B1", "B2", "B3", "B4", "A1", "A2"]
    assert done["samples"].index.name == "time_s" and "B2_m_s2" in done["samples"]


def test_signals_are_those_of_the_record_in_band(done):
    record = done["campaign"].recording("washboard-low-fast")["B2"]
    np.testing.assert_allclose(done["residual"], done["measured"] - done["model"], atol=1e-9)
    assert np.corrcoef(record, done["measured"])[0, 1] > 0.99
    left = np.sum(done["residual"] ** 2) / np.sum(done["measured"] ** 2)
    table = done["fitted"].residuals("run").loc[("washboard-low-fast", "B2")]
    assert np.sqrt(left) == pytest.approx(table["error"], rel=1e-9)
    assert len(done["time_s"]) == len(record) and isinstance(done["figure"], Figure)


def test_spectra_hold_the_power_of_the_signals(done):
    power = done["psd"]["measured"]["B2_m_s2_2_Hz"]
    step = power.index[1] - power.index[0]
    assert power.sum() * step == pytest.approx(done["measured"].var(), rel=0.1)
    for frf in (done["measured_frf"], done["model_frf"]):
        assert frf["coherence"].between(0, 1 + 1e-9).all() and np.iscomplexobj(frf["response"])
    at = done["measured_frf"].index.get_indexer([6.25], method="nearest")  # the track's waves
    ratio = (done["measured_frf"]["response"] / done["model_frf"]["response"]).iloc[at]
    np.testing.assert_allclose(ratio, 1.0, atol=0.02)
    assert (done["worst"] < 3).all()


def test_numbers_have_their_uncertainty(done):
    np.testing.assert_allclose(np.diag(done["correlation"]), 1.0)
    assert done["pairs"].between(0.0, 1.0 + 1e-9).all()
    assert max(done["scatter"]) < 3 * done["fitted"].error
    assert done["stiffer"].error_fit > done["fitted"].last.rung.error_fit


def test_physics_of_ones_own_takes_part(done):
    assert list(done["force"].index) == [
        "orifice-damper.front_N_s2_m2",
        "orifice-damper.rear_N_s2_m2",
    ]
    assert 0.0 < done["left"] < 2.0
    assert done["verdict"] == ("dry-friction",) and done["ranking"].index[0] == "dry-friction"


def test_what_is_kept_is_what_was_there(done):
    pd.testing.assert_frame_equal(done["again"].parameters(), done["fitted"].parameters())
    assert done["softer"].error_fit > done["fitted"].last.rung.error_fit
    assert done["kept"].values == pytest.approx(done["fitted"].model.values)
    assert done["foreseen"].error_validate == pytest.approx(done["fitted"].error, rel=0.02)
    assert done["numbers"]["format"] == 1 and (done["folder"] / "report.html").stat().st_size > 1e4


def test_other_programs_read_it(done):
    book = openpyxl.load_workbook(done["folder"] / "result.xlsx", read_only=True)
    assert book.sheetnames == ["numbers", "modelled"]
    mat = scipy.io.loadmat(done["folder"] / "run.mat")
    np.testing.assert_allclose(mat["B2_m_s2"].ravel(), done["model"])
    omega = 2 * np.pi * done["model_frf"].index[3]
    assert done["plant"](1j * omega) == pytest.approx(done["model_frf"]["response"].iloc[3])
    assert done["dataset"]["B2"].attrs["units"] == "m/s²"
    np.testing.assert_array_equal(done["dataset"]["B2"], done["residual"])
    assert isinstance(done["drawing"], Figure)
