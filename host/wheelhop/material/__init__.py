"""Bushings: from rig data to the complex modulus, and from that to the vehicle."""

from wheelhop.material.causality import Consistency, consistency, passive_range_hz, violation
from wheelhop.material.data import ModulusData, checked
from wheelhop.material.error import MaterialError
from wheelhop.material.fit import ModulusFit, fit_modulus, log_error
from wheelhop.material.maxwell import GeneralizedMaxwell
from wheelhop.material.model import ModulusModel
from wheelhop.material.models import (
    CausalPowerLaw,
    FractionalKelvinVoigt,
    FractionalZener,
    LogarithmicPolynomial,
    ModifiedPowerLaw,
    PowerLogarithm,
)
from wheelhop.material.rational import Elements, approximate
from wheelhop.material.read import RigData, read_rig_data
from wheelhop.material.select import MODELS, Candidate, candidates
from wheelhop.material.shift import TemperatureShift, shift_temperatures
from wheelhop.material.specimen import Specimen, read_specimen, specimen_of, write_specimen

__all__ = [
    "MODELS",
    "Candidate",
    "CausalPowerLaw",
    "Consistency",
    "Elements",
    "FractionalKelvinVoigt",
    "FractionalZener",
    "GeneralizedMaxwell",
    "LogarithmicPolynomial",
    "MaterialError",
    "ModifiedPowerLaw",
    "ModulusData",
    "ModulusFit",
    "ModulusModel",
    "PowerLogarithm",
    "RigData",
    "Specimen",
    "TemperatureShift",
    "approximate",
    "candidates",
    "checked",
    "consistency",
    "fit_modulus",
    "log_error",
    "passive_range_hz",
    "read_rig_data",
    "read_specimen",
    "shift_temperatures",
    "specimen_of",
    "violation",
    "write_specimen",
]
