"""Reports: a diagnosis or a comparison as one self-contained page, and the fitted model."""

from wheelhop.report.reports import write_comparison_report, write_diagnosis_report

__all__ = ["write_comparison_report", "write_diagnosis_report"]
