"""What comparing and diagnosing give: tables, figures and files of one result."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from wheelhop.api.given import Folder
from wheelhop.api.posterior import correlation_frame, covariance_frame, draws_frame
from wheelhop.campaign import Campaign
from wheelhop.compare import Comparison, RunSignals, to_json
from wheelhop.diagnose import Diagnosis, Step, comparison_of
from wheelhop.diagnose import to_json as diagnosis_to_json
from wheelhop.diagnose.diagnosis import ladder_frame, parameters_frame, ranking_frame
from wheelhop.effects import Effect
from wheelhop.files import Watching
from wheelhop.files.words import significant
from wheelhop.fit import Workshop
from wheelhop.gate import Finding
from wheelhop.gate import to_json as findings_to_json
from wheelhop.gate.sensors import Seen
from wheelhop.report.model_file import write_model
from wheelhop.report.words import comparison_headline, headline, over_floor
from wheelhop.simulate import Model
from wheelhop.vehicle import Vehicle

if TYPE_CHECKING:
    from pandas import DataFrame

    from wheelhop.law import LastRungs


@dataclass(frozen=True, eq=False, repr=False)
class Result:
    """A campaign, the nominal vehicle, the steps from the fitted baseline to the last model, and
    what the campaign was found to say wrong."""

    campaign: Campaign
    vehicle: Vehicle
    steps: tuple[Step, ...]
    findings: tuple[Finding, ...]

    @property
    def last(self) -> Step:
        """The last model."""
        return self.steps[-1]

    @property
    def model(self) -> Model:
        """The numbers and effects of the last model, fitted."""
        return self.last.rung.model

    @property
    def comparison(self) -> Comparison:
        """The last model against the records: where and by how much it fails."""
        return self.last.comparison

    @property
    def error(self) -> float:
        """E = √(Σ residual² / Σ measured²) in band, of the last model on the runs held out, or on
        the runs fitted if none are."""
        return self.last.rung.error

    @property
    def floor(self) -> float:
        """The E that the sensors alone would leave of the same runs."""
        return self.last.floor

    def ladder(self) -> DataFrame:
        """The models from the baseline on, a row each, and their errors; index `model`."""
        return ladder_frame(self.steps)

    def parameters(self) -> DataFrame:
        """Every fitted number of the last model: value, one standard deviation, unit (SI)."""
        return parameters_frame(self.last)

    def residuals(self, by: Literal["band", "run"] = "band") -> DataFrame:
        """What the last model leaves, by band or run, and channel: see `Comparison.residuals`."""
        return self.comparison.residuals(by)

    def agreement(self) -> DataFrame:
        """The field's figures by run and channel: see `Comparison.agreement`."""
        return self.comparison.agreement()

    def __getitem__(self, run_id: str) -> RunSignals:
        """Measured and modelled signals of one run, in band; see `Comparison`.

        Raises
        ------
        InputError
            No run of this id was compared.
        """
        return self.comparison[run_id]

    def covariance(self) -> DataFrame:
        """Covariance of the fitted numbers of the last model that runs share, in their units (SI).

        Its diagonal is the square of the uncertainties in `parameters`; it is to be trusted as far
        as these are. Numbers that stand for what each run leaves free have none.

        Returns
        -------
        DataFrame
            (g, g), rows and columns by the numbers' names.
        """
        return covariance_frame(self.last)

    def correlation(self) -> DataFrame:
        """Correlation of the fitted numbers that runs share, -1 … 1: `covariance` scaled to a unit
        diagonal.

        Returns
        -------
        DataFrame
            (g, g), rows and columns by the numbers' names.
        """
        return correlation_frame(self.last)

    def draws(self, count: int = 100, seed: int = 0) -> DataFrame:
        """Draw sets of numbers from the posterior: normal with the values of `parameters` and
        `covariance`, each number kept within the bounds of the fit.

        Parameters
        ----------
        count
            How many sets.
        seed
            The same seed, the same draws.

        Returns
        -------
        DataFrame
            (count, g), a column for each number, SI; a row is what `with_values` takes.

        Raises
        ------
        ValueError
            The count is below 1.
        """
        return draws_frame(self.last, count, seed)

    def predict(
        self, campaign: Folder, *, jobs: int | None = None, progress: Watching = True
    ) -> Comparison:
        """Let the last model foresee the runs of another campaign: see `wheelhop.predict`.

        Parameters
        ----------
        campaign, jobs, progress
            As for `wheelhop.predict`.

        Returns
        -------
        Comparison
            The model against those records.

        Raises
        ------
        CampaignError
            As of `wheelhop.predict`.
        """
        from wheelhop.api.predicting import predict

        return predict(self.model, campaign, jobs=jobs, progress=progress)

    def save(self, file: str | Path) -> None:
        """Write the whole result into one file, with the records it was made from; `wheelhop.load`
        reads it.

        Parameters
        ----------
        file
            Such as "result.wheelhop"; what stood there is replaced.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        from wheelhop.api.saving import save

        save(self, Path(file))

    def to_json(self) -> dict[str, Any]:
        """What `--json` of the command writes."""
        raise NotImplementedError

    def write_model(self, file: str | Path) -> None:
        """Write the last model as TOML (docs/model-file.md); what stood there is replaced.

        Parameters
        ----------
        file
            Such as "model.toml".

        Raises
        ------
        InputError
            The file cannot be written.
        """
        write_model(Path(file), self.campaign, self.vehicle, self.steps)

    def _repr_html_(self) -> str:
        from wheelhop.report.figures import ladder_figure

        picture = b64encode(ladder_figure(self.steps)._repr_png_()).decode("ascii")
        return "".join(
            (
                f"<p><b>{escape(self._headline())}</b></p>",
                *(table.to_html(float_format="%.3g", na_rep="") for table in self._tables()),
                f'<img alt="error of every model" src="data:image/png;base64,{picture}">',
            )
        )

    def _headline(self) -> str:
        raise NotImplementedError

    def _tables(self) -> tuple[DataFrame, ...]:
        own = [f"{effect.id}." for effect in self.model.effects]
        numbers = self.parameters()
        effects = numbers[[any(map(name.startswith, own)) for name in numbers.index]]
        return (self.ladder(), effects) if len(effects) else (self.ladder(),)


@dataclass(frozen=True, eq=False, repr=False)
class ComparisonResult(Result):
    """How a fitted model compares with the records, from the baseline to the last effect added.

    `axles` is the last model with the measured motion of the axles driving it, if that was asked
    for and is possible; `symptoms` what the sensors' examination found, if there was one.
    """

    workshop: Workshop
    axles: Step | None = None
    symptoms: tuple[Seen, ...] | None = None

    def with_values(self, changes: Mapping[str, float]) -> Comparison:
        """The last model with some of its numbers changed, not fitted again, against the records:
        {"suspension.front.damping_N_s_m": 700.0}, as `parameters` names them.

        Raises
        ------
        KeyError
            The model has no such number.
        """
        for name in changes:
            self.model.values[name]
        return comparison_of(self.workshop, self.last.rung, changes)

    def to_json(self) -> dict[str, Any]:
        """What `wheelhop compare --json` writes: the last model's comparison, the errors on the way
        to it, the comparison driven by the measured axles, and the findings of the gate."""
        ladder = []
        for step in self.steps:
            held_out = None if step.rung.validation is None else step.rung.error_validate
            errors = {"error_fit": step.rung.error_fit, "error_validate": held_out}
            ladder.append({"added": list(step.added), **errors})
        return {
            "format": 1,
            "ladder": ladder,
            **to_json(self.comparison),
            "findings": findings_to_json(self.findings),
            "axle_driven": None if self.axles is None else to_json(self.axles.comparison),
        }

    def write_report(self, file: str | Path) -> None:
        """Write the report, one self-contained HTML page.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        from wheelhop.report.reports import write_comparison_report

        write_comparison_report(Path(file), self.campaign, self.steps, self.axles, self.findings)

    def _headline(self) -> str:
        return comparison_headline(self.steps)

    def __repr__(self) -> str:
        return f"<ComparisonResult: {self._headline()}>"


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosisResult(Result):
    """What a diagnosis found; `diagnosis` holds all of it, `library` the effects searched, and
    `law` what was found beyond their names: a free law and a formula, of a component whose last
    rung is above the floor, or None; and of a result that was loaded, whose file holds its law as
    JSON."""

    diagnosis: Diagnosis
    library: Mapping[str, Effect]
    law: LastRungs | None = None

    def __getstate__(self) -> dict[str, object]:
        # The terms of a law are compiled.
        return {**vars(self), "law": None}

    @property
    def verdict(self) -> tuple[str, ...]:
        """The effects that are missing, by id; ("none",), or "unknown" for what no effect
        explains."""
        return self.diagnosis.verdict

    @property
    def confidence(self) -> float:
        """The probability, 0 … 1, that the verdict's first entry is right: by a formula."""
        return self.diagnosis.confidence

    @property
    def explanation(self) -> tuple[str, ...]:
        """Why, in sentences."""
        return self.diagnosis.explanation

    def ranking(self) -> DataFrame:
        """Every effect of the library against what the baseline leaves, best first."""
        return ranking_frame(self.diagnosis.ranking)

    def to_json(self) -> dict[str, Any]:
        """What `wheelhop diagnose --json` writes."""
        from wheelhop.report.law import rungs_to_json

        return {**diagnosis_to_json(self.diagnosis), "law": rungs_to_json(self.law)}

    def write_report(self, file: str | Path) -> None:
        """Write the report, one self-contained HTML page.

        Raises
        ------
        InputError
            The file cannot be written.
        """
        from wheelhop.report.reports import write_diagnosis_report

        write_diagnosis_report(Path(file), self.campaign, self.diagnosis, self.library, self.law)

    def _headline(self) -> str:
        sure = f"Confidence {100 * self.confidence:.0f} %."
        return f"{headline(self.diagnosis)} {sure}"

    def _tables(self) -> tuple[DataFrame, ...]:
        return (self.ranking().head(6).drop(columns="reason"), *super()._tables())

    def __repr__(self) -> str:
        ratio = significant(over_floor(self.last), 2)
        return f"<DiagnosisResult: {self._headline()} Error {ratio} × the noise floor.>"
