"""The fitted and the held-out log of a search: their parts that are used, and the weights of their errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros.gap.candidates.tolerance import scaled_by_gravity, tolerance_of
from flexros.gap.fit.torques.noted_timing import with_torque_in_time_behind_springs
from flexros.gap.fit.torques.unknown_numbers import unknown_numbers
from flexros.gap.held_out.split import split
from flexros.gap.noise.weights import measurement_in
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.residuals.fit_samples import part_of_fits, pieces_of_rest
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.search.torque_start import torque_start, with_torques
from flexros.logs.reader import give_memory_back
from flexros.record.prescribed_motion import with_prescribed_motion
from flexros.record.resampled import may_be_resampled, resampled
from flexros.record.torques.shifted_torque import shifted

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.fit.torques.unknown_numbers import UnknownNumbers
    from flexros.gap.prediction.predictor import Predictor
    from flexros.gap.residuals.fit_data import FitData
    from flexros.gap.search.torque_start import TorqueStart
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class UsedLogs:
    """Both logs as far as they are used: of the same rate, driven alike, torques in time.

    Attributes:
        fitted: The log that effects are fitted to.
        held: The held-out one.
        rest: Pieces of what is not used of either.
    """

    fitted: Record
    held: Record
    rest: tuple[Record, ...] = ()


@dataclass(frozen=True, eq=False)
class WeighedLogs:
    """Both logs with the weights of their errors, and the model that they are weighed by.

    Attributes:
        used: Both logs as they were before; the fitted one with the sentences about the model among its warnings.
        model: The nominal model, with the numbers that its file leaves out.
        unknown: These numbers, with their values by the log.
        tolerance: What of the model is tolerated.
        start: What the torques show; None for nothing.
        data: The fitted log.
        held_data: The held-out log.
    """

    used: UsedLogs
    model: RobotWithEffects
    unknown: UnknownNumbers
    tolerance: Tolerance
    start: TorqueStart | None
    data: FitData
    held_data: FitData

    def held_looser(self, level: float, around: tuple[Predictor, FloatArray] | None) -> FitData:
        """Weigh the held-out log, tied more loosely.

        Args:
            level: Torque noise that the predictor allows for [1].
            around: Predictor and parameters of an explanation that predicts it well; None for the nominal model.
        """
        return fit_data(self.used.held, self.model, self.data.settings, self.held_data.measurement, level, around)


def used_logs(record: Record, holdout: Record | None, given: RobotWithEffects, settings: DiagnosisSettings) -> UsedLogs:
    """Prepare both logs.

    Args:
        record: The log.
        holdout: Second log; None: the last part of the first.
        given: The model as it was given.
        settings: Settings of the diagnosis.

    Raises:
        InputError: The holdout was recorded in another way.
    """
    fitted, held = (record, holdout) if holdout is not None else split(record, settings.fitted_share)
    fitted, held = _prescribed_alike(fitted, held, given.robot)
    robot = driven_model(given, fitted).robot
    _check_alike(fitted, held)
    fitted = with_torque_in_time_behind_springs(fitted, robot, settings)
    held = resampled(shifted(held, fitted.torque_shift), fitted.sample_time)
    fitted_part, held_part = (part_of_fits(log, robot, settings) for log in (fitted, held))
    rest = (*pieces_of_rest(fitted, fitted_part), *pieces_of_rest(held, held_part))
    return UsedLogs(fitted_part, held_part, rest)


def weighed_logs(
    used: UsedLogs,
    given: RobotWithEffects,
    tolerance: Mapping[str, float],
    notes: tuple[str, ...],
    settings: DiagnosisSettings,
    *,
    rough_gains: bool,
) -> WeighedLogs:
    """Estimate the numbers that the model lacks, and weigh the errors of both logs.

    Args:
        used: The logs.
        given: The model as it was given.
        tolerance: Relative tolerances other than those of the robot file [1].
        notes: Sentences for the warnings.
        settings: Settings of the diagnosis.
        rough_gains: Whether the servos have gains by the log, whose scale gravity alone fixes.
    """
    fitted, held, model = used.fitted, used.held, driven_model(given, used.fitted)
    stated = tolerance_of(model.robot, tolerance, fitted.prescribed)
    unknown = unknown_numbers(fitted, model, stated, settings.torque_start)
    fitted = replace(fitted, warnings=(*fitted.warnings, *unknown.warnings, *notes))
    model = unknown.given_to(model)
    tolerated = unknown.tolerated(tolerance_of(model.robot, tolerance, fitted.prescribed), model.robot)
    tolerated = scaled_by_gravity(tolerated) if rough_gains else tolerated
    give_memory_back()  # what was needed of a long log beside the part that is used
    data = fit_data(fitted, model, settings)
    measurement = measurement_in(held, model.robot, data.measurement, settings)
    held_data = fit_data(held, model, settings, measurement, data.torque_noise)
    start = torque_start(data, model, tolerated, settings)
    used = replace(used, fitted=fitted)
    return WeighedLogs(used, model, unknown, tolerated, start, with_torques(data, start), held_data)


def _prescribed_alike(fitted: Record, held: Record, robot: Robot) -> tuple[Record, Record]:
    """Let the motion of the same motors drive the model in both logs."""
    return (
        with_prescribed_motion(fitted, robot, held.prescribed, f"it does so in {held.name}"),
        with_prescribed_motion(held, robot, fitted.prescribed, f"it does so in {fitted.name}"),
    )


def _check_alike(fitted: Record, held: Record) -> None:
    """Refuse a holdout that was recorded in another way, for which the fitted predictors do not hold."""
    ways = [
        f"{record.name} has {1 / record.sample_time:.6g} samples per second and {record.driven_by}"
        for record in (held, fitted)
    ]
    if not may_be_resampled(held, fitted.sample_time):
        raise InputError(
            f"{ways[0]}, but {ways[1]}; exchange the two, so that the one with more samples is held out, or give none"
        )
    if held.driven_by != fitted.driven_by:
        raise InputError(f"{ways[0]}, but {ways[1]}; give a holdout that was recorded like the log, or none")
