"""Planning: information is what a fit would find, and the advised runs tell more."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wheelhop.api import plan
from wheelhop.cli.main import main
from wheelhop.effects import load_effects
from wheelhop.fit import Workshop, fit, vehicle_parameters
from wheelhop.predict import Case, read_drives
from wheelhop.predict.foresee import Foreseen, foresee
from wheelhop.predict.plan import Plan, choose, worth
from wheelhop.vehicle import read_vehicle

VEHICLE = Path("examples/clean/vehicle.toml")
TRACKS = ("washboard/low", "herringbone/high", "chassis-twist/low")
SPEEDS = (7.0, 14.0)
EFFECTS = ("dry-friction", "digressive-damper", "anti-roll-bar")
NOISE = 0.1


@pytest.fixture(scope="module")
def case() -> Case:
    return Case(read_vehicle(VEHICLE), (), read_drives(TRACKS, SPEEDS), 4.0)


@pytest.fixture(scope="module")
def foreseen(case: Case) -> Foreseen:
    library = load_effects()
    return foresee(case, [library[name] for name in EFFECTS], NOISE)


def test_a_fit_is_as_certain_as_was_foreseen(case: Case, foreseen: Foreseen) -> None:
    """Runs with noise, fitted: their uncertainty, and how far the numbers come out from the truth,
    are those of the plan."""
    campaign, model = case.campaign(NOISE)
    rng = np.random.default_rng(1)
    sigma = NOISE / np.sqrt((30.0 - 0.5) / 50.0)  # white up to 50 Hz, this much of it in band
    noisy = tuple(
        replace(run, record=run.record + sigma * rng.normal(size=run.record.shape))
        for run in campaign.runs
    )
    workshop = Workshop(replace(campaign, runs=noisy), model)
    free = vehicle_parameters(campaign, case.vehicle)
    found = fit(workshop, model, free, tuple(workshop.benches.values()))
    whole = choose(foreseen, len(case.drives))
    away = []
    deviation = dict(
        zip([f.name for f in found.shared], np.sqrt(np.diag(found.covariance)), strict=True)
    )
    for name, (_, after) in whole.uncertainty.items():
        assert after == pytest.approx(deviation[name], rel=0.15)
        away.append((found.model.values[name] - case.vehicle[name]) / after)
    assert np.sqrt(np.mean(np.square(away))) < 2.0


def test_a_run_more_never_tells_less(foreseen: Foreseen) -> None:
    advised = choose(foreseen, len(foreseen.drives))
    assert sorted(advised.chosen) == list(range(len(foreseen.drives)))
    numbers, effects = np.array(advised.after).T
    assert (np.diff(numbers) > 0).all()
    assert (np.diff(effects) > 0).all()


def test_the_advised_runs_tell_nearly_as_much_as_the_best(foreseen: Foreseen) -> None:
    """Of all 20 sets of three: greedy choice may miss the best, not by much."""
    from itertools import combinations

    everything = {
        chosen: worth(foreseen, chosen).total
        for chosen in combinations(range(len(foreseen.drives)), 3)
    }
    advised = choose(foreseen, 3).after[-1].total
    assert advised >= 0.97 * max(everything.values())
    assert advised > np.median(list(everything.values()))


def test_a_run_twice_as_noisy_shows_effects_half_as_strong(case: Case, foreseen: Foreseen) -> None:
    """Without priors a limit is proportional to the noise (dᵀI d ~ 1/σ²)."""
    library = load_effects()
    noisier = foresee(case, [library[name] for name in EFFECTS], 2 * NOISE)
    quiet, loud = choose(foreseen, 6), choose(noisier, 6)
    for one, other in zip(quiet.told, loud.told, strict=True):
        assert other.shown_from == pytest.approx(2 * one.shown_from, rel=0.05)


def test_an_effect_that_moves_nothing_is_never_shown() -> None:
    """On a straight washboard both sides rise alike: nothing rolls, an anti-roll bar is idle."""
    straight = plan(VEHICLE, ["washboard/low"], [8.0], runs=1, only=["anti-roll-bar"], seconds=4.0)
    (bar,) = straight.told
    assert bar.shown_from > 1e3
    crooked = plan(
        VEHICLE, ["chassis-twist/low"], [8.0], runs=1, only=["anti-roll-bar"], seconds=4.0
    )
    assert crooked.told[0].shown_from < 1.0


@pytest.fixture
def advised(foreseen: Foreseen) -> Plan:
    return choose(foreseen, 4)


def test_a_skeleton_takes_the_recordings_by_its_own_commands(
    advised: Plan, tmp_path: Path, monkeypatch: Any
) -> None:
    """Each of its commands, run on a recording of that drive, adds it; the campaign then reads."""
    import shlex

    from wheelhop.campaign import read_campaign
    from wheelhop.formats import write
    from wheelhop.predict.instrument import recording
    from wheelhop.predict.plan_files import write_skeleton

    folder = tmp_path / "planned"
    write_skeleton(folder, advised, VEHICLE, NOISE)
    case = Case(read_vehicle(VEHICLE), (), advised.drives, 4.0)
    lines = (folder / "campaign.toml").read_text().splitlines()
    commands = [line.partition(". ")[2] for line in lines if "campaign add" in line]
    assert len(commands) == 4
    for number, command in enumerate(commands):
        file = tmp_path / f"{number}.csv"
        write(recording(case, number, NOISE), file)
        monkeypatch.chdir(folder)
        words = shlex.split(command.replace("RECORDING", str(file)))
        assert main(words[1:]) == 0
    campaign = read_campaign(folder)
    assert [run.id for run in campaign.runs] == [drive.id for drive in advised.drives]
    assert [run.role for run in campaign.runs] == list(advised.roles)
    assert [run.track for run in campaign.runs] == [drive.track for drive in advised.drives]


def test_the_figure_shows_every_run_and_effect(advised: Plan) -> None:
    from wheelhop.report.plan import plan_figure

    figure = plan_figure(advised)
    above, below = figure.axes
    assert [t.get_text() for t in above.get_yticklabels()] == list(TRACKS)
    assert {t.get_text() for t in below.get_yticklabels()} == set(EFFECTS)
    assert {"1", "2", "3", "4"} <= {t.get_text() for t in above.texts}


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--tracks", "washbord/low"], "washbord/low"),
        (["--tracks", "washboard/low", "--speeds", "0"], "above 0 km/h"),
        (["--tracks", "washboard/low", "--speeds", "8", "--runs", "2"], "1 combination"),
        (["--tracks", "washboard/low", "--runs", "0"], "0 runs"),
        (["--tracks", "washboard/low", "--minutes", "0.1"], "one run alone takes 10.24 s"),
        (["--tracks", "washboard/low", "--noise", "0"], "above 0"),
        (["--tracks", "washboard/low", "--seconds", "1"], "from 2 to 600"),
        (["--tracks", "washboard/low", "--out", "examples"], "examples: is there already"),
        (["--tracks", "washboard/low", "--only", "dry-frictoin"], 'did you mean "dry-friction"'),
    ],
)
def test_what_cannot_be_planned_is_one_line(words: list[str], reason: str, capsys: Any) -> None:
    assert main(["plan", str(VEHICLE), *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert reason in lines[0]


def test_the_table_says_where_a_tyre_would_leave_the_ground(capsys: Any) -> None:
    words = ["--tracks", "herringbone/high", "--speeds", "20", "--runs", "1", "--seconds", "4"]
    assert main(["plan", str(VEHICLE), *words, "--only", "dry-friction"]) == 0
    assert "a tyre would leave the ground" in capsys.readouterr().out
