"""The gap numbers alone: the prediction errors of a model in a log, before and after a repair."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from flexros.blas_threads import one_blas_thread
from flexros.errors import InputError
from flexros.gap.answer.strained_numbers import STRAINED_ALONE, far_out, moved_words
from flexros.gap.candidates.tolerance import TORQUE, tolerance_of, with_torque_tolerance
from flexros.gap.deadline import Deadline
from flexros.gap.fit.null_fit import fit_null
from flexros.gap.fit.torques.noted_timing import shift_of_noted, with_torque_in_time_behind_springs
from flexros.gap.fit.torques.rough_gains import with_likely_gains
from flexros.gap.fit.torques.unknown_numbers import unknown_numbers
from flexros.gap.held_out.constant_speed import moving_on, moving_on_words
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.gap_floor import over_expected_floor, tolerance_floor, unknown_rounding
from flexros.gap.held_out.gap_numbers import WHOLE, gap_numbers, settled
from flexros.gap.held_out.left_over import LeftOver
from flexros.gap.held_out.sensor_scales import sensor_scale_words
from flexros.gap.noise.weights import measurement_of
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.progress import Stages
from flexros.gap.residuals.fit_samples import at_rate_of_fits, part_of_fits
from flexros.gap.residuals.observed_model import NOTHING, ObservedModel
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.better_torques import LEAST
from flexros.gap.search.model_probability import allowing_for_doubt, compare
from flexros.gap.settings import DiagnosisSettings
from flexros.gap.torque_stages import is_assumed
from flexros.identify.rigid.torque_timing import in_time
from flexros.record.joint_signs import sign_words
from flexros.record.stamp_jitter import slight_last

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import pandas as pd
    import plotly.graph_objects as go

    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.null_fit import NullFit
    from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
    from flexros.gap.held_out.errors_ahead import AheadErrors
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.schema import GapNumbers
    from flexros.record.record import Record


LITTLE = 0.5
"""Share of the gap below which a patch closes little of it [1] (chosen)."""


@dataclass(frozen=True)
class MeasuredGap:
    """The gap of a log.

    Attributes:
        numbers: The gap numbers, 0.1 s ahead.
        left: What the model, the repaired one where there is one, leaves one sample ahead.
        warnings: What of the log was repaired or is doubtful, one sentence each.
    """

    numbers: GapNumbers
    left: LeftOver
    warnings: tuple[str, ...] = ()

    @property
    def significant(self) -> bool:
        """Whether that is more than noise and its tolerance, or the model predicts little, see `LeftOver`."""
        return self.left.significant

    def to_pandas(self) -> pd.Series:
        """Return the gap numbers by name, as in diagnosis.json; None where there is none."""
        import pandas as pd

        return pd.Series(self.numbers.model_dump(mode="json"), name="gap", dtype=object)

    def plot(self) -> go.Figure:
        """Draw the gap of the nominal and of the repaired model over the noise floor, logarithmic."""
        from flexros.gap.report.how_far import gap_figure

        return gap_figure(self.numbers)

    def _repr_html_(self) -> str:
        from flexros.gap.report.terminal import gap_line, gap_verdict, hidden_line, left_line
        from flexros.gap.report.words import capital
        from flexros.report.base import Paragraph
        from flexros.report.notebook import notebook_html

        verdict = capital(gap_verdict(self.left, "the model" if self.numbers.after is None else "the repaired model"))
        warnings = (Paragraph(text, "warning") for text in self.warnings)
        lines = (gap_line(self.numbers), left_line(self.left), hidden_line(self.left))
        return notebook_html(verdict, (*(Paragraph(text) for text in lines if text), *warnings))


@one_blas_thread()
def measure_gap(
    record: Record,
    model: RobotWithEffects,
    *,
    repaired: RobotWithEffects | None = None,
    tolerance: Mapping[str, float] | None = None,
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> MeasuredGap:
    """Measure the gap between a model and a log.

    Only tolerated deviations are fitted, so the whole log counts as held-out data.

    Args:
        record: The log.
        model: The nominal model.
        repaired: The same model with a patch on it; None for the nominal one alone.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file. That of
            torque is of the torques of an imported log; default: that of the settings.
        settings: Settings of the diagnosis. Its time limit ends the fits of tolerated deviations at their next
            iteration, which a warning says.
        progress: Called with the name of the stage and the share of all that is done.

    Returns:
        The gap numbers: `before` and `noise_floor`, with a repaired model the others too.
    """
    settings = with_torque_tolerance(settings or DiagnosisSettings(), tolerance)
    on_trial = repaired is None and is_assumed(record, settings)
    stages, deadline, half = Stages(progress), Deadline(settings.time_limit), 0.5 if repaired or on_trial else 1.0
    stages.begin("nominal model", half)
    record = at_rate_of_fits(record, model.robot, settings)
    model = driven_model(model, record)
    record = with_torque_in_time_behind_springs(record, model.robot, settings)
    record = part_of_fits(record, model.robot, settings)
    record = with_likely_gains(record, model, repaired, settings)
    fits = _fits(record, model, repaired, tolerance or {}, settings, stages, deadline)
    shift = None if deadline.over else shift_of_noted(fits.last.fit, fits.last, settings)
    if shift is not None:  # errors of springs in the nominal model hid when the torques acted
        stages.again()
        stages.begin("nominal model", half)
        record = in_time(record, shift)
        fits = _fits(record, model, repaired, tolerance or {}, settings, stages, deadline)
    data, before = fits.data, _errors(fits.nominal, fits.data)
    after = None if fits.repaired is None else _errors(fits.repaired, data)
    floor = tolerance_floor(fits.last.fit, data)
    left = _left_over(fits, (after or before).mean, floor)
    if after is not None:
        alike = moving_on(fits.last.fit, model.robot, data, before, after)
        left = replace(left, moving_on=tuple(alike))
    elif on_trial and not left.significant and not deadline.over:
        stages.begin("better torques", 1.0)
        better = with_torque_tolerance(settings, {TORQUE: LEAST})
        fitted = partial(_fits, record, model, None, tolerance or {}, better, stages, deadline)
        left = _with_hidden(left, fitted, settings.noise.signal_tolerance)
    numbers = gap_numbers(before, after, record.sample_time, with_tolerance=floor)
    explained_by = None if repaired is None or left.significant else [law.effect for law in repaired.laws]
    closed = numbers.closed_fraction if left.significant or repaired is not None else WHOLE
    warnings = settled(data.record, closed, explained_by).warnings
    scales = sensor_scale_words(fits.last.fit, data)
    doubts = (*moving_on_words(left.moving_on), *_moved(fits, numbers.closed_fraction), *scales)
    signs = sign_words(record) if left.significant else ()
    return MeasuredGap(numbers, left, slight_last((*doubts, *signs, *warnings, *_cut_short(deadline))))


@dataclass(frozen=True, eq=False)
class _Fits:
    """The fits of tolerated deviations to a log.

    Attributes:
        data: Log and weights.
        nominal: The nominal model.
        repaired: The repaired one; None without a repair.
        lacked: Names of the numbers that the model lacked and was given.
    """

    data: FitData
    nominal: NullFit
    repaired: NullFit | None
    lacked: frozenset[str]

    @property
    def last(self) -> NullFit:
        """The model whose gap counts."""
        return self.repaired or self.nominal


def _fits(
    record: Record,
    model: RobotWithEffects,
    repaired: RobotWithEffects | None,
    tolerance: Mapping[str, float],
    settings: DiagnosisSettings,
    stages: Stages,
    deadline: Deadline,
) -> _Fits:
    """Estimate the numbers that the nominal model lacks, and fit the tolerated deviations of both models to the log."""
    stated = tolerance_of(model.robot, tolerance, record.prescribed)
    unknown = unknown_numbers(record, model, stated, settings.torque_start, as_stated=True)
    record = replace(record, warnings=(*record.warnings, *unknown.warnings))
    data = _data(record, unknown.given_to(model), repaired, settings)
    nominal = _fitted(model, unknown, data, tolerance, settings, stages, deadline)
    lacked = unknown.names(nominal.model.robot)
    if repaired is None:
        return _Fits(data, nominal, None, lacked)
    stages.begin("repaired model", 1.0)
    patched = _fitted(driven_model(repaired, record), unknown, data, tolerance, settings, stages, deadline)
    return _Fits(data, nominal, patched, lacked)


def _data(
    record: Record, model: RobotWithEffects, repaired: RobotWithEffects | None, settings: DiagnosisSettings
) -> FitData:
    """Weigh a log by the nominal model, or by the repaired one where the nominal model cannot follow it at all."""
    try:
        return fit_data(record, model, settings)
    except InputError:
        if repaired is None:
            raise
        given = driven_model(repaired, record)
        measurement = measurement_of(record, given.robot, settings)
        observed = ObservedModel.of(record, given, measurement, settings.residuals)
        return fit_data(record, model, settings, measurement, around=(observed.predictor, NOTHING[:, 0]))


def _moved(fits: _Fits, closed: float | None) -> tuple[str, ...]:
    """State the numbers of the nominal model that its fit moves far out of their tolerance.

    Args:
        fits: The fits.
        closed: Share of the gap that the patch closes [1]; None without a patch, or where no gap shows.
    """
    fit = fits.nominal.fit
    factors = {name: factor for name, factor in far_out(fit, STRAINED_ALONE).items() if name not in fits.lacked}
    if not factors:
        return ()
    which = "the nominal model" if fits.repaired is None else "before the patch the nominal model"
    text = f"{which} is that with numbers moved beyond their tolerance: {moved_words(fit, factors)}."
    if closed is not None and closed < LITTLE:
        text += " So a patch that states them closes little of its gap."
    return (f"{text} Give a smaller tolerance to see the gap of the file",)


def _cut_short(deadline: Deadline) -> tuple[str, ...]:
    """Say that the time limit ended the fits."""
    if deadline.partial is None:
        return ()
    return (
        f"the time limit ended the fits of tolerated numbers after {deadline.partial.after:.3g} s: with more time the "
        "gap may come out smaller",
    )


def _fitted(
    given: RobotWithEffects,
    unknown: UnknownNumbers,
    data: FitData,
    tolerance: Mapping[str, float],
    settings: DiagnosisSettings,
    stages: Stages,
    deadline: Deadline,
) -> NullFit:
    """Fit the tolerated deviations of a model to the log, with the numbers that it lacks."""
    lacked = unknown.lacked_by(given)
    model = lacked.given_to(given)
    tolerated = lacked.tolerated(tolerance_of(model.robot, tolerance, data.record.prescribed), model.robot)
    stop = stages.of_fit(settings.fit.null_iterations, deadline.stops)
    return fit_null(data, model, tolerated, settings.fit, stop=stop)


def _errors(null: NullFit, data: FitData) -> AheadErrors:
    """Return the prediction errors of a model."""
    return over_expected_floor(errors_ahead(null.fit, data), null.model, data)


def _left_over(fits: _Fits, ahead: float, with_tolerance: float | None) -> LeftOver:
    """Return what a model leaves one sample ahead, and what of it is noise and tolerance, as a diagnosis has it."""
    null, data = fits.last, fits.data
    settings, names = data.settings.ranking, null.model.robot.joint_names
    comparison = allowing_for_doubt(compare(data, null.fit, settings=settings), data)
    return LeftOver(
        level=comparison.level(null.fit),
        most=1.0 + settings.significant * comparison.spread,
        most_of_machine=None if data.record.premises.floor_is_noise else settings.floors,
        ahead=ahead,
        most_ahead=settings.floors * (with_tolerance or 1.0),
        lacking=tuple(names[encoder.motor] for encoder in unknown_rounding(null.model, data.measurement)),
        strained=tuple(name for name in far_out(null.fit, STRAINED_ALONE, large=False) if name not in fits.lacked),
    )


def _with_hidden(left: LeftOver, fitted: Callable[[], _Fits], assumed: float) -> LeftOver:
    """State the gap that an assumed tolerance of torques hides.

    Args:
        left: What the model leaves with that tolerance, which is no gap.
        fitted: Fits the model with a much smaller one.
        assumed: The assumed one [1].
    """
    try:
        better = fitted()
    except InputError:  # with hardly any correction the prediction diverges, so that there is no figure
        return left
    ahead = _errors(better.last, better.data).mean
    if not _left_over(better, ahead, tolerance_floor(better.last.fit, better.data)).significant:
        return left
    return replace(left, assumed=assumed, if_known=ahead)
