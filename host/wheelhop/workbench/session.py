"""What the user decided and what a diagnosis found, kept in the campaign's folder: session.toml."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from wheelhop.campaign import Campaign, CampaignError, Run
from wheelhop.campaign.common import Entry
from wheelhop.files import InputError, Table, read_toml, to_toml, write_text
from wheelhop.workbench.shown import Row, Verdict

FILE = "session.toml"
ROLES = ("fit", "validate")
MOST_RUNS = 200
"""As many runs are fitted in minutes."""


@dataclass(frozen=True)
class Choice:
    """The data and the model: effects added, in order; runs and channels left out; runs whose role
    is another than in campaign.toml."""

    added: tuple[str, ...] = ()
    without_runs: tuple[str, ...] = ()
    without_channels: tuple[str, ...] = ()
    roles: Mapping[str, str] = field(default_factory=dict)

    def data(self) -> tuple[object, ...]:
        """What the fits are made of: two choices of the same data share their fits."""
        return (
            tuple(sorted(self.without_runs)),
            tuple(sorted(self.without_channels)),
            tuple(sorted(self.roles.items())),
        )

    def applied(self, campaign: Campaign) -> Campaign:
        """The campaign without what is left out, in the roles chosen.

        Raises CampaignError if no run that is fitted, or no channel, is left.
        """
        left_out = frozenset(self.without_runs)
        kept = [i for i, c in enumerate(campaign.channels) if c.name not in self.without_channels]
        runs = tuple(
            replace(run, role=self.roles.get(run.id, run.role), record=run.record[:, kept])
            for run in campaign.runs
            if run.id not in left_out
        )
        if not kept or not any(run.role == "fit" for run in runs):
            raise CampaignError(
                f"{campaign.folder}: no run that is fitted is left, or no channel: take one back in"
            )
        return replace(campaign, runs=runs, channels=tuple(campaign.channels[i] for i in kept))


@dataclass(frozen=True)
class Session:
    """A choice and the last diagnosis of its data, if there was one."""

    choice: Choice = field(default_factory=Choice)
    verdict: Verdict | None = None
    ranking: tuple[Row, ...] = ()


def read_session(campaign: Campaign) -> Session:
    """The session of a campaign; `first_session` where there is no file.

    Names the campaign does not have any more are left out. Raises CampaignError for a file that is
    not a session.
    """
    path = campaign.folder / FILE
    if not path.is_file():
        return first_session(campaign)
    top = read_toml(path, CampaignError)
    top.format()
    runs = {run.id for run in campaign.runs}
    channels = {channel.name for channel in campaign.channels}
    roles = top.table_if_any("role")
    choice = Choice(
        tuple(top.texts("added")),
        tuple(name for name in top.texts("without_runs") if name in runs),
        tuple(name for name in top.texts("without_channels") if name in channels),
        {run: roles.text(run, choices=ROLES) for run in roles.values if run in runs},
    )
    verdict = _verdict(top.table("diagnosis")) if "diagnosis" in top else None
    rows = top.tables("ranking", "effect") if "ranking" in top else []
    return Session(choice, verdict, tuple(map(_row, rows)))


def first_session(campaign: Campaign) -> Session:
    """That of a campaign nobody has opened: of very many runs, `MOST_RUNS` evenly spaced ones of
    either role are taken, and the others left out until somebody takes them in."""
    return Session(Choice(without_runs=_too_many(campaign.runs)))


def unread(folder: Path, runs: Sequence[Entry]) -> frozenset[str]:
    """Of very many runs, those whose recordings may wait: they are left out of the session."""
    if len(runs) <= MOST_RUNS:
        return frozenset()
    try:
        return frozenset(read_toml(folder / FILE).texts("without_runs"))
    except InputError:  # there is none yet, or it is said later what is wrong with it
        return frozenset(_too_many(runs))


def _too_many(runs: Sequence[Entry | Run]) -> tuple[str, ...]:
    if len(runs) <= MOST_RUNS:
        return ()
    kept: set[str] = set()
    for role in ROLES:
        ids = [run.id for run in runs if run.role == role]
        count = min(len(ids), max(MOST_RUNS * len(ids) // len(runs), 1))
        kept |= {ids[i * len(ids) // count] for i in range(count)}
    return tuple(run.id for run in runs if run.id not in kept)


def write_session(campaign: Campaign, session: Session, written_by: str) -> None:
    """Replace the session's file, whole or not at all; raises CampaignError where it cannot be."""
    choice, verdict = session.choice, session.verdict
    document: dict[str, Any] = {
        "format": 1,
        "written_by": written_by,
        "added": list(choice.added),
        "without_runs": list(choice.without_runs),
        "without_channels": list(choice.without_channels),
        "role": dict(choice.roles),
    }
    if verdict is not None:
        document["diagnosis"] = {k: _plain(v) for k, v in asdict(verdict).items()}
        document["ranking"] = [
            {k: _plain(v) for k, v in asdict(row).items() if v is not None}
            for row in session.ranking
        ]
    write_text(campaign.folder / FILE, to_toml(document), CampaignError)


def _plain(value: object) -> object:
    return list(value) if isinstance(value, tuple) else value


def _verdict(table: Table) -> Verdict:
    return Verdict(
        tuple(table.texts("effects")),
        table.number("confidence", at_least=0.0),
        table.text("headline"),
        tuple(table.texts("explanation")),
        table.text("next_run", default=""),
        tuple(table.texts("limits")),
    )


def _row(table: Table) -> Row:
    def number(key: str) -> float | None:
        return table.number(key) if key in table else None

    return Row(
        table.text("effect"),
        table.text("place"),
        number("screened"),
        number("confirmed"),
        number("held_out"),
        number("evidence"),
        number("p"),
        tuple(table.texts("near")),
        table.text("reason", default=""),
    )


def without(names: Sequence[str], name: str) -> tuple[str, ...]:
    """The names but one."""
    return tuple(other for other in names if other != name)


def toggled(names: Sequence[str], name: str) -> tuple[str, ...]:
    """The names with one more, or without it if it is there."""
    return without(names, name) if name in names else (*names, name)
