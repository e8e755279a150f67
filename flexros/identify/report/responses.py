"""Section: measured responses with their uncertainty, and the model before and after (Paper A, figure 8)."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.identify.frf.response_noise import response_noise
from flexros.identify.frf.response_picture import ModelCurve, response_picture
from flexros.report.base import AbstractSection, Block, Picture
from flexros.report.colours import NOMINAL, REPAIRED

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.identify.result import IdentificationResult


POINTS = 300
"""Frequencies at which the models are drawn: resonances between the lines show, and the page stays small (chosen)."""


class ResponseSection(AbstractSection["IdentificationResult"]):
    """One panel per motor pair; menus choose position, and magnitude or phase."""

    title: ClassVar[str] = "Frequency responses"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the picture."""
        return (Picture(_picture(result), _caption(result)),)


def _picture(result: IdentificationResult) -> go.Figure:
    """Draw what was measured at its lines, and the models at frequencies of their own."""
    grid = model_frequencies(result.problem.frequency)
    before, after = (tuple(_modelled(result, values, grid)) for values in (result.nominal, result.fit.values))
    models = (
        ModelCurve("nominal", "nominal model", NOMINAL, 1.2, grid, before),
        ModelCurve("identified", "identified model", REPAIRED, 1.6, grid, after),
    )
    return response_picture(result.problem.responses, models)


def model_frequencies(lines: FloatArray) -> FloatArray:
    """Choose where the models are drawn: evenly over the logarithm of the band.

    Args:
        lines: Measured frequencies, rising [Hz], shape (F,).

    Returns:
        Frequencies [Hz], shape (POINTS,).
    """
    return np.geomspace(lines[0], lines[-1], POINTS)


def _modelled(result: IdentificationResult, values: FloatArray, frequency: FloatArray) -> ComplexArray:
    """Evaluate the model at its own rests, shape (Q, F, M, M)."""
    return replace(result.problem.model_at(values), frequency=frequency).response(values)


def _caption(result: IdentificationResult) -> str:
    bands = [response_noise(response) for response in result.problem.responses]
    band = "; shaded: one standard deviation of the measured response" if any(bands) else ""
    return (
        "Response of the motor accelerations to the motor torques, columns: input, rows: output. Points: measured"
        f"{band}; thin: nominal model, thick: identified model. The menus choose position, and magnitude or phase."
    )
