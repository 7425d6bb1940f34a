"""ISO 8608 both ways: a road's own profile tells the numbers it was made of; files read back."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from wheelhop.campaign import CampaignError, TrackSpec
from wheelhop.cli.main import main
from wheelhop.track import make_track
from wheelhop.track.opencrg import read_opencrg
from wheelhop.track.roughness import density, roughness
from wheelhop.track.write import write_opencrg, write_paths

STEP_M = 0.05
BELGIAN_BLOCK = Path(__file__).parents[1] / "data/belgian-block/belgian_block.crg"


def profile(unevenness, waviness, seed=1, step_m=STEP_M):
    values = {"unevenness_m3": unevenness, "waviness": waviness, "seed": float(seed)}
    road = make_track(TrackSpec("iso8608", values))
    x = np.arange(0.0, 1000.0, step_m)
    # Paths 20 m apart have little in common: sixteen of them, as in the thesis.
    return np.stack([road.elevation(x, 20.0 * path) for path in range(16)], axis=1)


@pytest.mark.parametrize("step_m", [0.02, 0.05])
def test_the_pave_of_the_thesis_is_recovered_from_its_own_profile(step_m):
    found = roughness(profile(6.7e-4, 1.36, step_m=step_m), step_m)  # table 4.8
    assert found.unevenness_m3 == pytest.approx(6.7e-4, rel=0.1)
    assert found.waviness == pytest.approx(1.36, abs=0.05)
    assert found.road_class == "F"


def test_a_coarse_survey_takes_short_waves_for_long_ones():
    """Stations 0.15 m apart, as in the thesis: what is shorter than 0.3 m is folded."""
    found = roughness(profile(6.7e-4, 1.36, step_m=0.15), 0.15)
    assert 1.25 < found.waviness < 1.33


@pytest.mark.parametrize("number", range(8))
def test_classes_are_those_of_the_standard(number):
    found = roughness(profile(1e-6 * 4.0**number, 2.0), STEP_M)
    assert found.road_class == "ABCDEFGH"[number]
    assert found.waviness == pytest.approx(2.0, abs=0.1)


def test_a_sine_has_its_variance_in_the_density():
    x = np.arange(0.0, 400.0, STEP_M)
    wave, power = density(0.01 * np.sin(2.0 * x)[:, None], STEP_M)
    assert np.sum(power) * (wave[1] - wave[0]) == pytest.approx(0.01**2 / 2, rel=0.02)
    assert wave[np.argmax(power)] == pytest.approx(2.0, abs=wave[1])


@given(st.integers(2, 40), st.integers(2, 9), st.floats(0.01, 2.0), st.integers(0, 99))
def test_a_grid_reads_back_to_the_last_bit(n, k, step, seed):
    from tempfile import TemporaryDirectory

    rng = np.random.default_rng(seed)
    height = rng.normal(size=(n, k))
    height[rng.random((n, k)) < 0.1] = np.nan
    u, v = 3.0 + step * np.arange(n), -1.0 + 0.25 * np.arange(k)
    with TemporaryDirectory() as folder:
        write_opencrg(Path(folder) / "road.crg", u, v, height)
        grid = read_opencrg(Path(folder) / "road.crg")
    np.testing.assert_array_equal(grid.height_m, height)
    np.testing.assert_allclose(grid.u_m, u, rtol=1e-9)
    np.testing.assert_allclose(grid.v_m, v, atol=1e-9)


def test_paths_read_back(tmp_path):
    x = np.array([0.0, 0.5, 0.7, 2.0])
    left, right = np.array([0.0, 0.01, 0.02, 0.0]), np.array([0.0, -0.01, 0.0, 0.03])
    write_paths(tmp_path / "road.csv", x, left, right)
    track = make_track(TrackSpec("profile", {"file": str(tmp_path / "road.csv")}))
    assert track.elevation(x, 0.6) == pytest.approx(left)
    assert track.elevation(x, -0.6) == pytest.approx(right)


def test_an_uneven_grid_is_one_line(tmp_path):
    with pytest.raises(CampaignError, match="equal steps"):
        write_opencrg(tmp_path / "x.crg", np.array([0.0, 1, 3]), np.arange(2.0), np.zeros((3, 2)))
    assert list(tmp_path.iterdir()) == []


def test_the_command_analyses_a_measured_road_and_writes_it(tmp_path, capsys):
    words = ["road", f"profile:file={BELGIAN_BLOCK}", "--step", "0.02", "--width", "1.2"]
    words += ["--out", str(tmp_path / "new.crg")]
    assert main(words) == 0
    first = capsys.readouterr().out
    assert "class" in first and "mm rms" in first
    grid = read_opencrg(tmp_path / "new.crg")
    old = read_opencrg(BELGIAN_BLOCK)
    column = int(np.argmin(np.abs(old.v_m)))
    middle = grid.height_m[:, int(np.argmin(np.abs(grid.v_m)))]
    assert np.corrcoef(middle, old.height_m[::2, column][: len(middle)])[0, 1] > 0.999


MISTAKES = {
    "no such format": (["--out", "x.txt"], ".csv, .crg, .rdf"),
    "no length": (["--length", "0"], "--length 0"),
    "too short": (["--length", "0.1"], "64"),
    "no width": (["--width", "nan"], "--width nan"),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_a_mistake_is_one_line(case, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words, complaint = MISTAKES[case]
    assert main(["road", "belgian-pave/thesis", *words]) == 2
    error = capsys.readouterr().err
    assert complaint in error and error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("track", "words", "said"),
    [
        ("flat", [], "no unevenness"),
        ("iso8608:unevenness_m3=1e300:waviness=2:seed=1", [], "is higher than 100 m"),
        ("iso8608:unevenness_m3=1e-4:waviness=1e300:seed=1", [], "is higher than 100 m"),
        ("washboard/low", ["--length", "1", "--step", "0.001"], "too short for a spectrum"),
        ("half-sine-bump/thesis", ["--step", "0.01"], "too short for a spectrum"),
    ],
)
def test_ground_without_a_spectrum_is_a_line(track, words, said, capsys):
    assert main(["road", track, *words]) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"wheelhop: {track}: ") and said in error and error.count("\n") == 1


def test_a_grid_without_a_column_between_the_wheels_is_read_where_they_run(tmp_path, capsys):
    x = 0.02 * np.arange(500)
    lines = [
        f"{a:.2f},{z:.6f},{z:.6f}" for a, z in zip(x, 0.01 * np.cos(4 * np.pi * x), strict=True)
    ]
    (tmp_path / "grid.csv").write_text("\n".join(["x_m,-1,1", *lines]) + "\n")
    assert main(["road", f"profile:file={tmp_path / 'grid.csv'}"]) == 0
    assert "7.07 mm rms" in capsys.readouterr().out  # 10 mm over √2
