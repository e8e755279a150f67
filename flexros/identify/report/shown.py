"""An identification as a table (pandas), as a picture, and in a notebook."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import unknown_name

if TYPE_CHECKING:
    import pandas as pd
    import plotly.graph_objects as go

    from flexros.identify.result import IdentificationResult

PICTURES = ("parameters", "responses")
"""Pictures of an identification."""


def parameters_frame(result: IdentificationResult) -> pd.DataFrame:
    """Return the parameters by name: unit, nominal, value, low and high end of 95 % (SI), relative_std [1], verdict."""
    import pandas as pd

    entries = result.identifiability.parameters
    columns: dict[str, object] = {
        "unit": [entry.unit for entry in entries],
        "nominal": np.asarray(result.nominal, dtype=float),
        "value": [entry.value for entry in entries],
        "low": [entry.interval[0] for entry in entries],
        "high": [entry.interval[1] for entry in entries],
        "relative_std": np.asarray(result.covariance.relative, dtype=float),
        "verdict": [entry.verdict for entry in entries],
    }
    if result.truth:
        columns["truth"] = [result.truth.get(entry.name, np.nan) for entry in entries]
    return pd.DataFrame(columns, index=pd.Index([entry.name for entry in entries], name="parameter"))


def identification_figure(result: IdentificationResult, what: str) -> go.Figure:
    """Draw the parameters with their intervals, or the responses with those of the model.

    Args:
        result: The identification.
        what: One of `PICTURES`.

    Raises:
        InputError: Another word.
    """
    from flexros.identify.report.parameters import ParameterSection
    from flexros.identify.report.responses import ResponseSection
    from flexros.report.base import Picture

    if what not in PICTURES:
        raise unknown_name("picture", what, PICTURES)
    section = ParameterSection() if what == "parameters" else ResponseSection()
    pictures = [block.figure for block in section.blocks(result) if isinstance(block, Picture)]
    # intervals are drawn over nominal values, which must be positive for it
    return pictures[0] if pictures else identification_figure(result, "responses")


def identification_html(result: IdentificationResult) -> str:
    """Show verdict, main figures and parameters of an identification in a notebook."""
    from flexros.identify.report.parameters import ParameterSection
    from flexros.identify.report.summary import SummarySection
    from flexros.report.notebook import notebook_html

    blocks = (*SummarySection().blocks(result), *ParameterSection().blocks(result))
    return notebook_html(f"Identification of {result.problem.robot.name}", blocks)
