"""A component on a mount whose modulus is known, made by the discrete Fourier transform of the
exact modulus: no code and no approximation is shared."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy import signal

from wheelhop.campaign import CampaignError, read_campaign
from wheelhop.diagnose import diagnose
from wheelhop.effects import load_effects
from wheelhop.material import read_specimen
from wheelhop.vehicle import mounted, read_nominal

EXAMPLES = Path(__file__).parents[2] / "examples/bushings"
RATE_HZ = 256.0
STIFFNESS, DAMPING = 20000.0, 1500.0
NOISE_N = 5.0  # of some hundred newtons
MOUNTS = 8.0  # a mount eight times as soft as the specimen
CAMPAIGN = """
format = 1
kind = "component"
title = "strut on its mount"
sample_rate_hz = 256.0
band_hz = [0.5, 40.0]
drive = "displacement"
noise_rms_N = {noise}

[component]
mass_kg = 0.0
stiffness_N_m = 21000.0
damping_N_s_m = 1400.0
relative_uncertainty = 0.2
{mount}
"""


def strut_force(x, share):
    """Force (n,) of the strut in series with the specimen, at rest before and after."""
    specimen = read_specimen(EXAMPLES / "bushing-2-specimen-1.toml")
    n = 16 * len(x)
    omega = 2 * np.pi * np.fft.rfftfreq(n, 1 / RATE_HZ)
    strut = STIFFNESS + 1j * omega * DAMPING
    mount = specimen.modulus(np.maximum(omega, 2 * np.pi * 1e-3))
    return np.fft.irfft(np.fft.rfft(x, n) * strut * mount / (mount + share * strut), n)[: len(x)]


def make(folder, share, mount='mount = "specimen.toml"'):
    """Three runs of random motion within 0.5 to 40 Hz, the last held out."""
    (folder / "runs").mkdir(parents=True)
    shutil.copy(EXAMPLES / "bushing-2-specimen-1.toml", folder / "specimen.toml")
    text = CAMPAIGN.format(mount=mount, noise=NOISE_N * np.sqrt((40.0 - 0.5) / (RATE_HZ / 2)))
    rng = np.random.default_rng(5)
    low_pass = signal.butter(4, [0.5, 40.0], "bandpass", fs=RATE_HZ, output="sos")
    for i, role in enumerate(("fit", "fit", "validate")):
        x = signal.sosfiltfilt(low_pass, rng.normal(0.0, 0.004, 2048))
        x *= signal.windows.tukey(len(x), 0.3)
        force = strut_force(x, share)
        force += rng.normal(0.0, NOISE_N, len(x))
        rows = zip(np.arange(len(x)) / RATE_HZ, x, force, strict=True)
        lines = "\n".join(f"{t!r},{a!r},{f!r}" for t, a, f in (map(float, row) for row in rows))
        (folder / f"runs/{i}.csv").write_text(f"time_s,displacement_m,force_N\n{lines}\n")
        text += f'\n[[run]]\nid = "r{i}"\nfile = "runs/{i}.csv"\nrole = "{role}"\n'
    (folder / "campaign.toml").write_text(text)
    return read_campaign(folder)


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory):
    campaign = make(tmp_path_factory.mktemp("mount") / "c", MOUNTS)
    return diagnose(campaign, read_nominal(campaign), load_effects(), jobs=1)


def test_a_mount_that_is_known_is_recovered(diagnosis):
    assert diagnosis.verdict == ("mount-bushing",)
    value, interval = diagnosis.ladder[-1].parameters["mount-bushing.strut_mounts"]
    assert value == pytest.approx(MOUNTS, rel=0.03)
    assert interval < 0.5
    numbers = diagnosis.ladder[-1].rung.model.values
    assert numbers["component.stiffness_N_m"] == pytest.approx(STIFFNESS, rel=0.02)
    assert numbers["component.damping_N_s_m"] == pytest.approx(DAMPING, rel=0.02)


def test_where_there_is_no_mount_none_is_found(tmp_path):
    campaign = make(tmp_path / "c", 0.0)
    assert diagnose(campaign, read_nominal(campaign), load_effects(), jobs=1).verdict == ("none",)


def test_the_specimen_is_among_the_numbers_and_certain(tmp_path):
    nominal = read_nominal(make(tmp_path / "c", MOUNTS))
    specimen = read_specimen(EXAMPLES / "bushing-2-specimen-1.toml")
    omega = 2 * np.pi * np.geomspace(0.1, 50.0, 99)
    ratio = mounted(nominal.values).modulus(omega) / specimen.modulus(omega)
    assert np.abs(ratio - 1).max() < 0.0025
    assert not any(nominal.uncertainty[key] for key in nominal.values if key.startswith("mount."))


@pytest.mark.parametrize(
    "mount, says",
    [
        ('mount = "nowhere.toml"', "no such file"),
        ('mount = "../specimen.toml"', "leads out of the campaign folder"),
        ("mount = 3", "mount must be"),
        ('mout = "specimen.toml"', "did you mean 'mount'"),
    ],
)
def test_a_mount_that_cannot_be_read_is_one_line(tmp_path, mount, says):
    with pytest.raises(CampaignError, match=says):
        make(tmp_path / "c", MOUNTS, mount)
