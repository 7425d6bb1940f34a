"""From rig to wheel: closed forms, the thesis's table, and files that are no rig's."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wheelhop.campaign.sample import VEHICLE
from wheelhop.cli.main import main
from wheelhop.vehicle import read_vehicle
from wheelhop.vehicle.rates import wheel_rates
from wheelhop.vehicle.rewrite import rewrite_vehicle

EXAMPLES = Path(__file__).parents[2] / "examples/rig"


def curve(file: Path, heading: str, *columns: Any) -> Path:
    rows = [",".join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    file.write_text("\n".join([heading, *rows]) + "\n")
    return file


@pytest.fixture
def straight(tmp_path: Path) -> tuple[Path, Path]:
    """Front strut and damper of table 4.1, straight lines."""
    x, v = np.linspace(-50, 50, 21), np.linspace(-500, 500, 11)
    strut = curve(tmp_path / "strut.csv", "displacement_mm,force_N", x, 800 + 25 * x)
    damper = curve(tmp_path / "damper.csv", "velocity_mm_s,force_N", v, 1.5 * v)
    return strut, damper


def test_table_4_1(straight: tuple[Path, Path]) -> None:
    """25 N/mm and 1.50 N s/mm at the strut are 10.5 N/mm and 0.63 N s/mm at the wheel."""
    found = wheel_rates(*straight, 0.648)
    assert found.strut.stiffness.value == pytest.approx(25e3)
    assert found.stiffness_N_m == pytest.approx(10.5e3, rel=2e-3)
    assert found.damping_N_s_m == pytest.approx(630.0, rel=2e-3)
    # Force and travel of the rig to 1 %, and the motion ratio, which is squared.
    assert found.stiffness_uncertainty_N_m == pytest.approx(0.01 * np.sqrt(5) * 10.5e3, rel=0.01)


@pytest.mark.parametrize(
    ("axle", "stiffness", "damping"), [("front", 10.5e3, 630.0), ("rear", 6.5e3, 590.0)]
)
def test_the_examples_hold_table_4_1_within_what_they_say(
    axle: str, stiffness: float, damping: float
) -> None:
    files = [EXAMPLES / f"{axle}-{what}.csv" for what in ("strut", "damper", "linkage")]
    found = wheel_rates(*files, ride_m=0.05)
    away = abs(found.stiffness_N_m - found.from_linkage_N_m - stiffness)
    assert away < found.stiffness_uncertainty_N_m < 0.1 * stiffness
    assert abs(found.damping_N_s_m - damping) < found.damping_uncertainty_N_s_m < 0.1 * damping


def test_a_wheel_rate_is_the_derivative_of_the_wheel_s_force(tmp_path: Path) -> None:
    """A linkage s = 0.6 z + 2 z² under a strut 900 N + 20 N/mm · s: the force at the wheel is
    F(s) s′, and its derivative is taken by differences."""

    def wheel_force(z: float) -> float:
        return (900 + 20e3 * (0.6 * z + 2 * z**2)) * (0.6 + 4 * z)

    z, x = np.linspace(-0.06, 0.06, 25), np.linspace(-0.05, 0.05, 21)
    linkage = curve(tmp_path / "l.csv", "wheel_travel_m,strut_travel_m", z, 0.6 * z + 2 * z**2)
    strut = curve(tmp_path / "s.csv", "displacement_m,force_kN", x, 0.9 + 20 * x)
    damper = curve(tmp_path / "d.csv", "velocity_m_s,force_N", 10 * x, 1000 * x)
    found = wheel_rates(strut, damper, linkage, ride_m=0.0)
    by_differences = (wheel_force(1e-6) - wheel_force(-1e-6)) / 2e-6
    assert found.stiffness_N_m == pytest.approx(by_differences, rel=1e-5)
    ratio = curve(tmp_path / "r.csv", "wheel_travel_mm,motion_ratio", 1e3 * z, 0.6 + 4 * z)
    other = wheel_rates(strut, damper, ratio, ride_m=0.0)
    assert other.stiffness_N_m == pytest.approx(by_differences, rel=1e-5)


def test_a_loop_shows_stiffness_and_friction(tmp_path: Path, straight: Any) -> None:
    turn = np.linspace(0, 6 * np.pi, 400)
    x = 20 * np.sin(turn)
    force = 500 + 15 * x + 40 * np.sign(np.cos(turn))
    loop = curve(tmp_path / "loop.csv", "displacement_mm,force_N", x, force)
    found = wheel_rates(loop, straight[1], 0.7, ride_m=0.0)
    assert found.strut.stiffness.value == pytest.approx(15e3, rel=5e-3)
    assert found.strut.friction_N == pytest.approx(40.0, rel=0.05)
    assert found.strut.ride_force_N == pytest.approx(500.0, rel=5e-3)


def test_uncertainty_covers_noise_and_bend(tmp_path: Path, straight: Any) -> None:
    """Of a straight line with noise, σ/√Σx²; of F = k x + b x² over ± X, the slope's own rms
    change, 2 b X/√3, which vanishes with the travel asked for; of k x + c x³, √0.96 c X² about a
    slope of k + 0.6 c X²."""
    rng = np.random.default_rng(2)
    x = np.linspace(-40, 40, 401)
    noisy = curve(tmp_path / "n.csv", "displacement_mm,force_N", x,
                  20 * x + 10 * rng.normal(size=x.size))  # fmt: skip
    found = wheel_rates(noisy, straight[1], 1.0).strut.stiffness
    assert found.scatter == pytest.approx(1e3 * 10 / np.sqrt((x**2).sum()), rel=0.15)
    bent = curve(tmp_path / "b.csv", "displacement_mm,force_N", x, 20 * x + 0.1 * x**2)
    whole = wheel_rates(bent, straight[1], 1.0)
    assert whole.strut.stiffness.bend == pytest.approx(1e3 * 0.2 * 40 / np.sqrt(3), rel=0.02)
    cubic = curve(tmp_path / "c.csv", "displacement_mm,force_N", x, 20 * x + 0.002 * x**3)
    third = wheel_rates(cubic, straight[1], 1.0).strut.stiffness
    assert third.value == pytest.approx(1e3 * (20 + 0.6 * 0.002 * 1600), rel=0.01)
    assert third.bend == pytest.approx(1e3 * np.sqrt(0.96) * 0.002 * 1600, rel=0.02)
    little = wheel_rates(bent, straight[1], 1.0, travel_m=0.004)
    assert little.strut.stiffness.bend == pytest.approx(whole.strut.stiffness.bend / 10, rel=0.1)


def test_a_damper_s_two_sides(tmp_path: Path, straight: Any) -> None:
    v = np.linspace(-400, 400, 41)
    force = 30 + np.where(v > 0, 0.8, 1.6) * v
    chart = curve(tmp_path / "d.csv", "velocity_mm_s,force_N", v, force)
    found = wheel_rates(straight[0], chart, 1.0).damper
    assert found.compression_N_s_m < found.damping.value < found.rebound_N_s_m
    assert found.damping.value == pytest.approx(1200.0, rel=0.02)
    assert found.damping.uncertainty > 200.0


def test_numbers_go_into_a_vehicle_and_nothing_else_changes(
    tmp_path: Path, straight: Any, capsys: Any
) -> None:
    file = tmp_path / "vehicle.toml"
    file.write_text(VEHICLE.format(title='"mine"'))
    before = file.read_text().splitlines()
    words = ["rates", *map(str, straight), "--motion-ratio", "0.648", "--axle", "front"]
    out = tmp_path / "rates.json"
    assert main([*words, "--into", str(file), "--json", str(out)]) == 0
    assert "10.5" in capsys.readouterr().out
    after = file.read_text().splitlines()
    gone = [line for line in before if line not in after]
    new = [line for line in after if line not in before]
    assert [line.split()[0] for line in gone] == ["stiffness_N_m", "damping_N_s_m"]
    assert {line.split()[0].removesuffix("_uncertainty") for line in new} == {
        "stiffness_N_m",
        "damping_N_s_m",
    }
    assert all("sample" not in line for line in new)
    vehicle, wheel = read_vehicle(file), json.loads(out.read_text())["wheel"]
    for key in ("stiffness_N_m", "damping_N_s_m"):
        assert vehicle[f"suspension.front.{key}"] == pytest.approx(wheel[key], rel=1e-3)


def test_a_vehicle_stays_as_it_was_if_a_number_cannot_be(tmp_path: Path) -> None:
    from wheelhop.campaign import CampaignError

    file = tmp_path / "vehicle.toml"
    file.write_text(VEHICLE.format(title='"mine"'))
    before = file.read_bytes()
    with pytest.raises(CampaignError, match=r"vehicle\.toml.*stiffness_N_m"):
        rewrite_vehicle(file, {"suspension.front.stiffness_N_m": (-5.0, 1.0)}, "nowhere")
    assert file.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["vehicle.toml"]


BAD = {
    "displacement_mm,force_N\n1,2\n2,x\n": 'line 3: force_N: "x" is not a number',
    "displacement_mm,force_N\n1,2,3\n": "line 2: 3 values under 2 columns",
    "displacement_in,force_N\n1,2\n": 'column "displacement_in" is not known',
    "displacement_mm,displacement_m\n1,2\n": "one column each",
    "displacement_mm,force_N\n1,2\n2,3\n": "2 points are too few",
    "": "one column each",
    "displacement_mm,force_N\n1,5\n2,4\n3,3\n4,2\n5,1\n": "the force falls",
    "displacement_mm,force_N\n1,1\n1,1\n1,1\n1,1\n1,1\n": "ride height",
}


@pytest.mark.parametrize("text", BAD)
def test_a_file_that_is_no_strut_is_one_line(
    text: str, tmp_path: Path, straight: Any, capsys: Any
) -> None:
    strut = tmp_path / "bad.csv"
    strut.write_text(text)
    assert main(["rates", str(strut), str(straight[1]), "--motion-ratio", "0.65"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert "bad.csv" in lines[0]
    assert BAD[text] in lines[0]


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--motion-ratio", "0.65", "--travel", "-3"], "--travel -3"),
        (["--motion-ratio", "0.65", "--ride", "900"], "ride height at 900 mm"),
        (["--motion-ratio", "nan"], "motion ratio nan"),
        (["--motion-ratio", "65"], "in the same unit"),
        (["--motion-ratio", "no-such.csv"], "no-such.csv: no such file"),
        (["--motion-ratio", "0.65", "--axle", "front"], "--into and --axle go together"),
    ],
)
def test_what_makes_no_sense_is_one_line(
    words: list[str], reason: str, straight: Any, capsys: Any
) -> None:
    assert main(["rates", *map(str, straight), *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert reason in lines[0]


def test_the_figure_has_the_numbers_in_its_titles(straight: Any) -> None:
    from wheelhop.report.rates import rates_figure

    figure = rates_figure(wheel_rates(*straight, EXAMPLES / "front-linkage.csv"))
    assert [axes.get_title(loc="left") for axes in figure.axes] == [
        "strut: 25 N/mm",
        "damper: 1.5 N s/mm",
        "motion ratio: 0.648",
    ]
