"""All effects: wheelhop's own, those of installed packages, and a user's file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from types import ModuleType
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
from wheelhop.effects.own_file import effects_in, effects_of_module, read_source
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
from wheelhop.effects.special import METHODS
from wheelhop.effects.speed_fluctuation import SpeedFluctuation
from wheelhop.effects.tyre_envelope import TyreEnvelope
from wheelhop.effects.tyre_lift_off import TyreLiftOff
from wheelhop.effects.wheel_imbalance import WheelImbalance
from wheelhop.files import Source, shown

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

Given = Effect | type[Effect]
"""An effect as an object, or its class."""
More = str | Path | Source | Given | Iterable[Given] | Mapping[str, Effect] | None
"""Which effects are searched: those of the library and of a Python file, or of objects; or those of
a mapping alone."""


def load_effects(more: More = None) -> Mapping[str, Effect]:
    """Every effect by its id; later ones replace earlier ones of the same id.

    Parameters
    ----------
    more
        Effects of the user's own beside those of wheelhop and of installed packages: a Python file
        of them, of which the text alone is run (a `Source` is one that was read before, and
        reviewed perhaps), or an effect, or several, as objects or classes. A mapping of effects by
        id is a library of its own, and returned as it is.

    Returns
    -------
    Mapping
        Effects by id, in the order of the chain from track to sensor, the user's own last.

    Raises
    ------
    CampaignError
        The user's file is missing, does not run, or holds no effect; or one of the effects does not
        state what every effect states.
    """
    if isinstance(more, Mapping):
        return more
    effects: dict[str, Effect] = {cls.id: cls() for cls in BUILT_IN}
    for point in entry_points(group=ENTRY_POINT):
        for effect in _of_package(point):
            effects[effect.id] = effect
    for effect in _of_user(more):
        effects[effect.id] = effect
    return effects


def pick(names: str | Given | Iterable[str | Given], library: Mapping[str, Effect]) -> list[Effect]:
    """The effects of these names in the library, or effects as objects or classes, each once;
    raises CampaignError for a name that is not there."""
    found: dict[str, Effect] = {}
    given = [names] if isinstance(names, str | Effect | type) else names
    for name in given:
        if not isinstance(name, str):
            effect = _made(name, "effects")
        elif name in library:
            effect = library[name]
        else:
            near = get_close_matches(name, library, n=1)
            hint = f'did you mean "{near[0]}"? ' if near else ""
            raise CampaignError(
                f'there is no effect "{name}": {hint}the library has {", ".join(library)}'
            )
        found.setdefault(effect.id, effect)
    return list(found.values())


def _of_package(point: EntryPoint) -> list[Effect]:
    """The effects that an installed package brings: an effect, a list of them, or a module."""
    where = f"package {point.value}"
    try:
        given = point.load()
    except Exception as error:
        kind = type(error).__name__
        raise CampaignError(
            f"{where}: does not load: {kind}: {error}; mend it, or uninstall the package"
        ) from error
    if isinstance(given, ModuleType):
        given = effects_of_module(given)
    several = given if isinstance(given, list | tuple) else [given]
    if not several:
        raise CampaignError(f"{where}: holds no effect; uninstall the package, or mend it")
    return [_made(one, where) for one in several]


def _of_user(more: str | Path | Source | Given | Iterable[Given] | None) -> list[Effect]:
    if more is None:
        return []
    if isinstance(more, Effect | type):
        return [_made(more, "effects")]
    if isinstance(more, str | Path):
        more = read_source(Path(more))
    if isinstance(more, Source):
        return [_made(cls, str(more)) for cls in effects_in(more)]
    return [_made(one, "effects") for one in more]


def _made(given: Given, where: str) -> Effect:
    """An effect somebody else wrote, checked for what every effect states."""
    cls = given if isinstance(given, type) else type(given)
    if not issubclass(cls, Effect):
        raise CampaignError(
            f"{where}: {shown(given)} is no effect; give a subclass of wheelhop.effects.Effect"
        )
    for name in ("id", "place", "title", "equation", "source"):
        if not isinstance(getattr(given, name, None), str):
            raise CampaignError(f'{where}: {cls.__name__} has no {name}; add {name} = "…" to it')
    if not given.id.strip() or not given.id.isprintable() or "." in given.id:
        raise CampaignError(
            f'{where}: {cls.__name__} has id = "{given.id}"; it is a word that prints, without a'
            " dot"
        )
    if given.place not in get_args(Place):
        places = ", ".join(get_args(Place))
        raise CampaignError(
            f'{where}: {cls.__name__} has place = "{given.place}"; it is one of {places}'
        )
    for method, base in METHODS.items():
        if hasattr(cls, method) and not issubclass(cls, base):
            raise CampaignError(
                f"{where}: {cls.__name__} has {method}, which is asked of {base.__name__} alone:"
                f" derive it from wheelhop.effects.{base.__name__} instead of Effect"
            )
    if isinstance(given, Effect):
        return given
    try:
        return cls()
    except TypeError as error:
        raise CampaignError(
            f"{where}: {cls.__name__} cannot be made without arguments: {error}; give them defaults"
        ) from error
