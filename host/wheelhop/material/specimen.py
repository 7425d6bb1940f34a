"""A specimen's file: the modulus of one bushing, for whoever builds it into a vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from wheelhop.files import Table, did_you_mean, read_toml, write_text
from wheelhop.material.error import MaterialError
from wheelhop.material.fit import ModulusFit
from wheelhop.material.maxwell import GeneralizedMaxwell
from wheelhop.material.model import Array, ComplexArray, ModulusModel
from wheelhop.material.select import MODELS

KEYS = ("format", "name", "model", "band_hz", "times_s", "parameters", "uncertainty")
ANY_OMEGA = np.array([1.0])  # what a model without times of its own is made for makes no difference


@dataclass(frozen=True, eq=False)
class Specimen:
    """A bushing whose modulus is known: a model, its parameters (n,) in SI with ω in rad/s, the
    frequencies it was measured at, and half-widths of 95 % intervals by parameter."""

    name: str
    model: ModulusModel
    parameters: Array
    band_hz: tuple[float, float]
    uncertainty: Mapping[str, float] = field(default_factory=dict)

    def modulus(self, omega: Array) -> ComplexArray:
        """M(iω) (f,), N/m."""
        return self.model.modulus(omega, self.parameters)


def specimen_of(name: str, fit: ModulusFit) -> Specimen:
    """What a fit has found."""
    frequency = fit.data.frequency_hz
    widths = fit.model.name_values(fit.half_widths())
    known = {key: width for key, width in widths.items() if np.isfinite(width)}
    band = (float(frequency[0]), float(frequency[-1]))
    return Specimen(name, fit.model, fit.parameters, band, known)


def write_specimen(path: Path, specimen: Specimen) -> None:
    """Write specimen.toml."""
    name = specimen.name.replace("\\", "/").replace('"', "'")
    lines = [
        "# A bushing's complex modulus: SI units, angular frequency in rad/s; docs/bushings.md.",
        "format = 1",
        f'name = "{name}"',
        f'model = "{specimen.model.id}"',
        f"band_hz = [{specimen.band_hz[0]!r}, {specimen.band_hz[1]!r}]",
    ]
    if isinstance(specimen.model, GeneralizedMaxwell):
        lines.append(f"times_s = {specimen.model.times_s.tolist()}")
    lines += ["", "[parameters]"]
    lines += [f"{k} = {v!r}" for k, v in specimen.model.name_values(specimen.parameters).items()]
    if specimen.uncertainty:
        lines += ["", "[uncertainty]  # half-widths of 95 % intervals"]
        lines += [f"{k} = {float(v)!r}" for k, v in specimen.uncertainty.items()]
    write_text(path, "\n".join(lines) + "\n", MaterialError)


def read_specimen(path: Path) -> Specimen:
    """Read specimen.toml; raises `MaterialError`, one line, for everything that is wrong in it."""
    top = read_toml(path, MaterialError)
    top.format()
    top.only(KEYS)
    model = _model(top)
    table = top.table("parameters")
    names = [c.name for c in model.coefficients]
    table.only(names)
    values = np.array([table.number(name) for name in names])
    for c, value in zip(model.coefficients, values, strict=True):
        if not c.lower <= value <= c.upper:
            raise table.error(f"{c.name} = {value:g} lies outside {c.lower:g} to {c.upper:g}")
    widths = top.table_if_any("uncertainty")
    widths.only(names)
    uncertainty = {key: widths.number(key, at_least=0.0) for key in widths.values}
    low, high = top.pair("band_hz")
    if not 0.0 < low < high:
        raise top.error(f"band_hz = [{low:g}, {high:g}]: give two frequencies, the lower one first")
    return Specimen(top.text("name"), model, values, (low, high), uncertainty)


def _model(top: Table) -> ModulusModel:
    name = top.text("model")
    if name not in MODELS:
        guess = did_you_mean(name, tuple(MODELS)) or f"; known are {', '.join(MODELS)}"
        raise top.error(f"model = '{name}' is not known{guess}")
    if name != GeneralizedMaxwell.id:
        return MODELS[name](ANY_OMEGA)
    times = top.numbers("times_s")
    if any(time <= 0.0 for time in times):
        raise top.error("times_s: relaxation times are positive")
    return GeneralizedMaxwell(times)
