"""What comparing and diagnosing give beside what every result has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wheelhop.api.result import Result
from wheelhop.compare import Comparison, to_json
from wheelhop.diagnose import Diagnosis, Step, comparison_of
from wheelhop.diagnose import to_json as diagnosis_to_json
from wheelhop.diagnose.diagnosis import ranking_frame
from wheelhop.effects import Effect
from wheelhop.files.words import significant
from wheelhop.fit import Workshop
from wheelhop.gate import to_json as findings_to_json
from wheelhop.gate.sensors import Seen
from wheelhop.report.words import comparison_headline, headline, over_floor

if TYPE_CHECKING:
    from pandas import DataFrame

    from wheelhop.law import LastRungs


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
        """The last model with some of its numbers changed, not fitted again, against the records.

        Parameters
        ----------
        changes
            Values in SI by their names in `parameters`: {"suspension.front.damping_N_s_m": 700.0}.

        Returns
        -------
        Comparison
            With the errors, and the signals of every run.

        Raises
        ------
        KeyError
            The model has no such number.
        """
        for name in changes:
            self.model.values[name]
        return comparison_of(self.workshop, self.last.rung, changes)

    def to_json(self) -> dict[str, Any]:
        """What `wheelhop compare --json` writes.

        Returns
        -------
        dict
            The last model's comparison, the errors on the way to it, the comparison driven by the
            measured axles, and the findings of the gate (schema "compare-output").
        """
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

        Parameters
        ----------
        file
            Such as "report.html"; what stood there is replaced.

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
        """Every effect of the library against what the baseline leaves.

        Returns
        -------
        DataFrame
            By `effect`, best first: errors as screened, confirmed and validated, logarithm of the
            evidence, p, angle (degrees) to the effect hardest to tell from it, the reason.
        """
        return ranking_frame(self.diagnosis.ranking)

    def to_json(self) -> dict[str, Any]:
        """What `wheelhop diagnose --json` writes.

        Returns
        -------
        dict
            Verdict, reasons, ranking, ladder and more (schema "diagnose-output").
        """
        from wheelhop.report.law import rungs_to_json

        return {**diagnosis_to_json(self.diagnosis), "law": rungs_to_json(self.law)}

    def write_report(self, file: str | Path) -> None:
        """Write the report, one self-contained HTML page.

        Parameters
        ----------
        file
            Such as "report.html"; what stood there is replaced.

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
