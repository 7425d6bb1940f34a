"""Campaigns from cases: vehicle, noise, strength and truth, from the case's seed alone."""

from __future__ import annotations

import shutil
import tempfile
import time
import tomllib
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.blind.everything import IN_THE_FILES, SHOWS, colour_the_noise, imperfections
from benchmarks.blind.outside import OUTSIDE
from benchmarks.blind.plan import Case
from benchmarks.blind.reality import REALITY
from benchmarks.blind.recipes import RECIPES, Recipe
from benchmarks.blind.strength import (
    Hidden,
    Unreachable,
    Wanted,
    baseline_over_floor,
    own_part,
    seek,
)
from benchmarks.blind.vehicles import car_of, rougher, varied
from benchmarks.blind.work import Work, write_json
from tests.truth import Preset, write_campaign
from tests.truth.campaign import SAMPLE_RATE_HZ
from tests.truth.effect import Effect

CLEAR, IN_COMPANY, WEAK = (2.2, 20.0), (2.2, 10.0), (1.25, 1.45)
"""What the fitted baseline leaves on held-out runs, over the floor: aims are drawn from here, for
several effects at once each for itself."""
FAINT = (0.02, 0.12)
"""What is left over the floor, less one: at the edge of what these runs can show, where confidence
cannot be all or nothing."""
CLEAR_FROM, WEAK_WITHIN = 2.0, (1.2, 1.5)
NEARLY = 1.4  # a clear strength may miss its aim by this factor

SEVERITY, LEAST_SEVERITY, MOST_SEVERITY = (0.8, 1.2), 0.15, 3.0
STEEPER, STEEPENINGS = 1.4, 3  # tracks, where an effect cannot be made strong enough
NOISE_RMS = (0.05, 0.25)  # m/s^2
LEAST_SHARE = 0.2
"""What the runs fitted must show of an effect, held-out runs showing 1: from nothing, nothing can
be learnt. Not asked of effects without a number to fit."""
TYPICAL_RATIO, TYPICAL_NOISE = 4.0, 0.1  # at the amount 1
AMOUNTS_IN_FILES = (0.05, 5.0)  # of what is stated wrongly; 1 is what a careful owner leaves


@dataclass
class _Scene:
    """A vehicle, its tracks and its noise."""

    case: Case
    preset: Preset
    noise_rms: float
    severity: float
    folder: Path
    fitted_over_floor: float = 1.0  # of the campaign looked at last
    rate_hz: float = 100.0

    def ratio(
        self,
        effects: Sequence[Effect],
        *,
        short: bool,
        draft: bool,
        spoil: Callable[[Path], None] = lambda folder: None,
    ) -> float:
        """Write the campaign, spoil it and look at it as a user would: baseline over floor, held
        out."""
        write_campaign(
            self.folder,
            rougher(self.preset, self.severity),
            effects,
            seed=self.case.campaign_seed,
            short=short,
            noise_rms=self.noise_rms,
            rate_hz=SAMPLE_RATE_HZ if draft else self.rate_hz,
            draft=draft,
        )
        spoil(self.folder)
        held_out, self.fitted_over_floor = baseline_over_floor(self.folder)
        return held_out

    def draw(self, name: str, number: int | None = None) -> Hidden:
        """The shape of a hidden effect, or of another with a `number` of its own: the same whenever
        it is asked for on the same tracks."""
        number = self.case.hidden.index(name) if number is None else number
        rng = np.random.default_rng([self.case.campaign_seed, 1 + number])
        car = car_of(rougher(self.preset, self.severity), self.case.campaign_seed)
        return {**RECIPES, **OUTSIDE, **self.laws}[name](rng, car)

    @property
    def laws(self) -> Mapping[str, Recipe]:
        """How this machine obeys what it hides, where not as the library has it."""
        kind = self.case.kind
        return REALITY[kind].laws if kind in REALITY else {}


