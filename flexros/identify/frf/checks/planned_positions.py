"""Check of the joint positions against the plan: swapped joints, encoder offsets, wrong units."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.identify.experiment.excursion import excursion

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.identify.experiment.timetable import Segment
    from flexros.identify.frf.aligned_log import AlignedLog
    from flexros.robot import Robot

FARTHEST = 0.1
"""Largest distance of a mean motor position from the plan [rad or m] (chosen): gears sag ten times less."""

STILL = 1e-3
"""Largest difference between the mean positions of a joint at rest [rad or m] (chosen)."""

SAME_FACTOR = 0.1
"""Largest misfit of a factor to the positions, over the largest of them, for its acceptance (chosen)."""

_NAMED = {
    float(np.degrees(1.0)): "degrees were recorded instead of radians",
    float(np.radians(1.0)): "radians were converted from degrees although they were radians",
    1e3: "millimetres were recorded instead of metres",
    1e-3: "metres were converted from millimetres although they were metres",
    -1.0: "the direction of the joint is inverted",
}


def check_positions(
    aligned: AlignedLog, plan: ExperimentPlan, segments: list[Segment], robot: Robot | None = None
) -> None:
    """Reject a log whose joint positions differ from the plan.

    The mean of the measured motor position over the recorded periods is compared with that of the plan, slow motion
    included. A controller keeps it within the sag of the gears, whatever the springs and loads.

    Args:
        aligned: The signals.
        plan: The plan.
        segments: The recorded periods that are used, not empty.
        robot: The nominal robot, for units; None: rotary motors.

    Raises:
        InputError: A position differs; names joint and likely cause.
    """
    measured, planned, places = _means(aligned, plan, segments)
    wrong = abs(measured - planned) > FARTHEST
    if not np.any(wrong):
        return
    place, motor = (int(number) for number in np.argwhere(wrong)[0])
    unit = "rad" if robot is None else robot.motors[motor].position_unit
    cause = _swapped(measured, planned, aligned.names, motor) or _cause(measured[:, motor], planned[:, motor], unit)
    raise InputError(
        f"position {places[place] + 1}: {aligned.names[motor]} is at {measured[place, motor]:.4g} {unit}, the plan "
        f"says {planned[place, motor]:.4g} {unit} (allowed is a distance of {FARTHEST:g} {unit}): {cause}"
    )


def _means(
    aligned: AlignedLog, plan: ExperimentPlan, segments: list[Segment]
) -> tuple[FloatArray, FloatArray, list[int]]:
    """Return the mean measured and planned position of every position visited, shapes (Q, M), and their numbers."""
    used: dict[int, list[Segment]] = {}
    for segment in segments:
        used.setdefault(segment.position, []).append(segment)
    measured, planned = [], []
    visits = {visit.position: visit for visit in plan.visits}
    for position, mine in used.items():
        visit = visits[position]
        added = excursion(plan, visit).position
        rows = [np.searchsorted(aligned.numbers, (segment.first, segment.stop)) for segment in mine]
        means = [np.mean(aligned.position[begin:end], axis=0) for begin, end in rows if end > begin]
        if not means:
            continue  # the gap is named when these periods are cut out
        measured.append(np.mean(means, axis=0))
        parts = [added[segment.first - visit.lead : segment.stop - visit.lead].mean(axis=0) for segment in mine]
        planned.append(plan.positions[position] + np.mean(parts, axis=0))
    if not measured:
        return np.zeros((0, plan.n_motors)), np.zeros((0, plan.n_motors)), []
    return np.array(measured), np.array(planned), list(used)


def _swapped(measured: FloatArray, planned: FloatArray, names: tuple[str, ...], motor: int) -> str | None:
    """Name the swapped joints where those that differ fit in another order; None otherwise."""
    order = _order(measured, planned)
    moved = np.flatnonzero(order != np.arange(len(order)))
    if motor not in moved or np.any(abs(measured[:, moved] - planned[:, order[moved]]) > FARTHEST):
        return None
    swapped = ", ".join(f"{names[i]} is at the position of {names[order[i]]}" for i in moved)
    return f"swapped joints: {swapped}; correct the joint names of joint_states and joint_commands"


def _order(measured: FloatArray, planned: FloatArray) -> IntArray:
    """Return for each measured joint the planned one at the smallest total distance, shape (M,)."""
    from scipy.optimize import linear_sum_assignment  # here, because it loads slowly

    distance = np.max(abs(measured[:, :, None] - planned[:, None, :]), axis=0)
    cost = np.minimum(distance, 10.0) - 1e-9 * np.eye(len(distance))
    return np.asarray(linear_sum_assignment(cost)[1], dtype=np.int64)


def _cause(measured: FloatArray, planned: FloatArray, unit: str) -> str:
    """Name the likely cause of one joint: unit, direction, factor, offset or another plan; shapes (Q,)."""
    offset = measured - planned
    if np.ptp(planned) > FARTHEST and np.ptp(measured) < STILL:
        return "it is there in all positions, so its encoder is stuck; record positions that were measured"
    power = float(planned @ planned)
    if power > 0:
        for named, text in _NAMED.items():
            if _fits(measured, planned, named):
                return f"unit: it is {named:.4g} times the plan, so {text}; give the unit or sign in the mapping file"
        factor = float(measured @ planned) / power
        if np.ptp(planned) > FARTHEST and factor != 0 and _fits(measured, planned, factor) and np.ptp(offset) > 0.05:
            return (
                f"factor: in all positions it is {factor:.3g} times the plan; correct unit or gear ratio in the "
                "mapping file"
            )
    if np.ptp(offset) <= FARTHEST:
        return (
            f"offset: the encoder is off by {np.mean(offset):.4g} {unit}, which is not what the plan counts from; "
            "correct its offset in the mapping file, or give the scenario of this log"
        )
    return (
        "its distance differs from position to position; give the scenario this log was recorded with, and "
        "its start stamp where the log does not begin with the experiment"
    )


def _fits(measured: FloatArray, planned: FloatArray, factor: float) -> bool:
    """Return whether the measured positions are the planned ones times a factor."""
    return bool(np.all(abs(measured - factor * planned) <= SAME_FACTOR * abs(factor) * np.max(abs(planned))))
