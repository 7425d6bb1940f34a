"""Is a recording fit for use? Everything that can be told from the samples alone."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

from wheelhop.calibration.health.channel import channel_findings
from wheelhop.calibration.health.finding import CERTAIN, LIKELY, POSSIBLE, Finding
from wheelhop.calibration.health.motion import moves_in_phase
from wheelhop.calibration.health.recorder import recorder_findings
from wheelhop.calibration.health.relations import Change, relate
from wheelhop.calibration.health.spectrum import spectrum_findings
from wheelhop.logger.recording import Recording

SPOILS_RELATIONS = {"stuck", "dead", "level"}
SPOILS_SPECTRA = {*SPOILS_RELATIONS, "clipping"}
ORDER = (CERTAIN, LIKELY, POSSIBLE)


@dataclass(frozen=True)
class Health:
    """`findings`, the surest first; `untold`: what could not be judged, and why, a line each."""

    findings: tuple[Finding, ...]
    untold: tuple[str, ...]

    @property
    def healthy(self) -> bool:
        """Nothing was found, which is not the same as nothing being wrong: see `untold`."""
        return not self.findings


def examine(
    recording: Recording, others: Sequence[Recording] = (), *, relations: bool = True
) -> Health:
    """Examine a recording in codes or m/s².

    `others` are further recordings with the same sensors in the same places: which channel is
    inverted and which are exchanged is judged on all of them together, the rest on `recording`.
    Without `relations` that judgement is left out.
    """
    of_channels = tuple(channel_findings(recording))
    findings = [*recorder_findings(recording), *of_channels]
    spoilt = {name for f in findings if f.kind in SPOILS_SPECTRA for name in f.channels}
    findings += spectrum_findings(recording, spoilt)
    untold: tuple[str, ...] = ()
    if relations:
        known = chain(of_channels, *map(channel_findings, others))
        related, untold = examine_relations((recording, *others), known)
        findings += related
    return Health(tuple(sorted(findings, key=lambda f: ORDER.index(f.sure))), untold)


def examine_relations(
    recordings: Sequence[Recording], known: Iterable[Finding] | None = None
) -> tuple[tuple[Finding, ...], tuple[str, ...]]:
    """Polarity and exchange of the eight points of a vehicle, and what cannot be told of them;
    `known` is what was found of each channel, if they were examined."""
    if known is None:
        known = chain.from_iterable(map(channel_findings, recordings))
    spoilt = {name for f in known if f.kind in SPOILS_RELATIONS for name in f.channels}
    if spoilt:
        return (), (f"polarity and exchange: not judged while {_names(spoilt)} gives no signal",)
    driven = [recording for recording in recordings if not moves_in_phase(recording)]
    if not driven:
        return (), (
            "polarity and exchange: all channels move in phase or antiphase, as on a beam and"
            " not in a vehicle; wheelhop sync-check judges those",
        )
    relations = relate(driven)
    if relations is None:
        return (), (
            "polarity and exchange: need A1 … A4 and B1 … B4 for 4 s or more, or a session on a"
            " beam (wheelhop sync-check)",
        )
    if relations.settled and not relations.untold:
        return (), ()
    if relations.mending:
        return (_finding(recordings, relations.mending, relations.as_is.misfit),), ()
    if relations.broken:
        return (), (
            "polarity and exchange: no single change makes struts and body agree; there may be"
            " two, or a vehicle far from linear",
        )
    return (), _untold(relations.untold)


def _finding(recordings: Sequence[Recording], mending: Sequence[Change], misfit: float) -> Finding:
    best = mending[0]
    kinds = {change.kind for change in mending}
    channel = {c.point or c.name: c.name for c in recordings[0].channels}
    said = " or ".join(
        f"{' and '.join(channel[p] for p in change.points)}"
        f" {'are exchanged' if change.kind == 'swapped' else 'is inverted'}"
        for change in mending
    )
    first = recordings[0]
    return Finding(
        best.kind if len(kinds) == 1 else "relation",
        tuple(dict.fromkeys(channel[p] for change in mending for p in change.points)),
        f"{said}: struts and rigid body agree {misfit / best.misfit:.0f} times better that way",
        LIKELY if len(mending) == 1 else POSSIBLE,
        misfit / best.misfit,
        first.start_s,
        first.start_s + len(first.values) / first.rate_hz,
        "look at the sensors named; turn one over or push one, and watch which channel moves",
    )


def _untold(changes: Sequence[Change]) -> tuple[str, ...]:
    if not changes:
        return ()
    inverted = _names({p for c in changes if c.kind == "polarity" for p in c.points})
    swapped = ", ".join(" with ".join(c.points) for c in changes if c.kind == "swapped")
    parts = [f"whether {inverted} is inverted"] if inverted else []
    parts += [f"whether {swapped} are exchanged"] if swapped else []
    hint = "examine runs on different tracks together"
    return tuple(f"{part}: would not show here; {hint}" for part in parts)


def _names(names: set[str]) -> str:
    return ", ".join(sorted(names))
