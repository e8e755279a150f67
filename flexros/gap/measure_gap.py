"""The gap numbers alone: how far a model is from a log, and how far it is once it is repaired."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.blas_threads import one_blas_thread
from flexros.gap.answer.decision import doubted
from flexros.gap.candidates.tolerance import tolerance_of
from flexros.gap.held_out.prediction_gap import errors_ahead, gap_numbers
from flexros.gap.held_out.rounding import over_expected_floor, unknown_rounding
from flexros.gap.residuals.fit_data import fit_data
from flexros.gap.search.candidate_fits import Search
from flexros.gap.search.model_probability import evidence_of
from flexros.gap.settings import DiagnosisSettings

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.held_out.prediction_gap import AheadErrors
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.schema import GapNumbers
    from flexros.record.record import Record


@dataclass(frozen=True)
class MeasuredGap:
    """The gap of a log.

    Attributes:
        numbers: The gap numbers.
        significant: Whether the model, the repaired one where there is one, leaves more than noise and its tolerance,
            or lacks the rounding of an encoder.
    """

    numbers: GapNumbers
    significant: bool


@one_blas_thread()
def measure_gap(
    record: Record,
    model: RobotWithEffects,
    *,
    repaired: RobotWithEffects | None = None,
    tolerance: Mapping[str, float] | None = None,
    settings: DiagnosisSettings | None = None,
) -> MeasuredGap:
    """Measure how far a model is from a log.

    Nothing but what is known with a tolerance only is fitted, so the whole log counts as held-out data.

    Args:
        record: The log.
        model: The nominal model.
        repaired: The same model with a patch on it; None for the nominal one alone.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file.
        settings: Numbers of the diagnosis.

    Returns:
        The numbers: `before` and `noise_floor`, with a repaired model the others too.
    """
    data = fit_data(record, model, settings or DiagnosisSettings())
    before, significant = _errors(model, data, tolerance or {})
    after = None
    if repaired is not None:
        after, significant = _errors(repaired, data, tolerance or {})
    return MeasuredGap(gap_numbers(before, after, record.sample_time), significant)


def _errors(model: RobotWithEffects, data: FitData, tolerance: Mapping[str, float]) -> tuple[AheadErrors, bool]:
    """Predict with a model; also tells whether it leaves more than noise and tolerance, or lacks a rounding."""
    found = Search(model, data, tolerance_of(model.robot, tolerance)).nothing()
    errors = over_expected_floor(errors_ahead(found, data), model, data)
    significant = doubted(evidence_of(data, found), data).significant(found)
    return errors, significant or bool(unknown_rounding(model, data.measurement))
