"""The process that computes: it takes orders one by one and says what it finds as it finds it.

It keeps the fits of the data it worked on last, so that adding one more effect fits one more model.
A model that is no longer wanted is left where it is, and those that are fitted stay. To give up
all work the process is killed; the next one begins anew.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from wheelhop.api import ComparisonResult
from wheelhop.campaign import Campaign, read_campaign
from wheelhop.compare.settings import compare_settings
from wheelhop.diagnose import Baseline, Diagnosis, Step, fit_baseline
from wheelhop.diagnose.search.ladder import diagnose_from, one_more
from wheelhop.diagnose.search.look import step_of
from wheelhop.effects import Effect, beliefs, load_effects
from wheelhop.files import InputError
from wheelhop.gate import Gated, gate
from wheelhop.identify import Linearity, linearity
from wheelhop.law import BeyondNames, LastRungs, find_law
from wheelhop.predict.detectable import detectable
from wheelhop.report.law import beyond_names
from wheelhop.report.reports import write_diagnosis_report
from wheelhop.report.summary import write_summary
from wheelhop.vehicle import Vehicle, read_nominal
from wheelhop.workbench import show
from wheelhop.workbench.export import (
    write_figures,
    write_mdf,
    write_signals,
    write_tables,
    write_workbook,
)
from wheelhop.workbench.order import Enough, GiveWay, Order
from wheelhop.workbench.shown import (
    Climbed,
    Concluded,
    Converging,
    Done,
    Findings,
    Message,
    Refused,
    Said,
)
from wheelhop.workbench.takeaway import (
    FIGURES,
    MDF,
    MODEL,
    SIGNALS,
    SUMMARY,
    SUMMARY_PDF,
    TABLES,
    WORKBOOK,
)

EXPORTS: Mapping[str, Callable[[Path, ComparisonResult], None]] = {
    FIGURES: write_figures,
    TABLES: write_tables,
    WORKBOOK: write_workbook,
    SIGNALS: write_signals,
    MDF: write_mdf,
}
Say = Callable[[Message], None]


@dataclass(eq=False)
class Work:
    """One campaign's data and the fits made of it."""

    campaign: Campaign
    vehicle: Vehicle
    gated: Gated
    library: Mapping[str, Effect]
    base: Baseline
    steps: dict[tuple[str, ...], Step] = field(default_factory=dict)
    diagnosis: Diagnosis | None = None
    law: LastRungs | None = None
    linearity: Linearity | None = None
    foretold: str = ""

    def ladder(self, added: Sequence[str]) -> list[Step]:
        """The rungs that are fitted already, from the baseline towards `added`."""
        names = [tuple(added[:i]) for i in range(len(added) + 1)]
        return [self.steps[name] for name in names if name in self.steps]


class _NotWanted(Exception):
    """The model being fitted is not on the way to the one wanted now."""


