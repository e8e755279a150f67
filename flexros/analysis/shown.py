"""An analysis as a table (pandas), as a picture, and in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.analysis.figures_table import figure_values
from flexros.errors import InputError

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go

    from flexros.analysis.run_analysis import Analysis

PICTURES = ("path", "errors", "responses")
"""Pictures of an analysis: the path with its error magnified, errors over time, frequency responses."""


def analysis_frame(analysis: Analysis) -> pd.DataFrame:
    """Return all figures as a table by group and name, with value and unit."""
    import pandas as pd

    rows = figure_values(analysis)
    index = pd.MultiIndex.from_tuples([row[:2] for row in rows], names=["group", "figure"])
    return pd.DataFrame({"value": [row[3] for row in rows], "unit": [row[2] for row in rows]}, index=index)


def analysis_figure(analysis: Analysis, what: str = "") -> go.Figure:
    """Draw a run.

    Args:
        analysis: The analysis.
        what: One of `PICTURES`; empty for the first that the log has.

    Raises:
        InputError: The log has no such picture.
    """
    from flexros.analysis.report.error_over_time import ErrorSection
    from flexros.analysis.report.path import path_picture
    from flexros.identify.frf.response_picture import response_picture

    responses = analysis.responses.positions if analysis.responses is not None else ()
    errors = [block for block in ErrorSection().blocks([analysis]) if hasattr(block, "figure")]
    drawn = {"path": analysis.path is not None, "errors": bool(errors), "responses": bool(responses)}
    known = [name for name in PICTURES if drawn[name]]
    if not known or (what and what not in known):
        raise InputError(
            f"the picture '{what or PICTURES[0]}' was asked of {analysis.label}, its log has "
            f"{', '.join(known) or 'none'}; choose one of them",
            "what",
        )
    chosen = what or known[0]
    if chosen == "responses":
        return response_picture(responses)
    if chosen == "errors":
        return errors[0].figure
    picture = path_picture([analysis])
    if picture.factor > 1:
        axis = picture.figure.layout.xaxis.title.text
        picture.figure.update_xaxes(title_text=f"{axis}, error drawn ×{picture.factor}")
    return picture.figure


def analysis_html(analysis: Analysis) -> str:
    """Show verdict, main figures and warnings of a run in a notebook."""
    from flexros.analysis.report.summary import SummarySection
    from flexros.report.base import Paragraph
    from flexros.report.notebook import notebook_html

    warnings = (Paragraph(text, "warning") for text in analysis.warnings)
    return notebook_html(f"Analysis of {analysis.label}", (*SummarySection().blocks([analysis]), *warnings))
