"""What the page shows: plain numbers, words and finished drawings, all that the worker sends.

Nothing here refers to a fit or a model, so that the page's process never loads what computes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from wheelhop.campaign.change import Proposal

Samples = NDArray[np.float32]
Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Pair:
    """One signal (n,) as measured and as modelled."""

    measured: Samples
    modelled: Samples


@dataclass(frozen=True, eq=False)
class Signals:
    """One run in band: measured and modelled (n, channels), in the channels' units. Channels the
    model does not predict are zero in both. `measured_m` and `modelled_m` are those of
    accelerations as heights, `position_m` (n,) is the modelled place of the front axle, None where
    it has none. `loop` holds force, displacement and velocity of a component on a rig, SI."""

    rate_hz: float
    measured: Samples
    modelled: Samples
    measured_m: Samples
    modelled_m: Samples
    position_m: Samples | None
    loop: Mapping[str, Pair] = field(default_factory=dict)


@dataclass(frozen=True)
class Shape:
    """The size of a fitted vehicle: what a drawing of it needs."""

    wheelbase_m: float
    track_width_m: float
    radius_m: float


@dataclass(frozen=True)
class Number:
    """One of the vehicle's numbers: nominal and fitted, each with one standard deviation, SI."""

    nominal: float
    believed: float
    fitted: float
    known: float


@dataclass(frozen=True, eq=False)
class Rung:
    """One model of the ladder: which effects it has, the error E it leaves, and where.

    ``error`` is E on the runs that judge, ``floor`` what the sensors' noise alone leaves of them;
    ``error_fit`` and ``floor_fit`` are those of the runs fitted. ``ratio`` (runs, channels) is
    residual over floor, NaN where the model predicts nothing. ``points`` say where the channels
    sit. ``shape`` is the vehicle's, None of a component; ``numbers`` are its numbers, by their
    dotted names. ``html`` holds finished sections: "ladder" (up to this rung), "where", "struts"
    and "model".
    """

    added: tuple[str, ...]
    error: float
    error_fit: float
    floor: float
    floor_fit: float
    at_floor: bool
    runs: tuple[str, ...]
    channels: tuple[str, ...]
    points: tuple[str, ...]
    shape: Shape | None
    numbers: Mapping[str, Number]
    ratio: Array
    noise_rms: Array
    signals: Mapping[str, Signals]
    sentences: tuple[str, ...]
    html: Mapping[str, str]

    @property
    def over_floor(self) -> float:
        """Error over floor; NaN where nothing is known of the noise."""
        return self.error / self.floor if self.floor > 0 else float("nan")


@dataclass(frozen=True, eq=False)
class Trace:
    """The residual of one channel in one run, in band, and what an effect would make of it there
    (first order), both (n,)."""

    run: str
    channel: str
    unit: str
    time_s: Array
    residual: Array
    signature: Array


@dataclass(frozen=True)
class Row:
    """One effect of the ranking: errors E as screened, confirmed in full simulation and held out
    (None: not known yet), logarithm of the evidence, p, and why it stands where it stands."""

    effect: str
    place: str
    screened: float | None
    confirmed: float | None
    held_out: float | None
    evidence: float | None
    p: float | None
    near: tuple[str, ...]
    reason: str


@dataclass(frozen=True, eq=False)
class Ranking:
    """What a look at the residual of a model has found so far; `beside` names the effects that
    model has. `traces` are those of the effects that came out best."""

    beside: tuple[str, ...]
    rows: tuple[Row, ...]
    traces: Mapping[str, Trace]


@dataclass(frozen=True)
class Card:
    """What an effect is: for people who meet it the first time."""

    effect: str
    place: str
    title: str
    equation: str  #: SVG
    source: str


@dataclass(frozen=True)
class Found:
    """What is to be known before one believes a verdict: how sure it is, the sentence with its
    remedy, and changes of the campaign's files that are that remedy."""

    severity: str
    text: str
    fixes: tuple[Proposal, ...] = ()


@dataclass(frozen=True)
class Verdict:
    """The end of a diagnosis in words: effects named, confidence (0 to 1), a sentence, its grounds,
    what to record next ("" if nothing), from where on these runs would have shown the other
    effects, what those named came to in numbers, with the error they leave, changes of the
    campaign's files where it is these that are wrong, and the report's answers in plain words."""

    effects: tuple[str, ...]
    confidence: float
    headline: str
    explanation: tuple[str, ...]
    next_run: str
    limits: tuple[str, ...] = ()
    numbers: str = ""
    fixes: tuple[Proposal, ...] = ()
    answers: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Case:
    """One channel of one run where the first model fails worst, in band: measured, and as the first
    and the last model of a diagnosis have it, each (n,); `after` is None where they are one."""

    run: str
    channel: str
    unit: str
    time_s: Array
    measured: Array
    before: Array
    after: Array | None


@dataclass(frozen=True)
class Law:
    """A force of free form that explains what is left: words in a fixed pitch, and its picture
    (SVG; "" where nothing was found or nothing tells how that place moved)."""

    lines: tuple[str, ...]
    figure: str


@dataclass(frozen=True)
class AxleToBody:
    """What was identified between axle and body beside the model chosen: a finished section."""

    html: str


@dataclass(frozen=True)
class Settings:
    """How settings of one vehicle differ: finished sections."""

    html: str


@dataclass(frozen=True)
class CanShow:
    """What these channels and roads can show, before any diagnosis: of every effect from where on
    it would be seen, and a sentence on the channel that would add most, or why nothing can be."""

    effects: Mapping[str, str]
    sentence: str


@dataclass(frozen=True)
class Diagnosed:
    """What a diagnosis came to: its verdict, the ranking, what it found that is to be known before
    one believes it, and a place to see it (None: not kept)."""

    verdict: Verdict
    ranking: tuple[Row, ...]
    findings: tuple[Found, ...] = ()
    case: Case | None = None


# What the worker says, in the order in which it may come.


@dataclass(frozen=True)
class Said:
    """What is being done, in a line."""

    text: str


@dataclass(frozen=True)
class Converging:
    """A fit is at this iteration, from 1, and leaves the error E on the runs it is fitted to."""

    iteration: int
    error: float


@dataclass(frozen=True)
class Findings:
    """What the gate found before any fit."""

    found: tuple[Found, ...]


@dataclass(frozen=True)
class Library:
    """A card for every effect that may be added."""

    cards: tuple[Card, ...]


@dataclass(frozen=True, eq=False)
class Climbed:
    """The rungs that lead to the model wanted, the last one included as far as it is fitted."""

    rungs: tuple[Rung, ...]


@dataclass(frozen=True)
class Concluded:
    """A diagnosis has ended; its report is at hand."""

    verdict: Verdict
    findings: tuple[Found, ...]
    case: Case | None = None


@dataclass(frozen=True)
class Refused:
    """The work cannot be done; the line says why and what to do."""

    line: str


@dataclass(frozen=True)
class Done:
    """The order is finished; `line` says what came of it, if there is anything to say."""

    line: str = ""


Message = (
    Said
    | Converging
    | Findings
    | Library
    | Climbed
    | Ranking
    | Concluded
    | Law
    | AxleToBody
    | CanShow
    | Settings
    | Refused
    | Done
)
