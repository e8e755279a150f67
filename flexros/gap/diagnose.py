"""The diagnosis of a log, from beginning to end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.blas_threads import one_blas_thread
from flexros.effects import RobotWithEffects
from flexros.gap.answer.rough_gains import relative_to_file
from flexros.gap.candidates.competitors import competitors, not_sought
from flexros.gap.candidates.tolerance import with_torque_tolerance
from flexros.gap.deadline import Deadline
from flexros.gap.diagnosis_task import DiagnosisTask
from flexros.gap.fit.torques.noted_timing import shift_of_noted
from flexros.gap.fit.torques.rough_gains import likely_gains, with_gains
from flexros.gap.held_out.closed_loop_gap import closed_loop_gap, why_not_simulated
from flexros.gap.prediction.driven_model import driven_model
from flexros.gap.progress import Stages
from flexros.gap.residuals.fit_samples import at_rate_of_fits
from flexros.gap.schema import CLOSED_LOOP
from flexros.gap.settings import DiagnosisSettings
from flexros.gap.torque_stages import usual_first, with_smaller_tolerance
from flexros.identify.rigid.torque_timing import in_time

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.gap.diagnosis_task import SearchedLog
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.result import DiagnosisResult
    from flexros.logs.time_series import Log
    from flexros.record.record import Record
    from flexros.robot import Robot


KEPT = 0.2
"""Share of a time limit that is kept for the check on the held-out log [1] (chosen)."""


@one_blas_thread()
def diagnose(
    record: Record,
    robot: Robot | RobotWithEffects,
    *,
    holdout: Record | None = None,
    log: Log | None = None,
    tolerance: Mapping[str, float] | None = None,
    settings: DiagnosisSettings | None = None,
    progress: Callable[[str, float], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> DiagnosisResult:
    """Diagnose the gap between a recorded robot and its model.

    Where the gap shows is computed before any hypothesis, from the nominal model alone. Then candidate causes are
    fitted and ranked on the fitted log, and checked on the held-out one, which may withdraw some.

    Args:
        record: The log that effects are fitted to.
        robot: The nominal model: a robot, or one with effects that are known already.
        holdout: Second log, which checks what was found and may withdraw effects; default: the last third of the first.
        log: The log that `holdout` was read from, or `record` where there is no second one. Where its provenance names
            reference and controller, the gap in closed loop is computed as well; default: it is not.
        tolerance: Relative tolerance of stiffness, inertia and damping [1]; default: those of the robot file. That of
            torque is of the torques of an imported log; default: that of the settings.
        settings: Settings of the diagnosis.
        progress: Called with the name of the stage and the share of all that is done.
        interrupted: Asked between fits, from several threads; True ends the search as `settings.time_limit` does. The
            answer is then what is known until then, and `partial` in it says so.

    Raises:
        InputError: A log from which nothing can be concluded, or a holdout that was recorded in another way.
    """
    settings = with_torque_tolerance(settings or DiagnosisSettings(), tolerance)
    given = robot if isinstance(robot, RobotWithEffects) else RobotWithEffects(robot, ())
    driven = driven_model(given, record).robot
    competitors(driven, settings.search, record.prescribed)  # refuses names before the work
    record = replace(record, warnings=(*record.warnings, *not_sought(record, driven, settings.search)))
    record = at_rate_of_fits(record, given.robot, settings)
    in_closed_loop = log if record.command is None else None
    notes = () if in_closed_loop is None else why_not_simulated(in_closed_loop)
    deadline = Deadline(settings.time_limit, interrupted, KEPT)
    rough = likely_gains(record, driven_model(given, record), settings)
    begun = given
    if rough:
        begun = given.with_effects(rough)
        record, holdout = with_gains(record, begun), None if holdout is None else with_gains(holdout, begun)
    stages = Stages(progress)
    first = usual_first(settings)
    task = DiagnosisTask(begun, holdout, tolerance or {}, notes, first, deadline, stages, bool(rough))
    usual = _in_time(task, task.searched(record))
    task, found = with_smaller_tolerance(task, usual, settings)
    if found is not usual:  # beside what a smaller tolerance showed
        found = _in_time(task, found, found.explanations.chosen)
    result = task.answered(found)
    if rough:
        result = relative_to_file(result, rough, given)

    if in_closed_loop is not None and not notes and not deadline.leaves_out(CLOSED_LOOP):
        stages.begin(CLOSED_LOOP, 1.0)
        repaired = given.with_effects(result.patch) if result.patch else None
        signals = closed_loop_gap(in_closed_loop, given, repaired, begin=found.held_data.record.begin)
        result = replace(result, signals=(*result.signals, *signals))
    stages.end()
    return replace(result, diagnosis=result.diagnosis.model_copy(update={"partial": deadline.partial}))


def _in_time(task: DiagnosisTask, found: SearchedLog, begun: CandidateFit | None = None) -> SearchedLog:
    """Search a log once more with torques that acted half a sample elsewhere, where effects had hidden that.

    Args:
        task: What is diagnosed against.
        found: What was found.
        begun: An explanation that the search begins with; default: what the torques show.
    """
    if task.deadline.stops():
        return found
    shift = shift_of_noted(found.explanations.chosen, found.null, task.settings)
    return found if shift is None else task.searched(in_time(found.record, shift), begun)
