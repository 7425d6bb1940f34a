"""The desk: what the user decided, what is known, and the work that is going on.

There is one desk, whatever the number of tabs: each shows it anew when its `version` has changed.
"""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.metadata import version
from math import isnan
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import TYPE_CHECKING

from wheelhop.campaign import Campaign, CampaignError
from wheelhop.files import InputError, Source, away_from_here
from wheelhop.workbench.compared import Compared
from wheelhop.workbench.order import (
    DOING,
    LONG,
    Enough,
    GiveWay,
    Order,
    Wish,
    how_it_ended,
    obey_orders,
)
from wheelhop.workbench.results import Beside, Made, Results
from wheelhop.workbench.session import (
    Choice,
    Session,
    first_session,
    made_of,
    read_session,
    toggled,
    unread_words,
    without,
    write_session,
)
from wheelhop.workbench.shown import (
    AxleToBody,
    CanShow,
    Card,
    Climbed,
    Concluded,
    Converging,
    Diagnosed,
    Done,
    Findings,
    Found,
    Law,
    Library,
    Message,
    Ranking,
    Refused,
    Rung,
    Said,
    Settings,
)

if TYPE_CHECKING:
    from multiprocessing.context import SpawnProcess


@dataclass
class Job:
    """What the worker is at: a title, the line it said last, since when (s), whether it diagnoses,
    whether it is so long that another wish ends it, what its results are made of, the error E its
    fit is at, and whether it was asked to end with what it knows."""

    title: str
    line: str
    since_s: float
    diagnosing: bool
    long: bool
    made: Made
    error: float = float("nan")
    ending: bool = False


