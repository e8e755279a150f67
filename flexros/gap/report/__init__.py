"""Report of a diagnosis: one HTML file that opens offline, one section per file, and the same words for a terminal."""

from flexros.gap.report.write import diagnosis_report

__all__ = ["diagnosis_report"]
