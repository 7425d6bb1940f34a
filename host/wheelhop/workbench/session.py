"""What the user decided and what diagnoses found, kept in the campaign's folder: session.toml."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from wheelhop.campaign import Campaign, CampaignError, ComponentCampaign, Run
from wheelhop.campaign.change import Change, Proposal
from wheelhop.campaign.common import Entry
from wheelhop.campaign.paths import named_by
from wheelhop.campaign.read import CONSTANTS_FILE
from wheelhop.files import InputError, Source, Table, digest, read_toml, to_toml, write_text
from wheelhop.workbench.compared import Compared, of_table, to_table
from wheelhop.workbench.shown import Diagnosed, Found, Row, Verdict

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

    def role_of(self, run: Run) -> str:
        """Whether a run is fitted or held out."""
        return self.roles.get(run.id, run.role)

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
            replace(run, role=self.role_of(run), record=run.record[:, kept])
            for run in campaign.runs
            if run.id not in left_out
        )
        if not kept or not any(run.role == "fit" for run in runs):
            raise CampaignError(
                f"{campaign.folder}: no run that is fitted is left, or no channel: take one back in"
            )
        return replace(campaign, runs=runs, channels=tuple(campaign.channels[i] for i in kept))


def made_of(campaign: Campaign, choice: Choice, effects_file: Source | None = None) -> str:
    """A key that differs where anything differs that a diagnosis is made of: the runs taken, their
    recordings and roles and how they were driven; the channels; the vehicle; the constants of the
    sensors; effects of one's own. The effects added do not count: a diagnosis adds its own."""
    runs = [
        (
            *(run.id, choice.role_of(run), run.speed_m_s, run.course),
            *(run.track.kind, _contents(run.track.values), _digest(run.file)),
        )
        for run in campaign.runs
        if run.id not in choice.without_runs
    ]
    channels = [c for c in campaign.channels if c.name not in choice.without_channels]
    files = [campaign.vehicle_file, campaign.folder / CONSTANTS_FILE]
    if isinstance(campaign, ComponentCampaign):
        files += [campaign.mount_file] if campaign.mount_file else []
    else:
        files += _beside(campaign.vehicle_file)
    recorder = campaign.sample_rate_hz, campaign.averaging_s, campaign.low_pass
    turned = (sorted(campaign.factors.items()),) if campaign.factors else ()
    settings = (*recorder, campaign.band_hz, campaign.noise_rms, *turned)
    own = None if effects_file is None else effects_file.digest
    known = (settings, channels, runs, [_digest(file) for file in files], own)
    return hashlib.sha256(repr(known).encode()).hexdigest()


def _contents(values: Mapping[str, float | str]) -> list[tuple[str, float | str]]:
    """A track's values; of a file what is in it, wherever the campaign's folder lies."""
    return sorted((k, _digest(Path(str(v))) if k == "file" else v) for k, v in values.items())


def _beside(vehicle: Path) -> list[Path]:
    try:
        return list(named_by(vehicle))
    except InputError:  # nothing can be fitted then, and the fit says why
        return []


def _digest(file: Path) -> str:
    try:
        return digest(file)
    except (OSError, InputError):
        return "not there"


@dataclass(frozen=True)
class Session:
    """A choice, what diagnoses came to, by what each was made of, and what Compare showed last."""

    choice: Choice = field(default_factory=Choice)
    diagnoses: Mapping[str, Diagnosed] = field(default_factory=dict)
    looked_at: Compared | None = None


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
    looked_at = of_table(top.table("compared"), campaign) if "compared" in top else None
    return Session(choice, _diagnoses(top, campaign, choice), looked_at)


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


def unread_words(campaign: Campaign) -> str:
    """Which recordings were not read, if any."""
    runs = campaign.runs
    waiting = sum(not len(run.time_s) for run in runs)
    if not waiting:
        return ""
    return (
        f"{len(runs)} runs: {len(runs) - waiting} were read, evenly spaced; the other"
        f" {waiting} are left out, and not read until you take them in"
    )


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
    choice = session.choice
    document: dict[str, Any] = {
        "format": 1,
        "written_by": written_by,
        "added": list(choice.added),
        "without_runs": list(choice.without_runs),
        "without_channels": list(choice.without_channels),
        "role": dict(choice.roles),
    }
    if session.looked_at is not None:
        document["compared"] = to_table(session.looked_at)
    document["diagnosis"] = [
        {
            "made_of": key,
            **_plain(found.verdict),
            **_fixes_to(found.verdict.fixes),
            "finding": [
                {"severity": f.severity, "text": f.text, **_fixes_to(f.fixes)}
                for f in found.findings
            ],
            "ranking": [_plain(row) for row in found.ranking],
        }
        for key, found in session.diagnoses.items()
    ]
    write_text(campaign.folder / FILE, to_toml(document), CampaignError)


def _fixes_to(fixes: Sequence[Proposal]) -> dict[str, object]:
    found = [
        {
            "title": fix.title,
            "change": [
                {"file": c.file, "keys": list(c.keys), "value": c.value} for c in fix.changes
            ],
        }
        for fix in fixes
    ]
    return {"fix": found} if found else {}


def _fixes_of(table: Table) -> tuple[Proposal, ...]:
    return tuple(
        Proposal(
            fix.text("title"),
            tuple(
                Change(c.text("file"), tuple(c.texts("keys")), c.text("value", default=""))
                for c in _tables(fix, "change", "file")
            ),
        )
        for fix in _tables(table, "fix", "title")
    )


def _plain(item: Verdict | Row) -> dict[str, object]:
    values = {k: v for k, v in asdict(item).items() if v is not None and k != "fixes"}
    return {key: list(v) if isinstance(v, tuple) else v for key, v in values.items()}


def _diagnoses(top: Table, campaign: Campaign, choice: Choice) -> dict[str, Diagnosed]:
    if isinstance(top.values.get("diagnosis"), dict):  # before there could be several
        rows = _tables(top, "ranking", "effect")
        found = Diagnosed(_verdict(top.table("diagnosis")), tuple(map(_row, rows)))
        return {made_of(campaign, choice): found}
    return {
        table.text("made_of"): Diagnosed(
            _verdict(table),
            tuple(map(_row, _tables(table, "ranking", "effect"))),
            tuple(
                Found(t.text("severity"), t.text("text"), _fixes_of(t))
                for t in _tables(table, "finding", "text")
            ),
        )
        for table in _tables(top, "diagnosis", "headline")
    }


def _tables(table: Table, key: str, name_key: str) -> list[Table]:
    return table.tables(key, name_key) if key in table else []


def _verdict(table: Table) -> Verdict:
    return Verdict(
        tuple(table.texts("effects")),
        table.number("confidence", at_least=0.0),
        table.text("headline"),
        tuple(table.texts("explanation")),
        table.text("next_run", default=""),
        tuple(table.texts("limits")),
        table.text("numbers", default=""),
        _fixes_of(table),
        tuple(table.texts("answers")),
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
