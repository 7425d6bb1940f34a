"""Reports: a diagnosis, a comparison or bushings as one self-contained page; the fitted model."""

from wheelhop.report.bushings import BushingResult, write_bushing_report
from wheelhop.report.reports import write_comparison_report, write_diagnosis_report

__all__ = [
    "BushingResult",
    "write_bushing_report",
    "write_comparison_report",
    "write_diagnosis_report",
]
