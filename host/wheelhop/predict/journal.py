"""The results of a sweep: a journal while it runs, one Parquet table when it is done.

The journal, TABLE.parquet.journal, has one line of JSON for each point that is finished, and is
brought to the disk line by line. Whatever ends the program, at most the line being written is lost,
and the same command goes on where it was.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from concurrent.futures import BrokenExecutor, Executor, as_completed
from functools import partial
from pathlib import Path
from platform import node
from typing import Any, Protocol

import pyarrow as pa
import pyarrow.parquet as pq

from wheelhop.campaign import CampaignError
from wheelhop.files import TABLE, check_target, claimed, read_bytes, replacing, sync_folder
from wheelhop.formats.parquet import read_table
from wheelhop.predict.sweep import Row
from wheelhop.predict.trouble import Trouble
from wheelhop.predict.workers import Workers

SWEEP = b"wheelhop.sweep"
"""Under which key the table's metadata hold the sweep's fingerprint."""


class Points(Protocol):
    """What can be computed a point at a time: the `fingerprint` differs where its results may, and
    `things` are what a user calls the points. It is sent to the workers."""

    things: str

    @property
    def fingerprint(self) -> str:
        """As above."""

    def __len__(self) -> int: ...

    def name(self, number: int) -> str:
        """What a user calls a point."""

    def files(self, number: int) -> str:
        """Differs where a file differs that a point depends on. Raises OSError."""

    def rows(self, number: int) -> list[Row]:
        """What is found at a point: rows of texts, numbers and None, the same texts in all.
        Raises Trouble, OSError or MemoryError where nothing is."""


def run_sweep(
    sweep: Points,
    table: Path,
    executor: Executor,
    progress: Callable[[str], None] = lambda text: None,
) -> tuple[int, list[Row]]:
    """Compute what is missing of a sweep and write its table.

    Any `concurrent.futures.Executor` does the work. Returns how many points were computed now, and
    all rows. Raises CampaignError if the table, or the journal, belongs to another sweep, and if a
    computer had trouble with a point that may pass: then all others are in the journal.
    """
    check_target(table, CampaignError)
    journal = table.with_name(f"{table.name}.journal")
    check_target(journal, CampaignError)
    mark = sweep.fingerprint
    with claimed(table.parent, f"sweep to {table.name}", CampaignError):
        if table.exists():
            return 0, _read_table(table, mark)
        done = _read_journal(journal, mark)
        missing = [number for number in range(len(sweep)) if number not in done]
        with journal.open("a", encoding="utf-8") as file:
            if not done and file.tell() == 0:
                _append(file, {"sweep": mark})
                sync_folder(table.parent)
            futures = {
                executor.submit(partial(_rows, sweep, sweep.files(number)), number): number
                for number in missing
            }
            troubles: list[Trouble] = []

            def keep(number: int, rows: list[Row]) -> None:
                done[number] = rows
                _append(file, {"point": number, "rows": rows})

            try:
                for future in as_completed(futures):
                    try:
                        keep(futures[future], future.result())
                    except Trouble as error:
                        troubles.append(error)
                    progress(f"{len(done)} of {len(sweep)} {sweep.things}")
            except BrokenExecutor:
                raise CampaignError(
                    f"{journal}: a process that was computing has ended, for want of memory"
                    " perhaps: the same command goes on from here; --jobs 1 takes less"
                ) from None
            except BaseException:
                for future, number in futures.items():
                    if not isinstance(executor, Workers):  # those end where their block does
                        future.cancel()
                    there = future.done() and not future.cancelled() and not future.exception()
                    if there and number not in done:
                        keep(number, future.result())
                raise
        if troubles:
            raise CampaignError(
                f"{journal}: {len(troubles)} of {len(sweep)} {sweep.things} are not done for"
                f" trouble that may pass, the first: {troubles[0]}; mend it, and the same command"
                " goes on from here"
            )
        rows = [row for number in range(len(sweep)) for row in done[number]]
        _write_table(table, rows, mark)
        journal.unlink()
    return len(missing), rows


def _rows(points: Points, files: str, number: int) -> list[Row]:
    """The rows of a point, computed from the very `files` that its table is of. Raises Trouble
    where this computer has others or none, and for all else that may pass."""
    place = f"{node()}: {points.name(number)}"
    try:
        rows = points.rows(number) if points.files(number) == files else []
        wrong = any(row.get("problem") for row in rows)
        if rows and not (wrong and points.files(number) != files):
            return rows
    except (Trouble, OSError, MemoryError) as error:
        what = str(error) or type(error).__name__
        raise Trouble(f"{place}: {what}") from None
    raise Trouble(f"{place}: this computer does not see the same files there as the command does")


def _append(file: Any, line: dict[str, Any]) -> None:
    file.write(json.dumps(line) + "\n")
    file.flush()
    os.fsync(file.fileno())


def _read_journal(journal: Path, mark: str) -> dict[int, list[Row]]:
    """Finished points; a line that was being written when the program ended is cut off."""
    if not journal.exists():
        return {}
    data = read_bytes(journal, CampaignError, TABLE)
    whole = data[: data.rfind(b"\n") + 1]
    try:
        lines = [json.loads(line) for line in whole.splitlines()]
        if lines and lines[0]["sweep"] != mark:
            raise CampaignError(
                f"{journal}: is that of another sweep: delete it, or choose another --out"
            )
        done = {int(line["point"]): line["rows"] for line in lines[1:]}
    except (ValueError, KeyError, TypeError, IndexError) as error:
        if isinstance(error, CampaignError):
            raise
        raise CampaignError(f"{journal}: is no journal of a sweep: delete it") from None
    if len(whole) < len(data):
        with journal.open("r+b") as file:
            file.truncate(len(whole))
    return done


def _write_table(table: Path, rows: list[Row], mark: str) -> None:
    names = dict.fromkeys(name for row in rows for name in row)
    columns = {name: _column([row.get(name) for row in rows]) for name in names}
    made = pa.table(columns).replace_schema_metadata({SWEEP: mark})
    with replacing(table, CampaignError) as draft:
        pq.write_table(made, draft)


def _column(values: list[str | float | None]) -> pa.Array:
    texts = any(isinstance(value, str) for value in values)
    return pa.array(values, pa.string() if texts else pa.float64())


def _read_table(table: Path, mark: str) -> list[Row]:
    try:
        found = read_table(table, CampaignError)
    except (pa.ArrowException, OSError):
        found = None
    if found is None or (found.schema.metadata or {}).get(SWEEP) != mark.encode():
        raise CampaignError(
            f"{table}: is there already, and not of this sweep: choose another --out"
        )
    rows: list[Row] = found.to_pylist()
    return rows
