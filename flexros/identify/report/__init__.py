"""Report of an identification: one section per file, one HTML page that opens offline."""

from __future__ import annotations

from flexros.identify.report.write import write_identification_report
from flexros.identify.result import ExperimentFacts, IdentificationResult, identification_result

__all__ = ["ExperimentFacts", "IdentificationResult", "identification_result", "write_identification_report"]
