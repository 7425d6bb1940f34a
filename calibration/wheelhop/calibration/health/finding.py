"""What an examination finds, in words for people and in numbers for programs."""

from dataclasses import dataclass

CERTAIN, LIKELY, POSSIBLE = "certain", "likely", "possible"


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong with a recording.

    `kind` is one of "gap", "supply", "brown-out", "late", "clipping", "stuck", "dead", "level",
    "drift", "hum", "mount", "polarity", "swapped" or "relation" (one of the last two). `channels`
    are concerned, all of them if empty. `what` says it with its figures, `sure` is "certain",
    "likely" or "possible"; `strength` is how many times the threshold it is.
    `start_s` … `stop_s` is where, by the recorder's clock; `remedy` what to do.
    """

    kind: str
    channels: tuple[str, ...]
    what: str
    sure: str
    strength: float
    start_s: float
    stop_s: float
    remedy: str
