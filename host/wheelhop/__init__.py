"""Find out which physics a suspension model is missing.

    import wheelhop as wh

    campaign = wh.read("my-campaign")       # campaign.toml, vehicle.toml and the recordings
    found = wh.diagnose(campaign)           # which effects are missing
    fitted = wh.compare(campaign, "dry-friction")
    fitted.residuals()                      # a DataFrame
    wh.plot(fitted)                         # a matplotlib Figure

docs/python.md lists what is public: `__all__`. Everything loads when it is first used. Packages of
their own, `wheelhop.campaign`, `wheelhop.fit` and so on, are in three folders of the repository.
`wheelhop.compare`, `diagnose`, `export`, `predict`, `simulate` and `tune` are functions; from the
packages of the same names take what you need by `from wheelhop.compare import …`.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Mapping
from importlib import import_module
from pkgutil import extend_path
from types import ModuleType
from typing import TYPE_CHECKING, Any

__path__ = extend_path(__path__, __name__)

if TYPE_CHECKING:
    from wheelhop.api import (
        ComparisonResult,
        DiagnosisResult,
        add,
        compare,
        detectable,
        diagnose,
        export,
        load,
        plan,
        plot,
        predict,
        read,
        read_log,
        read_model,
        read_recording,
        read_vehicle,
        simulate,
        tune,
    )
    from wheelhop.api.effect_kit import check_effect
    from wheelhop.api.fleet import diagnose_fleet
    from wheelhop.api.settings import SettingsResult, compare_settings
    from wheelhop.campaign import Campaign, CampaignError, Run
    from wheelhop.campaign.write import NewRun, add_run, new_campaign
    from wheelhop.compare import Comparison, RunSignals
    from wheelhop.effects import Effect, Parameter, load_effects
    from wheelhop.export.plant import Linear, Plant
    from wheelhop.files import InputError
    from wheelhop.logger import Channel, Log, Recording
    from wheelhop.predict.detectable import Detectable
    from wheelhop.predict.plan import Plan
    from wheelhop.simulate import Model
    from wheelhop.tune.tuning import Tuning
    from wheelhop.vehicle import Vehicle
    from wheelhop.vehicle.rates import WheelRates, wheel_rates

__all__ = [
    "Amplitude",
    "Campaign",
    "CampaignError",
    "Channel",
    "Comparison",
    "ComparisonResult",
    "Detectable",
    "DiagnosisResult",
    "Effect",
    "InputError",
    "Linear",
    "Log",
    "Model",
    "NewRun",
    "Parameter",
    "Plan",
    "Plant",
    "Recording",
    "Run",
    "RunSignals",
    "SettingsResult",
    "Shape",
    "Switch",
    "Tuning",
    "Vehicle",
    "WheelRates",
    "__version__",
    "add",
    "add_run",
    "check_effect",
    "compare",
    "compare_settings",
    "detectable",
    "diagnose",
    "diagnose_fleet",
    "export",
    "load",
    "load_effects",
    "new_campaign",
    "plan",
    "plot",
    "predict",
    "read",
    "read_log",
    "read_model",
    "read_recording",
    "read_vehicle",
    "simulate",
    "tune",
    "wheel_rates",
]

_VERBS = ("compare", "diagnose", "export", "predict", "simulate", "tune")
"""Functions that are called like a package with the parts they are made of."""

_PACKAGE_OF = {
    **dict.fromkeys(("ComparisonResult", "DiagnosisResult", "add", "plan", "plot"), "api"),
    "detectable": "api",
    **dict.fromkeys((*_VERBS, "load"), "api"),
    "check_effect": "api.effect_kit",
    "diagnose_fleet": "api.fleet",
    **dict.fromkeys(("SettingsResult", "compare_settings"), "api.settings"),
    **dict.fromkeys(("read", "read_log", "read_model", "read_recording", "read_vehicle"), "api"),
    **dict.fromkeys(("Campaign", "CampaignError", "Run"), "campaign"),
    **dict.fromkeys(("NewRun", "add_run", "new_campaign"), "campaign.write"),
    **dict.fromkeys(("Comparison", "RunSignals"), "compare"),
    **dict.fromkeys(("Effect", "load_effects"), "effects"),
    **dict.fromkeys(("Amplitude", "Parameter", "Shape", "Switch"), "effects"),
    "InputError": "files",
    **dict.fromkeys(("Linear", "Plant"), "export.plant"),
    **dict.fromkeys(("Channel", "Log", "Recording"), "logger"),
    "Model": "simulate",
    "Detectable": "predict.detectable",
    "Plan": "predict.plan",
    "Tuning": "tune.tuning",
    "Vehicle": "vehicle",
    **dict.fromkeys(("WheelRates", "wheel_rates"), "vehicle.rates"),
}

_RENAMED: Mapping[str, str] = {}
"""Names of earlier versions and those that stand for them now, for two minor versions."""


if not TYPE_CHECKING:  # else every name would be one of the package's

    def __getattr__(name: str) -> Any:
        if name in _RENAMED:
            new = _RENAMED[name]
            message = f"wheelhop.{name} is now wheelhop.{new}"
            warnings.warn(message, DeprecationWarning, stacklevel=2)
            return getattr(sys.modules[__name__], new)
        if name == "__version__":
            from importlib.metadata import version

            return version("wheelhop")
        if name in _PACKAGE_OF:
            value = getattr(import_module(f"wheelhop.{_PACKAGE_OF[name]}"), name)
            globals()[name] = value
            return value
        if not name.startswith("_"):
            try:
                return import_module(f"wheelhop.{name}")
            except ModuleNotFoundError as error:
                if error.name != f"wheelhop.{name}":
                    raise
        raise AttributeError(f"module 'wheelhop' has no attribute '{name}'")


def __dir__() -> list[str]:
    return sorted(__all__)


class _Package(ModuleType):
    """This module: to import the package `wheelhop.compare` does not hide the function."""

    def __setattr__(self, name: str, value: object) -> None:
        if not (name in _VERBS and isinstance(value, ModuleType)):
            super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Package
