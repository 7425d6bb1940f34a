"""All effects: wheelhop's own, those of installed packages, and a user's file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from importlib.metadata import entry_points
from pathlib import Path
from typing import get_args

from wheelhop.campaign import CampaignError
from wheelhop.effects.anti_roll_bar import AntiRollBar
from wheelhop.effects.asymmetric_damper import AsymmetricDamper
from wheelhop.effects.backlash import Backlash
from wheelhop.effects.base import Effect, Place
from wheelhop.effects.bump_stop import BumpStop
from wheelhop.effects.compliant_damper import CompliantDamper
from wheelhop.effects.corner_asymmetry import CornerAsymmetry
from wheelhop.effects.cornering_roll import CorneringRoll
from wheelhop.effects.digressive_damper import DigressiveDamper
from wheelhop.effects.driver_rocking import DriverRocking
from wheelhop.effects.driver_seat import DriverSeat
from wheelhop.effects.dry_friction import DryFriction
from wheelhop.effects.engine_vibration import EngineVibration
from wheelhop.effects.frame_twist import FrameTwist
from wheelhop.effects.friction_with_play import FrictionWithPlay
from wheelhop.effects.left_right_drift import LeftRightDrift
from wheelhop.effects.longitudinal_pitch import LongitudinalPitch
from wheelhop.effects.mount_bushing import MountBushing
from wheelhop.effects.mr_damper import MrDamper
from wheelhop.effects.own_file import effects_in, read_source
from wheelhop.effects.payne_effect import PayneEffect
from wheelhop.effects.progressive_spring import ProgressiveSpring
from wheelhop.effects.progressive_tyre import ProgressiveTyre
from wheelhop.effects.quadratic_damper import QuadraticDamper
from wheelhop.effects.sensor_clipping import SensorClipping
from wheelhop.effects.sensor_gain import SensorGain
from wheelhop.effects.sensor_mount import SensorMount
from wheelhop.effects.sensor_polarity import SensorPolarity
from wheelhop.effects.sensor_skew import SensorSkew
from wheelhop.effects.small_scale_roughness import SmallScaleRoughness
from wheelhop.effects.smooth_hysteresis import SmoothHysteresis
from wheelhop.effects.speed_fluctuation import SpeedFluctuation
from wheelhop.effects.tyre_envelope import TyreEnvelope
from wheelhop.effects.tyre_lift_off import TyreLiftOff
from wheelhop.effects.wheel_imbalance import WheelImbalance
from wheelhop.files import Source

BUILT_IN: tuple[type[Effect], ...] = (
    SpeedFluctuation,
    LeftRightDrift,
    TyreEnvelope,
    SmallScaleRoughness,
    ProgressiveTyre,
    TyreLiftOff,
    WheelImbalance,
    ProgressiveSpring,
    BumpStop,
    AsymmetricDamper,
    DigressiveDamper,
    DryFriction,
    Backlash,
    MountBushing,
    QuadraticDamper,
    CompliantDamper,
    FrictionWithPlay,
    MrDamper,
    SmoothHysteresis,
    PayneEffect,
    AntiRollBar,
    CornerAsymmetry,
    DriverSeat,
    DriverRocking,
    EngineVibration,
    FrameTwist,
    LongitudinalPitch,
    CorneringRoll,
    SensorGain,
    SensorPolarity,
    SensorSkew,
    SensorClipping,
    SensorMount,
)
"""In the order of the chain track → speed → wheel → tyre → axle → suspension → body → sensor."""

ENTRY_POINT = "wheelhop.effects"


def load_effects(user_file: str | Path | Source | None = None) -> Mapping[str, Effect]:
    """Every effect by its id; later ones replace earlier ones of the same id.

    Of a user's file its text alone is run; a `Source` is one that was read before, and reviewed
    perhaps.

    Raises
    ------
    CampaignError
        The user's file is missing, does not run, or holds no effect, or an effect that does not
        state what every effect states.
    """
    effects: dict[str, Effect] = {cls.id: cls() for cls in BUILT_IN}
    for point in entry_points(group=ENTRY_POINT):
        effect = _made(point.load(), f"package {point.value}")
        effects[effect.id] = effect
    if user_file is not None:
        if not isinstance(user_file, Source):
            user_file = read_source(Path(user_file))
        for cls in effects_in(user_file):
            effect = _made(cls, str(user_file))
            effects[effect.id] = effect
    return effects


def pick(names: Sequence[str], library: Mapping[str, Effect]) -> list[Effect]:
    """The effects of these names, each once; raises CampaignError for a name that is not there."""
    for name in names:
        if name not in library:
            near = get_close_matches(name, library, n=1)
            hint = f'did you mean "{near[0]}"? ' if near else ""
            raise CampaignError(
                f'there is no effect "{name}": {hint}the library has {", ".join(library)}'
            )
    return [library[name] for name in dict.fromkeys(names)]


def _made(cls: type[Effect], where: str) -> Effect:
    """An effect somebody else wrote, checked for what every effect states."""
    for name in ("id", "place", "title", "equation", "source"):
        if not isinstance(getattr(cls, name, None), str):
            raise CampaignError(f'{where}: {cls.__name__} has no {name}; add {name} = "…" to it')
    if not cls.id.strip() or not cls.id.isprintable() or "." in cls.id:
        raise CampaignError(
            f'{where}: {cls.__name__} has id = "{cls.id}"; it is a word that prints, without a dot'
        )
    if cls.place not in get_args(Place):
        places = ", ".join(get_args(Place))
        raise CampaignError(
            f'{where}: {cls.__name__} has place = "{cls.place}"; it is one of {places}'
        )
    try:
        return cls()
    except TypeError as error:
        raise CampaignError(
            f"{where}: {cls.__name__} cannot be made without arguments: {error}; give them defaults"
        ) from error
