"""The searches of an imported log one after the other, with smaller and smaller tolerances of its torques.

An observer that trusts torques more follows the encoders less. Where the nominal model is far off, its errors are then
thousands of floors, and while effects are missing, tolerated numbers of the model and effects of another kind stand for
them. So each search with a smaller tolerance begins with what the one before found.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from flexros.gap.candidates.tolerance import TORQUE, with_torque_tolerance
from flexros.gap.held_out.errors_ahead import errors_ahead
from flexros.gap.held_out.gap_floor import tolerance_floor
from flexros.gap.search.better_torques import are_better, most_begun, tolerance_on_trial
from flexros.gap.search.looser import STEP
from flexros.gap.search.worth import beyond_noise
from flexros.gap.settings import NoiseSettings

if TYPE_CHECKING:
    from flexros.gap.diagnosis_task import DiagnosisTask, SearchedLog
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record


def usual_first(settings: DiagnosisSettings) -> DiagnosisSettings:
    """Return the settings of the first search: no tolerance of torques is smaller there than the usual one.

    Args:
        settings: Settings of the diagnosis.
    """
    usual = NoiseSettings().signal_tolerance
    return with_torque_tolerance(settings, {TORQUE: usual}) if settings.noise.signal_tolerance < usual else settings


def with_smaller_tolerance(
    task: DiagnosisTask, found: SearchedLog, settings: DiagnosisSettings
) -> tuple[DiagnosisTask, SearchedLog]:
    """Search on down to the stated tolerance of the torques, or on trial with smaller ones where nobody stated one.

    Each one is a tenth of the one before, and the last one is as stated; to exact torques it is one step.

    Args:
        task: What is diagnosed against, with the settings of the first search.
        found: What that found.
        settings: Settings of the diagnosis.

    Returns:
        The task with the last tolerance, and what was found with it.
    """
    if is_assumed(found.record, settings):
        return _with_better_torques(task, found)
    stated, counts = settings.noise.signal_tolerance, task.settings.noise.signal_tolerance
    while stated < counts and not found.record.premises.floor_is_noise:
        by_steps = stated > 0 and not task.deadline.stops()
        counts = max(stated, counts / STEP) if by_steps else stated
        task = replace(task, settings=with_torque_tolerance(settings, {TORQUE: counts}))
        begun = found.explanations.detected and found.explanations.beside is None
        found = task.searched(found.record, found.explanations.chosen if begun else None)
    return replace(task, settings=settings), found


def is_assumed(record: Record, settings: DiagnosisSettings) -> bool:
    """Return whether nobody stated how well the measured torques of a real machine are known.

    Args:
        record: The log.
        settings: Settings of the diagnosis.
    """
    stated = "signal_tolerance" in settings.noise.model_fields_set
    return not (stated or record.premises.floor_is_noise) and record.command is None


def _with_better_torques(task: DiagnosisTask, found: SearchedLog) -> tuple[DiagnosisTask, SearchedLog]:
    """Search on with a smaller tolerance of the torques of an imported log, on trial.

    Args:
        task: What is diagnosed against, with the assumed tolerance.
        found: What was found with it.

    Returns:
        The task and what was found with the last tolerance at which further effects explained most of what was left.
    """
    assumed, notes, share = task.settings.noise, task.notes, task.settings.search.within_floor
    while _may_hide(found) and not task.deadline.stops():
        chosen, known = found.explanations.chosen, found.explanations.detected
        counts = task.settings.noise.signal_tolerance
        left = found.beyond_noise(chosen) if known else beyond_noise(found.search, chosen)
        tried = tolerance_on_trial(counts, left, again=counts < assumed.signal_tolerance)
        if tried is None:
            break
        note = (
            f"the torques are better than the {assumed.signal_tolerance:g} of their rms that counts as no gap where "
            f"nothing is stated, as those of a simulator or of a calibrated drive: here {tried:g} counts as none"
        )
        settings = with_torque_tolerance(task.settings, {TORQUE: tried})
        trial = replace(task, notes=(*notes, note), settings=settings, torques_better=True)
        begins = (chosen, most_begun(assumed.signal_tolerance, tried)) if known else ()
        more = trial.searched(found.record, *begins)
        begun, grown = more.search.base if known else more.null.fit, more.explanations.chosen
        if task.deadline.over or begun.names != chosen.names or grown.names == chosen.names:
            break
        left = more.beyond_noise(grown)
        explained = left < share * more.beyond_noise(begun)
        if not (explained and are_better(assumed.signal_tolerance, tried, left, instead=known)):
            break
        task, found = trial, more
    return task, found


def _may_hide(found: SearchedLog) -> bool:
    """Return whether effects may be hidden within the assumed tolerance of torques.

    They may beside others, and where none was found although the held-out log is predicted far worse 0.1 s ahead than
    torques within tolerance excuse: springs let one sample pass for torques that are off.
    """
    if found.explanations.detected:
        return found.explanations.beside is None
    null, held = found.explanations.null, found.held_data
    excused = tolerance_floor(null, held)
    return excused is not None and errors_ahead(null, held).mean > held.settings.ranking.floors * excused