def generate(case: Case, work: Work) -> dict[str, Any]:
    """Make the case's campaign unless it is there; returns what is in its truth's JSON."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary) / "campaign"
        try:
            made = _make(case, folder, work.short)
        except Unreachable as error:
            made = {"unreachable": str(error)}
        else:
            _store(case, folder, work)
    made |= {
        "kind": case.kind,
        "hidden": list(case.hidden),
        "preset": case.preset,
        "seed": case.campaign_seed,
        "seconds": round(time.perf_counter() - begin, 1),
    }
    write_json(work.truth_json(case.campaign), made)
    return made


def _store(case: Case, folder: Path, work: Work) -> None:
    truth, campaign = work.truth_toml(case.campaign), work.campaign(case.campaign)
    truth.parent.mkdir(parents=True, exist_ok=True)
    shutil.move(folder / "truth.toml", truth)
    shutil.rmtree(campaign, ignore_errors=True)
    campaign.parent.mkdir(parents=True, exist_ok=True)
    shutil.move(folder, campaign)


def _make(case: Case, folder: Path, short: bool) -> dict[str, Any]:
    rng = np.random.default_rng([case.campaign_seed, 0])
    preset = varied(case.preset, rng)
    noise = float(f"{_between(NOISE_RMS, rng):.3g}")
    scene = _Scene(case, preset, noise, float(rng.uniform(*SEVERITY)), folder)
    circumstance = REALITY.get(case.kind)
    if circumstance is not None:
        scene.rate_hz = circumstance.rate_hz
    wanted = _wanted(case, rng)
    # What only rougher tracks make stronger comes first: the others live on its tracks.
    order = sorted(case.hidden, key=lambda name: not scene.draw(name).by_severity)
    found = {name: _find(scene, name, wanted) for name in order}
    if len(found) == 1:
        hidden, amount = found[case.hidden[0]]
        amount, ratio = _seek(scene, hidden, wanted, amount, short=short, draft=False)
        found[case.hidden[0]] = hidden, amount
    else:
        effects = [found[name][0].at(found[name][1]) for name in case.hidden]
        ratio = scene.ratio(effects, short=short, draft=False)
    imperfect: dict[str, Any] = {}
    if case.kind == "everything":
        there = [found[name][0].at(found[name][1]) for name in case.hidden]
        imperfect, ratio = _everything(scene, there, short)
    truth = tomllib.loads((folder / "truth.toml").read_text())
    if circumstance is not None:
        circumstance.spoil(folder, np.random.default_rng([case.campaign_seed, 4]))
    return {
        "aim": round(wanted.aim, 3),
        "baseline_over_floor": round(ratio, 4),
        "fitted_over_floor": round(scene.fitted_over_floor, 4),
        "oracle_rel_validate": truth["oracle_rel_validate"],
        "amounts": {name: found[name][1] for name in case.hidden},
        "severity": scene.severity,
        "noise_rms_m_s2": noise,
        "imperfections": imperfect,
    }


def _everything(
    scene: _Scene, there: Sequence[Effect], short: bool
) -> tuple[dict[str, tuple[float, float] | None], float]:
    """Write the campaign with all imperfections at once. Returns of each its amount and what that
    leaves alone, over the noise (None: it cannot show so little or so much); and what the baseline
    leaves of all."""
    seed = scene.case.campaign_seed
    rng = np.random.default_rng([seed, 5])
    amounts: dict[str, tuple[float, float] | None] = {}
    machine: list[Effect] = []
    files: list[Callable[[Path], None]] = []
    start = scene.noise_rms / TYPICAL_NOISE / own_part(TYPICAL_RATIO)
    for number, name in enumerate(imperfections(scene.case.hidden)):
        wanted = _alone(rng)
        hidden = next(
            h for k in range(9) if not (h := scene.draw(name, 10 + number + 20 * k)).by_severity
        )
        with suppress(Unreachable):
            amounts[name] = None
            amounts[name] = found = _seek(
                scene, hidden, wanted, start * own_part(wanted.aim), short=True, draft=True
            )
            machine.append(hidden.at(found[0]))
    for number, name in enumerate(IN_THE_FILES):

        def change(folder: Path, amount: float, number: int = number, name: str = name) -> None:
            IN_THE_FILES[name](folder, np.random.default_rng([seed, 6, number]), amount)

        with suppress(Unreachable):
            amounts[name] = None
            amounts[name] = found = seek(
                partial(_spoilt, scene, change), _alone(rng), 1.0, AMOUNTS_IN_FILES
            )
            files.append(partial(change, amount=found[0]))

    def all_of_them(folder: Path) -> None:
        for change in files:
            change(folder)
        colour_the_noise(folder, np.random.default_rng([seed, 7]))

    return amounts, scene.ratio([*there, *machine], short=short, draft=False, spoil=all_of_them)


def _spoilt(scene: _Scene, change: Callable[[Path, float], None], amount: float) -> float:
    """What the baseline leaves of a clean campaign whose files are off by an amount."""
    return scene.ratio([], short=True, draft=True, spoil=lambda folder: change(folder, amount))


def _alone(rng: np.random.Generator) -> Wanted:
    low, high = SHOWS
    return Wanted(1.0 + _between((low - 1.0, high - 1.0), rng), low, high)


def _wanted(case: Case, rng: np.random.Generator) -> Wanted:
    if case.kind == "weak":
        return Wanted(float(rng.uniform(*WEAK)), *WEAK_WITHIN)
    if case.kind == "faint":
        more = _between(FAINT, rng)
        return Wanted(1.0 + more, 1.0 + more / NEARLY, 1.0 + more * NEARLY)
    aim = _between(IN_COMPANY if len(case.hidden) > 1 else CLEAR, rng)
    return Wanted(aim, max(CLEAR_FROM, aim / NEARLY), aim * NEARLY)


def _between(bounds: tuple[float, float], rng: np.random.Generator) -> float:
    """Log-uniform."""
    return float(np.exp(rng.uniform(*np.log(bounds))))


def _find(scene: _Scene, name: str, wanted: Wanted) -> tuple[Hidden, float]:
    """The effect and the amount of it that shows as much as wanted on the short run set, on
    steeper tracks if need be: where it cannot be so strong, or hardly shows on the runs fitted."""
    start = own_part(wanted.aim) / own_part(TYPICAL_RATIO) * scene.noise_rms / TYPICAL_NOISE
    for _ in range(STEEPENINGS + 1):
        hidden = scene.draw(name)
        try:
            amount, ratio = _seek(scene, hidden, wanted, start, short=True, draft=True)
        except Unreachable as error:
            if hidden.by_severity:
                raise
            why = str(error)
        else:
            share = own_part(scene.fitted_over_floor) / own_part(ratio)
            if hidden.by_severity or share > LEAST_SHARE:
                return hidden, amount
            why = f"{share:.2g} as strong on the runs fitted as on those held out"
        scene.severity *= STEEPER
    raise Unreachable(why)


def _seek(
    scene: _Scene,
    hidden: Hidden,
    wanted: Wanted,
    start: float,
    *,
    short: bool,
    draft: bool,
) -> tuple[float, float]:
    """Amount and ratio; the campaign left in the scene's folder is the one that has them."""
    if not hidden.by_severity:
        return seek(
            lambda amount: scene.ratio([hidden.at(amount)], short=short, draft=draft),
            wanted,
            start,
            (1e-4, hidden.most),
        )

    def on_tracks(severity: float) -> float:
        scene.severity = severity
        return scene.ratio([hidden.at(1.0)], short=short, draft=draft)

    bounds = (LEAST_SEVERITY, MOST_SEVERITY)
    any_clear = wanted if wanted.high < CLEAR_FROM else replace(wanted, low=CLEAR_FROM, high=inf)
    _, ratio = seek(on_tracks, any_clear, scene.severity, bounds)
    return 1.0, ratio
