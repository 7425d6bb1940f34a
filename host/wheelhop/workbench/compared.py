"""What Compare shows: one state, and the events that change it.

The page keeps the state and nothing else; its fields and charts are made from it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite
from urllib.parse import quote, unquote

from wheelhop.campaign import Campaign, Channel, ComponentCampaign
from wheelhop.campaign.component import DISPLACEMENT, FORCE
from wheelhop.files import Table
from wheelhop.workbench.charts import WHOLE, Window
from wheelhop.workbench.shown import Rung

Added = tuple[str, ...]

TIME, OVERLAY, DISTANCE, SPECTRUM, SPECTROGRAM, RESPONSE, COHERENCE, XY, HISTOGRAM = (
    *("time", "overlay", "distance", "spectrum", "spectrogram", "response", "coherence"),
    *("xy", "histogram"),
)
KINDS = {
    TIME: "Time",
    OVERLAY: "Overlay",
    DISTANCE: "Distance",
    SPECTRUM: "Spectrum",
    SPECTROGRAM: "Spectrogram",
    RESPONSE: "Transfer function",
    COHERENCE: "Coherence",
    XY: "XY",
    HISTOGRAM: "Histogram",
}
"""What may be drawn of runs and channels, and what that is called."""
PAIRED = (RESPONSE, COHERENCE, XY)
"""Those that draw the first channel over each of the others."""
STEP = 0.2  # of what is shown, for one press of a key
CLOSEST_S = 0.05
VELOCITY = Channel("velocity", "rig", quantity="velocity", unit="m/s")


@dataclass(frozen=True)
class Compared:
    """What is looked at: runs and channels by name, which models of the ladder (indices into
    `ladder`, which names the effects each of them has), from when to when, s (None: where the first
    model fails worst), what kind of chart, and where the two cursors stand, s (None: nowhere)."""

    runs: tuple[str, ...]
    channels: tuple[str, ...]
    kind: str = TIME
    window: Window | None = None
    cursors: Window | None = None
    ladder: tuple[Added, ...] = ()
    models: tuple[int, ...] = ()

    def at(self, run: str | None = None, channel: str | None = None) -> Compared:
        """Against time, one run, one channel or one of each, where that fails worst."""
        runs = self.runs if run is None else (run,)
        channels = self.channels if channel is None else (channel,)
        moved = replace(self, kind=TIME, window=None, cursors=None)
        return replace(moved, runs=runs, channels=channels)

    def of_runs(self, runs: Sequence[str]) -> Compared:
        """Other runs, in this order: one at least."""
        if not runs or tuple(runs) == self.runs:
            return self
        return replace(self, runs=tuple(runs), window=None, cursors=None)

    def of_channels(self, channels: Sequence[str]) -> Compared:
        """Other channels, in this order: one at least."""
        return replace(self, channels=tuple(channels)) if channels else self

    def stepped(self, by: int, runs: Sequence[str]) -> Compared:
        """One run, so many further among `runs`, round and round."""
        at = runs.index(self.runs[0]) if self.runs[0] in runs else 0
        return self.of_runs((runs[(at + by) % len(runs)],))

    def beside(self, models: Collection[int]) -> Compared:
        """Other models of the ladder."""
        return replace(self, models=tuple(sorted(models)))

    def on(self, ladder: tuple[Added, ...]) -> Compared:
        """Another ladder has been fitted: its first and its last model are looked at."""
        if ladder == self.ladder:
            return self
        models = tuple(sorted({0, len(ladder) - 1})) if ladder else ()
        return replace(self, ladder=ladder, models=models)

    def drawn_as(self, kind: str, offered: Mapping[str, Channel]) -> Compared:
        """Another kind of chart; one that takes pairs gets them."""
        channels = self.channels
        if kind in PAIRED and len(channels) < 2:
            channels = (*channels, *partners(channels[0], offered))
        return replace(self, kind=kind, channels=channels)

    def pressed(self, key: str, shown: Window, length_s: float) -> Compared:
        """A key zooms or moves what is `shown` of a record."""
        return replace(self, window=moved(shown, key, length_s))


def partners(name: str, offered: Mapping[str, Channel]) -> tuple[str, ...]:
    """What a channel is drawn over: on a rig displacement and velocity, of a vehicle the axle below
    it or, of an axle, what stands above; else the next channel there is."""
    others = [other for other in offered if other != name]
    channel = offered[name]
    if channel.point == "rig":
        return tuple(other for other in others if offered[other] in (DISPLACEMENT, VELOCITY))
    near = [other for other in others if offered[other].corner == channel.corner]
    axles = [other for other in near if offered[other].point[0] == "A"]
    found = axles or near if channel.corner is not None else []
    return tuple((found or others)[:1])


def moved(window: Window, key: str, length_s: float) -> Window:
    """What of a record is looked at, s, after a key: + − zoom, arrows move, 0 shows all."""
    if key == "0":
        return WHOLE
    first, last = max(window[0], 0.0), min(window[1], length_s)
    width = last - first
    if key in ("+", "="):
        width = max(width * (1 - 2 * STEP), CLOSEST_S)
    elif key in ("-", "−"):
        width = min(width / (1 - 2 * STEP), length_s)
    by = {"ArrowLeft": -STEP, "ArrowRight": STEP}.get(key, 0.0) * width
    middle = min(max((first + last) / 2 + by, width / 2), length_s - width / 2)
    return middle - width / 2, middle + width / 2


def offered_runs(campaign: Campaign, left_out: Collection[str], chosen: Sequence[str]) -> list[str]:
    """The runs that are taken, and those that are looked at."""
    return [run.id for run in campaign.runs if run.id in chosen or run.id not in left_out]


def offered_channels(campaign: Campaign) -> dict[str, Channel]:
    """The channels compared, on a rig with what was imposed."""
    found = {channel.name: channel for channel in campaign.channels}
    if isinstance(campaign, ComponentCampaign):
        found |= {each.name: each for each in (FORCE, DISPLACEMENT, VELOCITY)}
    return found


def opened(campaign: Campaign, rungs: Sequence[Rung], roles: Mapping[str, str]) -> Compared:
    """Where the first model fails worst, of runs that no fit has seen if there are any; on a rig
    its loops there."""
    run, channel = campaign.runs[0].id, campaign.channels[0].name
    if rungs:
        first = rungs[0]
        held_out = [i for i, name in enumerate(first.runs) if roles.get(name) == "validate"]
        among = held_out or range(len(first.runs))
        cells = [
            (float(first.ratio[i, k]), i, k)
            for i in among
            for k in range(len(first.channels))
            if isfinite(first.ratio[i, k])
        ]
        if cells:
            _, i, k = max(cells)
            run, channel = first.runs[i], first.channels[k]
    if not isinstance(campaign, ComponentCampaign):
        return Compared((run,), (channel,))
    force_first = tuple(each.name for each in (FORCE, DISPLACEMENT, VELOCITY))
    return Compared((run,), force_first, XY)


def known(state: Compared, campaign: Campaign) -> Compared | None:
    """A state without what the campaign does not have; None where nothing is left of it."""
    names, offered = {run.id for run in campaign.runs}, offered_channels(campaign)
    runs = tuple(run for run in state.runs if run in names)
    channels = tuple(name for name in state.channels if name in offered)
    if not runs or not channels or state.kind not in KINDS:
        return None
    return replace(state, runs=runs, channels=channels)


# As an address, and in the session.


def address_of(state: Compared) -> str:
    """What stands behind "compare/" in the page's address: runs, channels, kind and window."""
    lists = [",".join(quote(name, safe="") for name in n) for n in (state.runs, state.channels)]
    window = [] if state.window is None else ["-".join(f"{end:g}" for end in state.window)]
    return "/".join([*lists, state.kind, *(["all"] if state.window == WHOLE else window)])


