"""The verdict on one model: how large the error is, against which floor, and where it lies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from wheelhop.campaign import Campaign
from wheelhop.compare.breakdown import Breakdown, Slice, breakdown
from wheelhop.compare.describe import describe
from wheelhop.compare.floor import Floor, floor_of, noise_floor
from wheelhop.compare.metrics import ChannelFigures, channel_figures
from wheelhop.compare.records import Record, in_band, relative_error
from wheelhop.compare.signals import RunSignals, signals_of
from wheelhop.files import InputError, did_you_mean, shown
from wheelhop.files.words import ending_of, percent

if TYPE_CHECKING:
    from pandas import DataFrame

    from wheelhop.simulate import Response


@dataclass(frozen=True)
class OfQuantity:
    """E of the channels of one quantity alone, and what of it noise alone would leave, over the
    runs of each role; and their noise in band, rms of a channel in ``unit``."""

    quantity: str
    unit: str
    error_fit: float
    error_validate: float
    floor_fit: float
    floor_validate: float
    noise_rms: float


@dataclass(frozen=True, eq=False)
class Comparison:
    """A model's responses against a campaign's runs, in band.

    ``error_fit`` and ``error_validate`` are E over the runs of that role (NaN if
    none was compared), with charged degrees of freedom: over all channels, each in units of its
    noise. ``by_quantity`` says E of every quantity by itself, where there are several. Figures and
    breakdown are of the residual as it is, nothing charged.
    """

    title: str
    roles: Mapping[str, str]
    error_fit: float
    error_validate: float
    floor: Floor
    breakdown: Breakdown
    records: Sequence[Record]
    channels: Sequence[str]
    units: Sequence[str] = ()
    by_quantity: tuple[OfQuantity, ...] = ()

    @cached_property
    def figures(self) -> tuple[ChannelFigures, ...]:
        """One entry per run and channel the model predicts; made when asked for, because rating
        long records takes seconds."""
        return channel_figures(self.records, self.channels, self.floor.noise_rms)

    def __getitem__(self, run_id: str) -> RunSignals:
        """Measured and modelled signals of one run, in band.

        Raises
        ------
        InputError
            No run of this id was compared.
        """
        found = next((record for record in self.records if record.run.id == run_id), None)
        if found is None:
            near = did_you_mean(run_id, self.roles) or f"; there are {', '.join(self.roles)}"
            raise InputError(f'there is no run "{run_id}"{near}')
        return signals_of(found, self.channels, self.units)

    def __iter__(self) -> Iterator[RunSignals]:
        return (self[run_id] for run_id in self.roles)

    def __len__(self) -> int:
        return len(self.records)

    def __contains__(self, run_id: object) -> bool:
        return run_id in self.roles

    def residuals(self, by: Literal["band", "run"] = "band") -> DataFrame:
        """What the model leaves in each channel, by third-octave band (its nominal centre, Hz) or
        by run.

        Parameters
        ----------
        by
            "band" or "run".

        Returns
        -------
        DataFrame
            A row for each band or run, and channel: rms of residual, measurement and expected noise
            over all samples, in the channel's unit, which stands beside them where channels differ
            in it; `error` is E of the pair, residual over measurement, `over_floor` residual over
            noise.
        """
        import pandas

        where = self.breakdown
        grid = where.bands_channels if by == "band" else where.runs_channels
        rows = [float(name) for name in grid.rows] if by == "band" else list(grid.rows)
        samples = np.array([record.band.n * record.predicted for record in self.records])
        if by == "band":
            samples = np.tile(samples.sum(axis=0), (len(grid.rows), 1))
        mixed = len(set(self.units)) > 1
        unit = "" if mixed else ending_of(self.floor.unit)
        sums = {"residual": grid.residual, "measured": grid.measured, "noise": grid.noise}
        sums = {name: each * self.floor.noise_scale**2 for name, each in sums.items()}
        index = pandas.MultiIndex.from_product(
            [rows, grid.columns], names=["band_hz" if by == "band" else "run", "channel"]
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            columns = {f"{k}_rms{unit}": np.sqrt(v / samples).ravel() for k, v in sums.items()}
            columns["error"] = np.sqrt(grid.residual / grid.measured).ravel()
            columns["over_floor"] = np.sqrt(grid.residual / grid.noise).ravel()
        if mixed:
            columns["unit"] = np.array([*self.units] * len(rows), dtype=object)
        return pandas.DataFrame(columns, index=index)

    def agreement(self) -> DataFrame:
        """The field's figures of agreement.

        Returns
        -------
        DataFrame
            A row for each run and channel the model predicts: E and that of noise alone, NRMSE,
            coherence, spectral peaks (Hz, and height in the channel's unit), ISO/TS 18571 rating.
        """
        import pandas

        mixed = len(set(self.units)) > 1
        height = "height" if mixed else f"height{ending_of(self.floor.unit)}"
        unit = dict(zip(self.channels, self.units, strict=False))
        rows = [
            {
                "run": f.run_id,
                "channel": f.channel,
                "error": f.error,
                "floor": f.floor,
                "nrmse": f.nrmse,
                "coherence": f.coherence,
                "measured_peak_hz": f.measured_peak.frequency_hz,
                f"measured_peak_{height}": f.measured_peak.height,
                "model_peak_hz": f.model_peak.frequency_hz,
                f"model_peak_{height}": f.model_peak.height,
                "iso18571": f.rating.overall,
                **({"unit": unit[f.channel]} if mixed else {}),
            }
            for f in self.figures
        ]
        return pandas.DataFrame(rows).set_index(["run", "channel"])

    def __repr__(self) -> str:
        errors = [
            f"E = {percent(error)} on {len(runs)} runs {what}"
            for role, what, error in (
                ("fit", "fitted", self.error_fit),
                ("validate", "held out", self.error_validate),
            )
            if (runs := [run for run, its in self.roles.items() if its == role])
        ]
        words = [*errors, f"noise floor {percent(self.floor.error)}"]
        return f"<Comparison {shown(self.title)}: {', '.join(words)}>"

    def _repr_html_(self) -> str:
        table = self.residuals("run")["over_floor"].unstack(sort=False)
        caption = "Residual over noise floor, by run and channel:"
        return f"<p>{escape(repr(self))}<br>{caption}</p>{table.to_html(float_format='%.2g')}"


def compare(
    campaign: Campaign,
    responses: Iterable[Response],
    charged: Mapping[str, float] | None = None,
    floor: Floor | None = None,
) -> Comparison:
    """Compare ``responses`` (any of the campaign's runs, in any order) with the measurements.

    ``charged`` maps a run's id to the degrees of freedom fitted to that run alone: its
    residual sum of squares is scaled by n / (n - charged) in E. Channels that are NaN in a
    response are not predicted and count nowhere. ``floor`` is that of these records if it is known
    already. Raises ValueError for responses that do not fit
    the campaign, or if none predicts any channel.
    """
    records = in_band(campaign, responses)
    if not any(record.predicted.any() for record in records):
        raise ValueError("no response that predicts any channel")
    floor = noise_floor(campaign, records) if floor is None else floor
    fit, validate = (
        relative_error([r for r in records if r.run.role == role], charged)
        for role in ("fit", "validate")
    )
    return Comparison(
        title=campaign.title,
        roles={record.run.id: record.run.role for record in records},
        error_fit=fit,
        error_validate=validate,
        floor=floor,
        breakdown=breakdown(campaign, records, floor),
        records=records,
        channels=[channel.name for channel in campaign.channels],
        units=[channel.unit for channel in campaign.channels],
        by_quantity=_by_quantity(campaign, records, charged, floor),
    )


def _by_quantity(
    campaign: Campaign,
    records: Sequence[Record],
    charged: Mapping[str, float] | None,
    floor: Floor,
) -> tuple[OfQuantity, ...]:
    """What each quantity that is compared leaves; nothing where the campaign has but one."""
    if len(campaign.quantities) < 2:
        return ()
    found = []
    compared = np.any([record.predicted for record in records], axis=0)
    for quantity in campaign.quantities:
        of_it = np.array([channel.quantity == quantity for channel in campaign.channels])
        if not compared[of_it].any():
            continue
        fit, validate = ([r for r in records if r.run.role == role] for role in ("fit", "validate"))
        unit = next(c.unit for c in campaign.channels if c.quantity == quantity)
        noise = float(np.sqrt(np.mean(floor.of_channels[of_it] ** 2)))
        found.append(
            OfQuantity(
                quantity,
                unit,
                error_fit=relative_error(fit, charged, of_it),
                error_validate=relative_error(validate, charged, of_it),
                floor_fit=floor_of(campaign, fit, floor, of_it),
                floor_validate=floor_of(campaign, validate, floor, of_it),
                noise_rms=noise,
            )
        )
    return tuple(found)


def to_json(comparison: Comparison) -> dict[str, Any]:
    """Plain dictionaries, lists, strings and numbers; what is undetermined is None."""
    floor = comparison.floor
    plain: dict[str, Any] = _plain(
        {
            "title": comparison.title,
            "error_fit": comparison.error_fit,
            "error_validate": comparison.error_validate,
            "floor": {
                "error": floor.error,
                "error_fit": floor.error_fit,
                "error_validate": floor.error_validate,
                "expected": floor.expected,
                "expected_fit": floor.expected_fit,
                "expected_validate": floor.expected_validate,
                "source": floor.source,
                "basis": floor.origin,
                "uncertainty": floor.tolerance,
                **_noise_by_key(comparison),
            },
            "figures": [
                asdict(figures)
                | {"rating": asdict(figures.rating) | {"overall": figures.rating.overall}}
                for figures in comparison.figures
            ],
            "where": where_to_json(comparison.breakdown),
            **quantities_to_json(comparison),
        }
    )
    return plain


def quantities_to_json(comparison: Comparison) -> dict[str, Any]:
    """The errors of each quantity, as `compare --json` and `diagnose --json` write them; nothing
    where there is but one."""
    found = [_plain(asdict(each)) for each in comparison.by_quantity]
    return {"quantities": found} if found else {}


def _noise_by_key(comparison: Comparison) -> dict[str, dict[str, float]]:
    """The noise of every channel in its own unit, those of one unit under one key."""
    found: dict[str, dict[str, float]] = {}
    noise = comparison.floor.of_channels
    for name, unit, rms in zip(comparison.channels, comparison.units, noise, strict=True):
        found.setdefault(f"noise_rms{ending_of(unit)}", {})[name] = rms
    return found


def where_to_json(where: Breakdown) -> dict[str, Any]:
    """The breakdown alone, as `diagnose --json` writes it for a rung of the ladder."""
    grid = where.runs_channels
    plain: dict[str, Any] = _plain(
        {
            "description": describe(where),
            "ratio_to_floor": where.total.ratio,
            "run": _table(where.run),
            "channel": _table(where.channel),
            "band_hz": _table(where.band),
            "motion": _table(where.motion),
            "time": _table(where.time),
            "amplitude": _table(where.amplitude),
            "growth_exponent": where.growth,
            "locking": asdict(where.locking),
            "run_channel_ratio": {
                run: dict(zip(grid.columns, row, strict=True))
                for run, row in zip(grid.rows, grid.ratio, strict=True)
            },
        }
    )
    return plain


def _table(parts: Iterable[Slice]) -> list[dict[str, Any]]:
    keys = ("name", "share", "error", "floor", "ratio")
    return [{key: getattr(part, key) for key in keys} for part in parts]


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
