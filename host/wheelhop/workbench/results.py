"""What was found, kept by what it was made of: whoever comes back to it finds it again."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypeVar

from wheelhop.workbench.shown import (
    AxleToBody,
    CanShow,
    Concluded,
    Diagnosed,
    Law,
    Ranking,
    Row,
    Settings,
    Trace,
)

Made = tuple[str, tuple[str, ...]]
"""What a result is made of: the key of the data and the effects there are (`session.made_of`), and
the effects in the model. A diagnosis begins at the baseline, so that only the key counts."""

Found = Law | AxleToBody | CanShow | Settings
Beside = TypeVar("Beside", Law, AxleToBody, CanShow, Settings)


@dataclass(frozen=True, eq=False)
class Results:
    """Diagnoses that ended; rankings with their signatures, of these or as far as they came; the
    ranking under way, if there is one; and what was found beside a model."""

    diagnoses: Mapping[str, Diagnosed] = field(default_factory=dict)
    rankings: Mapping[str, Ranking] = field(default_factory=dict)
    underway: Mapping[str, Ranking] = field(default_factory=dict)
    others: Mapping[tuple[type, Made], Found] = field(default_factory=dict)

    def ranking(self, made: Made) -> Ranking | None:
        """The ranking under way, or the last one."""
        key, _ = made
        if key in self.underway:
            return self.underway[key]
        if key not in self.rankings and key in self.diagnoses:
            return Ranking((), self.diagnoses[key].ranking, {})
        return self.rankings.get(key)

    def diagnosis(self, made: Made) -> Diagnosed | None:
        """What the last diagnosis that ended came to."""
        return self.diagnoses.get(made[0])

    def beside(self, kind: type[Beside], made: Made) -> Beside | None:
        """What was found of this kind beside the model."""
        found = self.others.get((kind, made))
        return found if isinstance(found, kind) else None

    def heard(self, made: Made, message: Ranking | Concluded | Found) -> Results:
        """The worker has found something. Effects are ranked beside the baseline; what comes
        beside the effects accepted is on the way to the verdict."""
        key, _ = made
        match message:
            case Ranking(beside=()):
                traces = _traces(self.ranking(made)) | dict(message.traces)
                return replace(self, underway={key: replace(message, traces=traces)})
            case Concluded(verdict, findings, case):
                ranking = self.underway[key]
                ended = Diagnosed(verdict, ranking.rows, findings, case)
                return replace(
                    self,
                    diagnoses={**self.diagnoses, key: ended},
                    rankings={**self.rankings, key: ranking},
                    underway={},
                )
            case Law() | AxleToBody() | CanShow() | Settings():
                return replace(self, others={**self.others, (type(message), made): message})
        return self

    def stopped(self) -> Results:
        """The work has ended, or was given up. An earlier ranking stays if it is of a diagnosis
        that ended, or knows more; a signature that was drawn stays in any case."""
        rankings = dict(self.rankings)
        for key, found in self.underway.items():
            before = replace(self, underway={}).ranking((key, ()))
            stays = before is not None and (
                key in self.diagnoses or _known(before.rows) > _known(found.rows)
            )
            rankings[key] = replace(before, traces=found.traces) if before and stays else found
        return replace(self, rankings=rankings, underway={})


def _traces(ranking: Ranking | None) -> dict[str, Trace]:
    return {} if ranking is None else dict(ranking.traces)


def _known(rows: tuple[Row, ...]) -> int:
    """How many effects have been simulated in full."""
    return sum(row.confirmed is not None for row in rows)
