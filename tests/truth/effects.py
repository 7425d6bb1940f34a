"""All effects by id, and how one is made from the parameters of a truth file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields

from . import (
    body_effects,
    other_body_laws,
    other_laws,
    other_road_laws,
    road_effects,
    sensor_effects,
    suspension_effects,
)
from .effect import Effect

Parameters = Mapping[str, float | str]

KINDS: tuple[type[Effect], ...] = (
    road_effects.SpeedFluctuation,
    road_effects.LeftRightDrift,
    road_effects.TyreEnvelope,
    road_effects.SmallScaleRoughness,
    road_effects.TyreLiftOff,
    road_effects.ProgressiveTyre,
    road_effects.WheelImbalance,
    suspension_effects.AirSpring,
    suspension_effects.CubicSpring,
    suspension_effects.AsymmetricDamper,
    suspension_effects.DigressiveDamper,
    suspension_effects.BumpStop,
    suspension_effects.DryFriction,
    suspension_effects.Backlash,
    suspension_effects.MountBushing,
    suspension_effects.AntiRollBar,
    suspension_effects.CornerAsymmetry,
    body_effects.DriverSeat,
    body_effects.DriverRocking,
    body_effects.FrameTwist,
    body_effects.EngineVibration,
    body_effects.LongitudinalPitch,
    body_effects.CorneringRoll,
    sensor_effects.SensorGain,
    sensor_effects.SensorPolarity,
    sensor_effects.SensorClipping,
    sensor_effects.SensorSkew,
    sensor_effects.SensorMount,
    other_laws.TanhFriction,
    other_laws.BristleFriction,
    other_laws.MeasuredDamper,
    other_laws.FoamStop,
    other_laws.WanderingEngine,
    other_laws.WarmingGas,
    other_laws.RoundedAsymmetry,
    other_laws.RubberMount,
    other_laws.StickyBar,
    other_laws.WornCorner,
    other_laws.TwoMassDriver,
    other_laws.BendingFrame,
    other_laws.WarmingSensor,
    other_laws.OffsetClipping,
    other_road_laws.GearChanges,
    other_road_laws.PressedEnvelope,
    other_road_laws.PatchyRoughness,
    other_road_laws.SoftLanding,
    other_road_laws.OutOfRound,
    other_road_laws.PowerTyre,
    other_road_laws.SlippingWheels,
    other_laws.RubberedPlay,
    other_body_laws.TwoLinkDriver,
    other_body_laws.JackedPitch,
    other_body_laws.LinkedRoll,
)


def make_effect(effect_id: str, parameters: Parameters) -> Effect:
    """The effect of that id whose parameters these are (an id may have more than one law)."""
    laws = [kind for kind in KINDS if kind.id == effect_id]
    if not laws:
        raise ValueError(f"no effect {effect_id!r}; known: {', '.join(sorted(known_ids()))}")
    for law in laws:
        if _required(law) <= parameters.keys() <= _names(law):
            return law(**parameters)
    wanted = " or ".join(", ".join(sorted(_names(law))) or "none" for law in laws)
    raise ValueError(f"{effect_id} takes the parameters {wanted}; given {', '.join(parameters)}")


def make_effects(effects: Mapping[str, Parameters]) -> list[Effect]:
    """One object per effect, in the order given; "none" stands for no effect."""
    return [make_effect(name, values) for name, values in effects.items() if name != "none"]


def known_ids() -> set[str]:
    """Ids of every effect this simulator can hide in a campaign."""
    return {kind.id for kind in KINDS}


def _names(law: type[Effect]) -> set[str]:
    return {f.name for f in fields(law)}


def _required(law: type[Effect]) -> set[str]:
    return {f.name for f in fields(law) if f.default is MISSING}
