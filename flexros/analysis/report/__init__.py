"""Report of runs: one HTML file with interactive pictures; one module per section."""

from __future__ import annotations

from flexros.analysis.report.write import write_comparison, write_report

__all__ = ["write_comparison", "write_report"]