def of_address(text: str, campaign: Campaign) -> Compared | None:
    """The state an address tells; None where it tells none of this campaign."""
    runs, channels, kind, window, *_ = (*text.split("/"), *[""] * 4)
    lists = [tuple(unquote(name) for name in part.split(",") if name) for part in (runs, channels)]
    if lists[0] and not lists[1]:
        lists[1] = (campaign.channels[0].name,)
    return known(Compared(lists[0], lists[1], kind or TIME, _window(window.split("-"))), campaign)


def _window(ends: Sequence[str]) -> Window | None:
    if list(ends) == ["all"]:
        return WHOLE
    try:
        first, last = map(float, ends)
    except ValueError:
        return None
    return (first, last) if 0.0 <= first < last < inf else None


def to_table(state: Compared) -> dict[str, object]:
    """A state as it is kept in the session."""
    found: dict[str, object] = {
        "runs": list(state.runs),
        "channels": list(state.channels),
        "kind": state.kind,
    }
    finite = state.window is not None and state.window != WHOLE
    return found | {"window_s": list(state.window or ())} if finite else found


def of_table(table: Table, campaign: Campaign) -> Compared | None:
    """A state as it was kept; None where the campaign has nothing of it any more."""
    window = _window([str(end) for end in table.values.get("window_s", [])])
    runs, channels = tuple(table.texts("runs")), tuple(table.texts("channels"))
    return known(Compared(runs, channels, table.text("kind", default=TIME), window), campaign)
