"""What a verdict says is wrong in the campaign's files, as changes of them."""

from __future__ import annotations

from collections.abc import Iterator

from wheelhop.campaign import Campaign
from wheelhop.campaign.change import Proposal, of_campaign
from wheelhop.diagnose import Step
from wheelhop.effects import Effect
from wheelhop.effects.beliefs import ALL, RecorderFilter, SensorPosition, TrackSurvey
from wheelhop.effects.sensor_gain import SensorGain
from wheelhop.effects.sensor_polarity import SensorPolarity
from wheelhop.gate.fixes import moved, real, scaled, tracks, turned


def of_effects(step: Step, campaign: Campaign) -> tuple[Proposal, ...]:
    """Of every effect in the model that is a mistake of what the campaign says."""
    numbers = {name: float(value) for name, (value, _) in step.parameters.items()}
    every = (_of(effect, numbers, campaign) for effect in step.rung.model.effects)
    return real(proposal for each in every for proposal in each)


def _of(effect: Effect, numbers: dict[str, float], campaign: Campaign) -> Iterator[Proposal]:
    def number(name: str) -> float:
        return numbers.get(f"{effect.id}.{name}", 0.0)

    if isinstance(effect, TrackSurvey):
        times, quantity = 1.0 + number("error"), effect.quantity
        runs = [run for run in campaign.runs if effect.kind in (run.track.kind, ALL)]
        keys = {key: f"{key}m" for key in quantity.keys}
        which = "all tracks" if effect.kind == ALL else f"{effect.kind} tracks"
        yield tracks(runs, keys, times, f"Write the {quantity.name} of {which} × {times:.4g}")
        if quantity.instead and effect.kind == ALL:
            names = [channel.name for channel in campaign.channels]
            title = f"Or write all recordings × {1 / times:.4g}"
            yield scaled(campaign, dict.fromkeys(names, 1.0 / times), title)
    elif isinstance(effect, SensorPosition):
        x, y = (round(a + number(n), 3) for a, n in zip(effect.said, ("x_m", "y_m"), strict=True))
        place = (("channels", effect.channel, "position"), [x, y])
        yield of_campaign(f"Write {effect.channel} at {x:g} m ahead, {y:g} m to the left", place)
    elif isinstance(effect, RecorderFilter) and number("time_s") > 0.0:
        corner = float(f"{1.0 / (6.283185307179586 * number('time_s')):.3g}")
        found = {"kind": "butterworth", "order": effect.order, "corner_hz": corner}
        yield of_campaign(f"State the recorder’s filter, {corner:g} Hz", (("filter",), found))
    elif isinstance(effect, SensorGain) and effect.channel:
        times = 1.0 / (1.0 + number("error"))
        title = f"Write {effect.channel} × {times:.4g}"
        yield scaled(campaign, {effect.channel: times}, title)
    elif isinstance(effect, SensorPolarity):
        of = {channel.name: channel for channel in campaign.channels}
        if effect.channels in of:
            yield turned(campaign, [effect.channels])
        for a in of.values():
            for b in of.values():
                if f"{a.name}/{b.name}" == effect.channels:
                    yield moved(campaign, {a.name: b, b.name: a})
