"""What the recorder itself tells of its health: gaps, supply, restarts, late conversions."""

from collections.abc import Iterator

from wheelhop.calibration.health.finding import CERTAIN, LIKELY, Finding
from wheelhop.calibration.sync.delay import stretches
from wheelhop.logger.recording import Recording
from wheelhop.logger.supply import SAG, supply_change

LOW_SUPPLY_MV = 2900.0  # 3.3 V less what the logger's own reading may be off, ±10 %
GAPS_TOLD = 5  # longest gaps that get a line of their own


def recorder_findings(recording: Recording) -> Iterator[Finding]:
    """Gaps in the samples, and what the notes of the log say."""
    yield from _gaps(recording)
    start, stop = recording.start_s, recording.start_s + len(recording.values) / recording.rate_hz
    notes = recording.notes
    first, last = (_number(notes.get(key, "")) for key in ("supply_mv", "end_supply_mv"))
    if change := supply_change(notes):
        yield Finding(
            "supply", (), change.text, LIKELY, abs(change.relative) / SAG, start, stop,
            "charge or change the battery; ratiometric gains hold, the sensors' range does not",
        )  # fmt: skip
    elif 0 < (lowest := min(v for v in (first or 1e9, last or 1e9))) < LOW_SUPPLY_MV:
        yield Finding(
            "supply", (), f"the sensors' supply is {lowest:.0f} mV, not 3300", LIKELY,
            LOW_SUPPLY_MV / lowest, start, stop, "check the battery and the 3.3 V regulator",
        )  # fmt: skip
    if notes.get("reset") == "brown-out":
        yield Finding(
            "brown-out", (), "the logger had been restarted by a dip of its supply", CERTAIN, 1.0,
            start, start, "check battery, plug and wires: the supply broke down before",
        )  # fmt: skip
    late = _number(notes.get("late", ""))
    if late:
        yield Finding(
            "late", (), f"{late:.0f} conversions came late, by 0.16 ms each", CERTAIN, late,
            start, stop, "times allow for it; tell the makers of the firmware",
        )  # fmt: skip


def _gaps(recording: Recording) -> Iterator[Finding]:
    missing = recording.missing
    if not missing.any():
        return
    found = sorted(stretches(missing), key=lambda gap: gap[0] - gap[1])
    for start, stop in found[:GAPS_TOLD]:
        seconds = (stop - start) / recording.rate_hz
        yield Finding(
            "gap", (), f"{stop - start} samples are missing ({seconds:.3g} s)", CERTAIN,
            float(stop - start), recording.start_s + start / recording.rate_hz,
            recording.start_s + stop / recording.rate_hz,
            "wheelhop info tells why; cut the run there",
        )  # fmt: skip
    if len(found) > GAPS_TOLD:
        rest = sum(stop - start for start, stop in found[GAPS_TOLD:])
        first = min(start for start, _ in found[GAPS_TOLD:])
        yield Finding(
            "gap", (), f"{len(found) - GAPS_TOLD} shorter gaps with {rest} samples", CERTAIN,
            float(rest), recording.start_s + first / recording.rate_hz,
            recording.start_s + len(missing) / recording.rate_hz,
            "the card is slow or the line noisy: wheelhop info tells",
        )  # fmt: skip


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return 0.0
