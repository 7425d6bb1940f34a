"""Many campaigns diagnosed, each a row of one table."""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections.abc import Sequence
from concurrent.futures import Executor
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path

from wheelhop.api.verbs import BUDGET_S, diagnose
from wheelhop.campaign import CampaignError
from wheelhop.campaign.read import CONSTANTS_FILE
from wheelhop.effects.own_file import read_source
from wheelhop.files import TABLE, Source, Watching, digest, read_bytes
from wheelhop.files.progress import shown
from wheelhop.fit.bench import processors
from wheelhop.predict.identity import identity
from wheelhop.predict.journal import run_sweep
from wheelhop.predict.sweep import Row
from wheelhop.predict.trouble import lasting
from wheelhop.predict.workers import workers

TOGETHER = " + "
"""Between the effects of a verdict."""
BEGIN_WITH = ("campaign.toml", CONSTANTS_FILE)


@dataclass(frozen=True)
class Fleet:
    """Which campaigns are diagnosed and how, as plain data that any worker anywhere can begin with.

    `library` is the text of a file with effects of one's own, `threads` how many work on one
    campaign. However a folder is spelt, it is kept as the one that leads there from anywhere.
    """

    folders: tuple[Path, ...]
    max_effects: int = 4
    library: Source | None = None
    threads: int = 1
    budget_s: float | None = BUDGET_S
    to_the_end: bool = False
    things = "campaigns"

    def __post_init__(self) -> None:
        object.__setattr__(self, "folders", tuple(folder.resolve() for folder in self.folders))

    def __len__(self) -> int:
        return len(self.folders)

    def rows(self, number: int) -> list[Row]:
        """The row of one campaign. Whatever is wrong with it stands there as `problem`: the others
        go on. Raises Trouble for what may pass."""
        folder, began_s = self.folders[number], time.monotonic()
        row: Row = {"campaign": str(folder), "verdict": "", "confidence": None}
        row |= dict.fromkeys(("error_baseline", "error", "floor", "seconds"))
        row |= {"title": "", "findings": "", "problem": ""}
        try:
            row |= self._diagnosed(folder)
        except Exception as error:
            row["problem"] = lasting(error, str(folder))
        return [row | {"seconds": time.monotonic() - began_s}]

    def _diagnosed(self, folder: Path) -> Row:
        found = diagnose(
            folder,
            effects=self.library,
            max_effects=self.max_effects,
            to_the_end=self.to_the_end,
            budget_s=self.budget_s,
            law=False,
            jobs=self.threads,
            progress=False,
        )
        row: Row = {
            "title": found.campaign.title,
            "verdict": TOGETHER.join(found.verdict),
            "confidence": found.confidence,
            "error_baseline": found.steps[0].rung.error,
            "error": found.error,
            "floor": found.floor,
            "findings": " ".join(f.text for f in found.findings if f.when == "before"),
        }
        for name, (value, deviation) in found.last.parameters.items():
            row |= {name: value, f"{name}_uncertainty": deviation}
        return row

    @property
    def fingerprint(self) -> str:
        """Differs where anything differs that the results depend on, files included."""
        known = {
            "wheelhop": identity(),
            "max_effects": self.max_effects,
            "budget_s": self.budget_s,
            "to_the_end": self.to_the_end,
            "campaigns": [[self.name(k), self.files(k)] for k in range(len(self))],
        }
        return hashlib.sha256(json.dumps(known).encode()).hexdigest()

    def name(self, number: int) -> str:
        """The folder."""
        return str(self.folders[number])

    def files(self, number: int) -> str:
        """Differs where a file differs that the result for a campaign depends on."""
        found = _digests(self.folders[number])
        found += [] if self.library is None else [self.library.digest]
        return hashlib.sha256("\n".join(found).encode()).hexdigest()


def diagnose_fleet(
    folders: Sequence[str | Path],
    table: str | Path,
    *,
    effects: str | Path | None = None,
    max_effects: int = 4,
    to_the_end: bool = False,
    budget_s: float | None = BUDGET_S,
    jobs: int | None = None,
    executor: Executor | None = None,
    progress: Watching = True,
) -> list[Row]:
    """Diagnose campaigns, each on a processor of its own, and write a Parquet table with a row for
    each: verdict, confidence, errors, fitted numbers, and `problem`, what kept it from a verdict.

    Parameters
    ----------
    folders
        The campaigns' folders.
    table
        The table, .parquet. What is finished stands in a journal beside it meanwhile: whatever ends
        the program, the same call goes on from there.
    effects
        A Python file with effects of one's own.
    max_effects, to_the_end, budget_s, progress
        As for `diagnose`.
    jobs
        Processes; one a processor by default.
    executor
        What does the work instead, any `concurrent.futures.Executor`: that of a cluster, say, where
        the folders have the same names.

    Returns
    -------
    list of dict
        The rows of the table, in the order of the folders; numbers in SI.

    Raises
    ------
    CampaignError
        The table is there already, and of other campaigns or of these as they were before.
    """
    given = tuple(Path(folder).resolve() for folder in folders)
    if len(set(given)) < len(given) or not given:
        raise CampaignError("name one campaign or more, each once")
    many = jobs or processors()
    fleet = Fleet(
        given,
        max_effects,
        None if effects is None else read_source(Path(effects)),
        1 if executor else max(1, many // len(given)),
        budget_s,
        to_the_end,
    )
    pool = workers(min(many, len(given))) if executor is None else nullcontext(executor)
    with pool as working, shown(progress) as tell:
        return run_sweep(fleet, Path(table), working, tell)[1]


def _digests(folder: Path) -> list[str]:
    """Of the files that campaign.toml names, and those that these name in turn; what wheelhop
    writes into the folder does not count."""
    called: dict[str, list[Path]] = {}
    for path in folder.rglob("*"):
        if path.is_file():
            called.setdefault(path.name, []).append(path)
    found = {folder / name for name in BEGIN_WITH if (folder / name).is_file()}
    new = list(found)
    while new:
        file = new.pop()
        if file.suffix == ".toml":
            text = read_bytes(file, CampaignError, TABLE).decode("utf-8", errors="replace")
            named = {p for name in re.split(r"[\"'/\\]", text) for p in called.get(name, ())}
            new += named - found
            found |= named
    return [f"{path.relative_to(folder)} {digest(path)}" for path in sorted(found)]
