"""What every result has: the models and their numbers, tables, and files."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from wheelhop.api.given import Folder
from wheelhop.api.posterior import correlation_frame, covariance_frame, draws_frame
from wheelhop.campaign import Campaign
from wheelhop.compare import Comparison, RunSignals
from wheelhop.diagnose import Step
from wheelhop.diagnose.diagnosis import ladder_frame, parameters_frame
from wheelhop.files import Watching
from wheelhop.gate import Finding
from wheelhop.report.model_file import write_model
from wheelhop.simulate import Model
from wheelhop.vehicle import Vehicle

if TYPE_CHECKING:
    from pandas import DataFrame


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
        """The models from the baseline on, and their errors.

        Returns
        -------
        DataFrame
            By `model`: E over the runs fitted and held out, the floor, and error over floor.
        """
        return ladder_frame(self.steps)

    def parameters(self) -> DataFrame:
        """Every fitted number of the last model.

        Returns
        -------
        DataFrame
            By `number`: value, uncertainty (one standard deviation; NaN of what is fixed or free in
            every run), unit (SI).
        """
        return parameters_frame(self.last)

    def residuals(self, by: Literal["band", "run"] = "band") -> DataFrame:
        """What the last model leaves, by band or run, and channel.

        Parameters
        ----------
        by
            "band" or "run".

        Returns
        -------
        DataFrame
            As of `Comparison.residuals`.
        """
        return self.comparison.residuals(by)

    def agreement(self) -> DataFrame:
        """The field's figures of agreement by run and channel.

        Returns
        -------
        DataFrame
            As of `Comparison.agreement`.
        """
        return self.comparison.agreement()

    def struts(self) -> DataFrame:
        """What every strut did, measured and modelled.

        Returns
        -------
        DataFrame
            Shares of the time in bump and rebound at low and high speed, velocity, travel; at the
            wheel, in band, positive in rebound; SI.
        """
        from wheelhop.report.strut_motion import struts_frame

        return struts_frame(self.campaign, self.steps)

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
        """What `--json` of the command writes.

        Returns
        -------
        dict
            Dictionaries, lists, texts and numbers; what is undetermined is None.
        """
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
