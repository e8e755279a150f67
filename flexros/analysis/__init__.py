"""Analysis of recorded runs: path error, path performance (ISO 9283), tracking, loop timing, and reports."""

from __future__ import annotations

from flexros.analysis.run_analysis import Analysis, analyse

__all__ = ["Analysis", "analyse"]
