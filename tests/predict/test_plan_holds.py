"""Of two campaigns of the same length that the independent simulator drives, the one that a plan
advises identifies the vehicle better, and separates a pair of effects better.

`python -m benchmarks.plan` asks more of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from benchmarks.plan import HIDDEN, Driven, error_of, fitted, vehicles
from tests.truth import PRESETS
from wheelhop.api import plan
from wheelhop.diagnose.screen.first_order import screen
from wheelhop.effects import load_effects
from wheelhop.predict import read_drives

TRACKS = (
    "washboard:amplitude_mm=15:pitch_mm=400",
    "herringbone:amplitude_mm=20:pitch_mm=800:angle_deg=20",
    "chassis-twist:amplitude_mm=150:pitch_mm=2000:width_mm=4000",
)
SPEEDS = (6.0, 10.0, 16.0)
PAIR = ("asymmetric-damper", "progressive-spring")


@pytest.fixture(scope="module")
def campaigns() -> tuple[Driven, Driven]:
    """Two runs each: those advised, and the first and the last track at the middle speed."""
    true, believed = vehicles(PRESETS["atv"], 3)
    advised = plan(believed, TRACKS, SPEEDS, runs=2, only=PAIR)
    naive = read_drives((TRACKS[0], TRACKS[2]), SPEEDS[1:2])
    drives = tuple(replace(drive, role="fit") for drive in advised.drives)
    return Driven(true, believed, drives, 3), Driven(true, believed, naive, 3)


def test_advised_runs_identify_the_vehicle_better(campaigns: tuple[Driven, Driven]) -> None:
    advised, naive = (error_of(fitted(driven, {}), driven.true) for driven in campaigns)
    assert advised < 0.7 * naive


def test_advised_runs_separate_effects_better(campaigns: tuple[Driven, Driven]) -> None:
    library, odds = load_effects(), []
    for driven in campaigns:
        base = fitted(driven, {PAIR[0]: HIDDEN[PAIR[0]]})
        found = screen(base.workshop, base.rung.fit, [library[name] for name in PAIR])
        score = {item.variant.effect.id: item.score for item in found}
        odds.append(score[PAIR[0]] - score[PAIR[1]])
    advised, naive = odds
    assert advised > 1.3 * naive