class Worker:
    """Works off orders; `say` takes every message on its way to the page, and `newer` gives what
    has been said since of the order to come, if anything."""

    def __init__(
        self, say: Say, newer: Callable[[], GiveWay | Enough | None] = lambda: None
    ) -> None:
        self._say, self._newer = say, newer
        self._fitting: tuple[str, ...] | None = None
        self._searching = self._enough = False
        self._data: tuple[object, ...] = ()
        self._following: Order | None = None
        self._key: tuple[object, ...] = ()
        self._work: Work | None = None

    def obey(self, order: Order) -> None:
        """Do what the order says; a mistake in the input is said, not raised, and so is a fault of
        the program or of the user's effects."""
        try:
            if order.wish == "settings":
                self._compare_settings(order)
                self._say(Done())
                return
            work = self._prepared(order)
            self._climb(work, order.choice.added)
            match order.wish:
                case "diagnose":
                    self._diagnose(work)
                case "law":
                    self._find_law(work, order.choice.added)
                case "axles":
                    self._identify(work, order.choice.added)
                case "foresee":
                    self._foresee(work)
            self._say(Done(self._written(work, order)))
        except InputError as error:
            self._say(Refused(str(error)))
        except _NotWanted:
            self._say(Done(""))
        except Exception as error:
            traceback.print_exc()
            self._work = None  # who knows what it was left like
            self._say(Refused(_fault(error)))
        finally:
            self._fitting = self._following = None
            self._searching = self._enough = False

    def _compare_settings(self, order: Order) -> None:
        """Of the recordings alone, with no model."""
        campaign = read_campaign(order.folder, set(order.choice.without_runs), self._progress)
        found = compare_settings(order.choice.applied(campaign))
        self._say(show.settings(found))

    def _prepared(self, order: Order) -> Work:
        self._data = _data_of(order)
        self._fitting = None if order.wish in ("axles", "foresee") or order.write else ()
        if self._work is None or self._data != self._key:
            self._work = self._begun(order)
            self._key = self._data
        return self._work

    def _begun(self, order: Order) -> Work:
        left_out = set(order.choice.without_runs)
        campaign = read_campaign(order.folder, left_out, self._progress)
        campaign = order.choice.applied(campaign)
        vehicle = read_nominal(campaign)
        self._say(Said("looking for mistakes in what the campaign says"))
        gated = gate(campaign, vehicle)
        self._say(Findings(show.findings(gated.findings)))
        library = {**load_effects(order.effects_file), **beliefs(gated.campaign, vehicle)}
        self._say(show.library(library))
        base = fit_baseline(gated.campaign, vehicle, progress=self._progress, watch=self._watch)
        work = Work(campaign, vehicle, gated, library, base)
        work.steps[()] = step_of(base.workshop, base.rung)
        return work

    def _climb(self, work: Work, added: Sequence[str]) -> None:
        """Fit what is missing on the way to `added`, and show every rung as it comes."""
        if tuple(added) in work.steps:
            self._show(work, added)
        for i, name in enumerate(added):
            before, here = tuple(added[:i]), tuple(added[: i + 1])
            if here not in work.steps:
                if name not in work.library:
                    raise InputError(f'there is no effect "{name}" here: take it out of the model')
                self._fitting = None if self._fitting is None else here
                effect, rung = work.library[name], work.steps[before].rung
                rung = one_more(work.base.workshop, rung, effect, self._progress)
                work.steps[here] = step_of(work.base.workshop, rung, work.steps[()])
                self._show(work, here)
        self._fitting = None

    def _diagnose(self, work: Work) -> None:
        base, traced = work.base, show.Traced()
        beyond = BeyondNames(list(work.library.values()), self._progress)
        self._searching = True
        work.diagnosis = diagnose_from(
            work.gated,
            work.vehicle,
            base,
            work.library,
            progress=self._progress,
            watch=lambda scored: self._say(show.ranking(base.workshop, scored, traced)),
            beyond=beyond,
        )
        self._searching = False
        work.law = beyond.last_rungs(work.diagnosis)
        work.linearity = work.diagnosis.axle_to_body or work.linearity
        for step in work.diagnosis.ladder:
            work.steps[step.added] = step
        self._say(show.final_ranking(base.workshop, work.diagnosis))
        found = show.findings(work.diagnosis.findings)
        case = show.case(work.gated.campaign, work.diagnosis.ladder)
        self._say(Concluded(show.verdict(work.diagnosis, work.gated.campaign), found, case))
        if work.law is not None:
            self._say(show.law(work.law.found, beyond_names(work.law)))

    def _find_law(self, work: Work, added: Sequence[str]) -> None:
        accepted, effects = [work.library[name] for name in added], list(work.library.values())
        campaign = work.gated.campaign
        self._say(show.law(find_law(campaign, work.vehicle, accepted, effects, self._progress)))

    def _identify(self, work: Work, added: Sequence[str]) -> None:
        campaign = work.gated.campaign
        self._say(Said("fitting transfer functions from the axles to the body"))
        if work.linearity is None:
            work.linearity = linearity(campaign, work.vehicle)
            if work.linearity.model is not None:
                self._say(Said("drawing what they predict of every run"))
                work.foretold = show.foretold(work.linearity.model, campaign)
        found = show.between(work.linearity, campaign, work.ladder(added), work.foretold)
        self._say(found)

    def _foresee(self, work: Work) -> None:
        campaign, library = work.gated.campaign, work.library.values()
        found = detectable(campaign, work.vehicle, library, progress=self._progress)
        self._say(show.can_show(found))

    def _written(self, work: Work, order: Order) -> str:
        """Write what is asked for; the line that says so."""
        if not order.write:
            return ""
        steps, findings = work.ladder(order.choice.added), work.gated.findings
        target, campaign = order.folder / order.write, work.gated.campaign
        result = ComparisonResult(
            campaign, work.vehicle, tuple(steps), findings, work.base.workshop
        )
        if order.write in (SUMMARY, SUMMARY_PDF):
            if work.diagnosis is None:
                raise InputError("a summary is of a diagnosis: find out what is missing first")
            write_summary(target, campaign, work.diagnosis)
        elif order.write == MODEL:
            result.write_model(target)
        elif order.write in EXPORTS:
            EXPORTS[order.write](target, result)
        else:
            self._report(work, order, target, result)
        return f"written: {target}"

    def _report(self, work: Work, order: Order, target: Path, result: ComparisonResult) -> None:
        """That of the diagnosis, if the model is the one it came to."""
        found = work.diagnosis
        if found and found.ladder[-1].added == tuple(order.choice.added):
            write_diagnosis_report(target, result.campaign, found, work.library, work.law)
        else:
            result.write_report(target)

    def _show(self, work: Work, added: Sequence[str]) -> None:
        steps = work.ladder(added)
        self._say(Climbed(show.rungs(work.gated.campaign, steps)))

    def _watch(self, iteration: int, error: float) -> None:
        self._say(Converging(iteration, error))
        self._go_on()

    def _progress(self, text: str) -> None:
        self._say(Said(text))
        self._go_on()

    def _go_on(self) -> None:
        """Raise `_NotWanted` where the model being fitted is not on the way to the one wanted, and
        KeyboardInterrupt, which ends a search with the verdict so far, where that is enough."""
        fitting = self._fitting
        if fitting is None and not self._searching:
            return
        match self._newer():
            case GiveWay(order):
                self._following = order
            case Enough():
                self._enough = True
        if self._searching and self._enough:
            raise KeyboardInterrupt
        if fitting is None:
            return
        if (following := self._following) is not None:
            on_the_way = following.choice.added[: len(fitting)] == fitting
            if not on_the_way or _data_of(following) != self._data:
                raise _NotWanted


def _fault(error: Exception) -> str:
    """What happened, and where, in a line."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    what = " ".join(f"{type(error).__name__}: {error}".split())
    where = f"line {place.lineno} of {Path(place.filename).name}"
    return f"not finished: {what} ({where}; the workbench's terminal shows the rest): try again"


def _data_of(order: Order) -> tuple[object, ...]:
    """What the fits of an order rest on."""
    return (order.folder, order.effects_file, order.choice.data())
