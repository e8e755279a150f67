"""The report of runs: one HTML file with interactive pictures; one file per section."""

from __future__ import annotations

from flexros.analysis.report.write import write_comparison, write_report

__all__ = ["write_comparison", "write_report"]