class Desk:
    """One campaign on the workbench.

    `rungs` lead to the model chosen as far as they are fitted; `errors` are E after every iteration
    of the last fits; `notice` is a line the user should read, an error or what was written.
    """

    def __init__(self, campaign: Campaign, effects_file: Source | None) -> None:
        self.campaign = campaign
        self.effects_file = effects_file
        self.version = 0
        self.notice = ""
        self.can_take_back = False
        self.findings: tuple[Found, ...] = ()
        self.cards: dict[str, Card] = {}
        self.rungs: tuple[Rung, ...] = ()
        self.job: Job | None = None
        self.errors: tuple[float, ...] = ()
        self.baseline_took_s = 0.0
        self._wrong = False
        session = self._read()
        self._choice = session.choice
        self.looked_at = session.looked_at
        self._results = Results(session.diagnoses)
        self._made = self._made_now()
        self._past: list[Choice] = []
        self._future: list[Choice] = []
        self._process: SpawnProcess | None = None
        self._orders: Connection | None = None
        self._next: Order | None = None
        self._loop: asyncio.AbstractEventLoop | None = None
        self._effects_before: tuple[Source | None, tuple[str, ...]] | None = None

    # What the user decides.

    @property
    def choice(self) -> Choice:
        """Data and model as they are chosen."""
        return self._choice

    @property
    def ranking(self) -> Ranking | None:
        """The effects ranked on the data chosen, as far as that has come."""
        return self._results.ranking(self._made)

    @property
    def diagnosis(self) -> Diagnosed | None:
        """The last diagnosis of the data chosen that came to its end."""
        return self._results.diagnosis(self._made)

    def beside(self, kind: type[Beside]) -> Beside | None:
        """What was found of this kind beside the model chosen."""
        return self._results.beside(kind, self._made)

    @property
    def can_go(self) -> tuple[bool, bool]:
        """Whether there is something to undo, and to redo."""
        return bool(self._past), bool(self._future)

    def begin(self) -> None:
        """Fit what the session chose, unless something was ordered before."""
        if self._loop is None:
            notice = self.notice
            self._work()
            self.notice = notice

    def add(self, effect: str) -> None:
        """Make an effect part of the model."""
        if effect not in self.choice.added:
            self._choose(replace(self.choice, added=(*self.choice.added, effect)))

    def take_out(self, effect: str) -> None:
        """Take an effect out of the model."""
        self._choose(replace(self.choice, added=without(self.choice.added, effect)))

    def move_up(self, effect: str) -> None:
        """Add an effect one place earlier."""
        added = list(self.choice.added)
        i = added.index(effect)
        if i > 0:
            added[i - 1 : i + 1] = [effect, added[i - 1]]
            self._choose(replace(self.choice, added=tuple(added)))

    def toggle_run(self, run: str) -> None:
        """Leave a run out, or take it back in."""
        self._choose(replace(self.choice, without_runs=toggled(self.choice.without_runs, run)))

    def toggle_channel(self, channel: str) -> None:
        """Leave a channel out, or take it back in."""
        channels = toggled(self.choice.without_channels, channel)
        self._choose(replace(self.choice, without_channels=channels))

    def set_role(self, run: str, role: str) -> None:
        """Fit a run, or hold it out."""
        own = {item.id: item.role for item in self.campaign.runs}
        roles = {**self.choice.roles, run: role}
        changed = {run: role for run, role in roles.items() if role != own[run]}
        self._choose(replace(self.choice, roles=changed))

    def undo(self) -> None:
        """The choice before the last change."""
        if self._past:
            self._future.append(self.choice)
            self._take(self._past.pop())

    def redo(self) -> None:
        """The choice that was taken back last."""
        if self._future:
            self._past.append(self.choice)
            self._take(self._future.pop())

    def diagnose(self) -> None:
        """Find out which effects are missing."""
        self._work("diagnose")

    def use_effects(self, file: Source) -> None:
        """Load effects of the user's own, who has seen this text and wants it to run."""
        self._effects_before = self.effects_file, tuple(self.cards)
        self.effects_file = file
        self._made = self._made_now()
        self._work()

    def find(self, wish: Wish) -> None:
        """Work out something that is no diagnosis, beside the model chosen."""
        self._work(wish)

    def write(self, what: str) -> None:
        """Write the report, the model, the figures or the tables of what is chosen, by their names
        in `takeaway`."""
        self._work(write=what)

    def cancel(self) -> None:
        """Give up the work that is going on; what it has found stays. The first diagnosis of some
        data is asked for the verdict so far, before that."""
        self._next = None
        first = self.job and self.job.diagnosing and self.job.made[0] not in self._results.diagnoses
        if self.job and first and not self.job.ending and self._orders:
            self.job.ending = True
            self._orders.send(Enough())
            return self._changed("ending with what is known by now; Stop once more gives it up")
        self._stop()
        self._changed("given up")

    def close(self) -> None:
        """End the worker."""
        self._next = None
        self._stop()

    def look_at(self, state: Compared) -> None:
        """Keep what Compare shows, unless that would take the place of a wrong session."""
        self.looked_at = state
        if not self._wrong:
            self._keep()

    def say(self, line: str) -> None:
        """Show a line to the user, in every tab."""
        self._changed(line)

    def _choose(self, choice: Choice) -> None:
        try:
            choice.applied(self.campaign)
        except CampaignError as error:
            self._changed(str(error))
            return
        self._past.append(self.choice)
        self._future.clear()
        self._take(choice)

    def _take(self, choice: Choice) -> None:
        self._choice, self._wrong = choice, False
        self._made = self._made_now()
        self._work()
        self._keep()

    def _made_now(self) -> Made:
        return made_of(self.campaign, self.choice, self.effects_file), self.choice.added

    def _work(self, wish: Wish = "", write: str = "") -> None:
        """Order the work; a long one that is going on is given up, a fit only gives way."""
        self.notice = ""
        order = Order(self.campaign.folder, self.choice, self.effects_file, wish, write)
        if self.job is not None:
            if self.job.long:
                self._stop()
            else:
                self._next = order
                if self._orders is not None:
                    self._orders.send(GiveWay(order))
                self._changed()
                return
        self._send(order)

    def _send(self, order: Order) -> None:
        if self._process is None or not self._process.is_alive():
            self._hire()
        assert self._orders is not None
        title = f"writing {order.write}" if order.write else DOING[order.wish]
        now, diagnosing = time.monotonic(), order.wish == "diagnose"
        self.job = Job(title, "starting", now, diagnosing, order.wish in LONG, self._made)
        self._loop = asyncio.get_running_loop()
        self._orders.send(order)
        self._changed()

    def _hire(self) -> None:
        context = get_context("spawn")
        here, there = context.Pipe()
        self._process = context.Process(target=obey_orders, args=(there,), daemon=True)
        with away_from_here():
            self._process.start()
        there.close()
        self._orders = here
        threading.Thread(target=self._listen, args=(here,), daemon=True).start()

    def _listen(self, orders: Connection) -> None:
        """In a thread of its own: every message goes to the page's loop."""
        while True:
            try:
                message: Message = orders.recv()
            except (EOFError, OSError):
                self._call(lambda: self._lost(orders))
                return
            self._call(lambda message=message: self._hear(orders, message))  # type: ignore[misc]

    def _call(self, function: Callable[[], None]) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(function)

    def _lost(self, orders: Connection) -> None:
        """The worker is gone without having been told to go."""
        if orders is self._orders and (process := self._process) is not None:
            process.join(5.0)
            line = how_it_ended(process.exitcode)
            self._stop()
            self._changed(line)

    def _stop(self) -> None:
        process, self._process, self._orders, self.job = self._process, None, None, None
        self._results = self._results.stopped()
        if process is not None:
            process.kill()
            process.join(5.0)

    def _hear(self, orders: Connection, message: Message) -> None:
        if orders is not self._orders or self.job is None:
            return  # what a worker that was given up had said before
        match message:
            case Said(text):
                self.job.line = text
            case Converging(_, error):
                if not self.job.long:  # the last fits stay until the next one tells
                    self.errors = (*(() if isnan(self.job.error) else self.errors), error)
                self.job.error = error
            case Findings(found):
                self.findings = found
            case Library(cards):
                self._take_cards(cards)
            case Climbed(rungs):
                self._climbed(rungs)
            case Ranking() | Concluded() | Law() | AxleToBody() | CanShow() | Settings():
                self._results = self._results.heard(self.job.made, message)
                if isinstance(message, Concluded):
                    self._keep()
            case Refused(line):
                if self._effects_before is not None:  # it was the user's file that failed
                    self.effects_file, self._effects_before = self._effects_before[0], None
                    self._made = self._made_now()
                self._finished(line)
            case Done(line):
                self._finished(line)
        self._changed()

    def _take_cards(self, cards: tuple[Card, ...]) -> None:
        self.cards = {card.effect: card for card in cards}
        if self._effects_before is not None:
            new = [name for name in self.cards if name not in self._effects_before[1]]
            self.notice = f"loaded: {', '.join(new) or 'nothing new'}; find out again to rank it"
            self._effects_before = None

    def _climbed(self, rungs: tuple[Rung, ...]) -> None:
        assert self.job is not None
        self.rungs = rungs
        if not self.baseline_took_s:
            self.baseline_took_s = time.monotonic() - self.job.since_s

    def _finished(self, line: str) -> None:
        self.job = None
        self._results = self._results.stopped()
        self.notice = line or self.notice
        if self._next is not None:
            order, self._next = self._next, None
            self._send(order)

    def _changed(self, notice: str | None = None) -> None:
        self.version += 1
        if notice is not None:
            self.notice = notice

    def _read(self) -> Session:
        try:
            session = read_session(self.campaign)
        except InputError as error:
            self._wrong = True
            self.notice = f"{error}; a new session begins, the file stays until something is chosen"
            return first_session(self.campaign)
        self.notice = unread_words(self.campaign)
        return session

    def _keep(self) -> None:
        session = Session(self.choice, self._results.diagnoses, self.looked_at)
        try:
            write_session(self.campaign, session, f"wheelhop {version('wheelhop')}")
        except InputError as error:
            self.notice = f"the session is not kept: {error}"
