"""Frequency responses of all positions of a log."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.frf.aligned_log import align
from flexros.identify.frf.checks.planned_positions import check_positions
from flexros.identify.frf.checks.record_checks import model_warnings
from flexros.identify.frf.estimate.estimate_response import frequency_response_of
from flexros.identify.frf.experiments import Experiments
from flexros.identify.frf.settings import FrfSettings
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Segment
    from flexros.identify.frf.aligned_log import AlignedLog
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.logs.time_series import Log
    from flexros.robot import Robot


def estimate_responses(
    log: Log,
    plan: ExperimentPlan,
    settings: FrfSettings | None = None,
    robot: Robot | None = None,
    start_stamp: int | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[FrequencyResponse, ...]:
    """Estimate the response from torque commands to motor accelerations in every position of a log.

    Args:
        log: The log.
        plan: The plan of its experiment, e.g. from `plan_of_log`.
        settings: Settings of the estimation.
        robot: The nominal robot: torque limits, and order, signs, level and delay of the joints are checked as well.
        start_stamp: Stamp of the plan's sample 0 [ns]; default: 1 s for logs of FlexROS, else the first measurement.
        progress: Called with the number of completed positions and their total number.

    Returns:
        One response per position that was visited, in the order of the plan's positions.

    Raises:
        InputError: The record would give a wrong response; the message names location and cause.
    """
    chosen = FrfSettings() if settings is None else settings
    aligned = align(log, plan, start_stamp)
    segments, warnings = _complete(plan, aligned, _stopped_at(log), chosen.partial)
    check_positions(aligned, plan, segments, robot)
    visited = sorted({segment.position for segment in segments})
    responses = []
    for done, position in enumerate(visited):
        recorded_periods = [segment for segment in segments if segment.position == position]
        experiments = experiments_of(aligned, plan, recorded_periods, robot)
        response = frequency_response_of(experiments, chosen, robot).as_quantity("acceleration")
        responses.append(replace(response, warnings=(*aligned.warnings, *warnings, *response.warnings)))
        if progress is not None:
            progress(done + 1, len(visited))
    warnings_of_model = tuple(model_warnings(responses, robot))
    return tuple(replace(response, warnings=response.warnings + warnings_of_model) for response in responses)


def experiments_of(
    aligned: AlignedLog, plan: ExperimentPlan, segments: list[Segment], robot: Robot | None = None
) -> Experiments:
    """Extract the recorded periods of one position from a log.

    Args:
        aligned: The signals.
        plan: The plan.
        segments: The recorded periods, all of one position.
        robot: The nominal robot, for units; None: rotary motors.

    Returns:
        The samples of all its experiments.

    Raises:
        InputError: Samples are missing.
    """
    rows = [aligned.rows(segment.first, segment.stop, _name(segment)) for segment in segments]
    n_motors, position = plan.n_motors, segments[0].position
    rotary = [True] * n_motors if robot is None else [motor.rotary for motor in robot.motors]
    return Experiments(
        inputs=np.array([aligned.torque[part] for part in rows]),
        outputs=np.array([aligned.position[part] for part in rows]),
        reference=None if aligned.reference is None else np.array([aligned.reference[part] for part in rows]),
        n_periods=segments[0].n_periods,
        sample_time=aligned.sample_time,
        periodic=plan.periodic,
        excited=plan.excited_lines,
        odd_detection=plan.odd_detection_lines,
        even_detection=plan.even_detection_lines,
        block=np.array([segment.block for segment in segments], dtype=np.int64),
        input_names=aligned.names,
        output_names=aligned.names,
        input_units=tuple(unit_of("torque", turns) for turns in rotary),
        coordinate_units=tuple(unit_of("position", turns) for turns in rotary),
        quantity="position",
        gears=plan.positions[position],
        label=f"position {position + 1}",
    )


def _complete(
    plan: ExperimentPlan, aligned: AlignedLog, stopped_at: int | None, partial: bool
) -> tuple[list[Segment], list[str]]:
    """Return the segments to use: all, or with `partial` those of blocks that ended as planned in the log."""
    segments = list(plan.segments)
    if not partial:
        _check_not_stopped(plan, stopped_at)
        return segments, []
    recorded = min(int(aligned.numbers[-1]), aligned.last_command) + 1
    end = recorded if stopped_at is None else min(recorded, stopped_at)
    ends: dict[tuple[int, int], int] = {}
    for segment in segments:
        block = segment.position, segment.block
        ends[block] = max(ends.get(block, 0), segment.stop)
    used = [segment for segment in segments if ends[segment.position, segment.block] <= end]
    silent = aligned.last_command < int(aligned.numbers[-1])
    ends_by = ("the log ends", "it ends") if not silent else ("the commands of the log end", "its commands end")
    why = ends_by[0] if end == recorded else "the experiment was stopped"
    if not used:
        what = f"too short a log: {ends_by[1]}" if end == recorded else "too short an experiment: it was stopped"
        raise InputError(
            f"{what} at {max(end - 1, 0) * plan.sample_time:.3f} s, before the first block is complete at "
            f"{(min(ends.values()) - 1) * plan.sample_time:.3f} s; record longer"
        )
    n_cut = sum(stop > end for stop in ends.values())
    return used, [f"{why} before its plan; {n_cut} incomplete blocks were left out"] if n_cut else []


def _stopped_at(log: Log) -> int | None:
    """Return the first sample that may differ from the plan because the user stopped the experiment."""
    stopped = log.provenance.get("stopped")
    sample = stopped.get("stopped_at_sample") if isinstance(stopped, Mapping) else None
    return sample if isinstance(sample, int) and sample >= 0 else None


def _check_not_stopped(plan: ExperimentPlan, stopped_at: int | None) -> None:
    """Reject a log whose experiment was stopped before its last recorded period."""
    complete = sum(stopped_at is None or segment.stop <= stopped_at for segment in plan.segments)
    if stopped_at is None or complete == len(plan.segments):
        return
    raise InputError(
        f"the experiment of the log was stopped at {stopped_at * plan.sample_time:.3f} s, when {complete} of "
        f"{len(plan.segments)} experiments were complete, and what follows is not as planned; use the complete "
        "blocks (setting partial=true), or run the experiment to its end"
    )


def _name(segment: Segment) -> str:
    return f"position {segment.position + 1}, block {segment.block + 1}, experiment {segment.experiment + 1}"
