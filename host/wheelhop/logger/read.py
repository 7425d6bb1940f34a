"""From a file to a `Log`, whatever has happened to the file."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from wheelhop.logger.beside import Beside, joined
from wheelhop.logger.block import (
    BESIDE,
    BLOCK_BYTES,
    CRC_AT,
    DATA,
    FIELDS,
    HEADER,
    PAYLOAD_AT,
    SUMMARY,
    SUPPLY,
    parse_text,
)
from wheelhop.logger.log import Damage, Log, Supply
from wheelhop.logger.settings import block_capacity, find_settings, number
from wheelhop.logger.survey import (
    Progress,
    Verdict,
    agreeing,
    open_source,
    pieces,
    read_bytes,
    survey,
    unroll,
)

SETTINGS_KEYS = (
    *("device", "calibration", "rate_hz", "conversions", "channels"),
    *("order", "sum_bits", "code_bits", "conversions_hz"),
)


def read_log(
    source: Path | bytes,
    *,
    header_from: Log | None = None,
    progress: Progress = lambda done: None,
) -> Log:
    """Read a log file (or its bytes), whatever has happened to it.

    The scans stay in the file: `Log.scans` and `Log.recording` fetch them. Where the header is
    damaged, that of `header_from`, another log with the same settings, stands in. Raises
    LoggerError where there is no session, OSError where there is no file.
    """
    name = str(source) if isinstance(source, Path) else "log"
    seen = survey(source, name, progress)
    verdicts, facts = seen.verdicts, seen.facts
    headers = facts[:1][(facts["block"][:1] == 0) & (facts["kind"][:1] == HEADER[0])]
    header = _text(source, 0) if len(headers) else {}
    if header_from is not None and find_settings(header) is None:
        header |= borrowed_header(header_from)
    keep = agreeing(facts, block_capacity(header))
    verdicts[facts["block"][~keep]] = Verdict.CONTRADICTS
    facts = facts[keep]
    closings = np.flatnonzero(facts["kind"] == SUMMARY[0])
    if len(closings):
        facts = facts[: closings[0] + 1]
    unroll(facts)
    last = facts[-1:] if len(facts) else np.zeros(1, facts.dtype)
    end = int(last["block"][0]) + 1
    data = facts[facts["kind"] == DATA[0]]
    return Log(
        source,
        name,
        seen.session,
        header,
        _text(source, end - 1) if len(closings) else None,
        data,
        due=int((last["first_scan"] + last["count"])[0]),
        lost=int(last["lost"][0]),
        late=int(last["late"][0]),
        supply=_supply(source, facts[facts["kind"] == SUPPLY[0]]["block"]),
        beside=_beside(source, facts[facts["kind"] == BESIDE[0]]["block"], header),
        damage=_damage(verdicts[:end]),
        end_block=end,
        behind=len(verdicts) - end,
        spare_bytes=seen.spare_bytes,
    )


def borrowed_header(log: Log) -> dict[str, str]:
    """Return what the header of another session with the same logger and settings would say."""
    header = {key: log.header[key] for key in SETTINGS_KEYS if key in log.header}
    return header | {"header_from": Path(log.name).name}


def _text(source: Path | bytes, block: int) -> dict[str, str]:
    with open_source(source) as file:
        for _, blocks in pieces(file, block):
            return parse_text(blocks.view(FIELDS)[0, 0]["payload"].tobytes())
    return {}


def _supply(source: Path | bytes, blocks: NDArray[np.int64]) -> tuple[Supply, ...]:
    readings = []
    with open_source(source) as file:
        for block in blocks:
            file.seek(int(block) * BLOCK_BYTES)
            text = parse_text(bytes(read_bytes(file, BLOCK_BYTES)[PAYLOAD_AT:CRC_AT]))
            readings.append(Supply(int(number(text, "scan")), number(text, "supply_mv")))
    return tuple(reading for reading in readings if reading.mv > 0)


def _beside(
    source: Path | bytes, blocks: NDArray[np.int64], header: Mapping[str, str]
) -> Beside | None:
    payloads = []
    with open_source(source) as file:
        for block in blocks:
            file.seek(int(block) * BLOCK_BYTES)
            payloads.append(bytes(read_bytes(file, BLOCK_BYTES)[PAYLOAD_AT:CRC_AT]))
    settings = find_settings(header)
    return joined(payloads, settings, header) if payloads and settings else None


def _damage(verdicts: NDArray[np.uint8]) -> tuple[Damage, ...]:
    edges = np.flatnonzero(np.diff(verdicts)) + 1
    begins = np.concatenate([[0], edges]) if len(verdicts) else edges
    lengths = np.diff(np.append(begins, len(verdicts)))
    return tuple(
        Damage(int(begin) * BLOCK_BYTES, int(length), Verdict(verdicts[begin]))
        for begin, length in zip(begins, lengths, strict=True)
        if verdicts[begin] != Verdict.GOOD
    )
