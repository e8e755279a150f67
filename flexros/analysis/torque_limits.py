"""Effective torque limit of each motor, and its influence on a run."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.analysis.tracking import Drive, assign_drives

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from flexros.analysis.tracking import MotorTracking
    from flexros.arrays import FloatArray

CONTROLLER_LIMIT = "controller.torque_limit"
"""Key of a scenario that limits the command below the limit of the robot."""

_LONG = 0.01
"""Share of the run at the limit above which a warning is given (chosen)."""


def limited_drives(
    drives: Sequence[Drive] | None, joints: Sequence[str], provenance: Mapping[str, Any], warnings: list[str]
) -> dict[str, Drive] | None:
    """Return the motor of each joint, with the smaller of the limits of robot and controller.

    Args:
        drives: The motors of the robot, in the order of the chain; None where the robot is not known.
        joints: Joint names of the log.
        provenance: Where the log came from; its scenario may limit the command.
        warnings: Receives a sentence where names differ or a limit cannot be used.

    Returns:
        Motor by joint; None where neither robot nor limit is known.

    Raises:
        InputError: The robot has another number of motors than the log.
    """
    scenario = provenance.get("scenario")
    controller = scenario.get("controller") if isinstance(scenario, dict) else None
    given = controller.get("torque_limit") if isinstance(controller, dict) else None
    if drives is None and given is None:
        return None
    known = [Drive(joint, np.inf) for joint in joints] if drives is None else list(drives)
    if given is not None:
        limits = _limits(given, len(known))
        if limits is None:
            warnings.append(
                f"{CONTROLLER_LIMIT} in the provenance is {given!r}, allowed is a positive number or one for each of "
                f"the motors ({len(known)}); it was ignored"
            )
        else:
            known = [
                replace(drive, torque_limit=float(limit), limited_by=CONTROLLER_LIMIT)
                if limit < drive.torque_limit
                else drive
                for drive, limit in zip(known, limits, strict=True)
            ]
    return assign_drives(known, joints, warnings)


def _limits(given: object, n_motors: int) -> FloatArray | None:
    """Expand a limit to the motors; None where it is not a valid one."""
    try:
        values = np.atleast_1d(np.asarray(given, dtype=np.float64))
    except (TypeError, ValueError):
        return None
    if values.ndim != 1 or values.size not in (1, n_motors) or not np.all(values > 0.0):
        return None
    return np.array(np.broadcast_to(values, (n_motors,)))


def limit_warnings(motors: Sequence[MotorTracking]) -> Iterator[str]:
    """Warn where the limit restricts a motor, and where the motion requires more than it allows.

    Args:
        motors: Torques of the motors.

    Yields:
        One sentence for each.
    """
    for motor in motors:
        if motor.torque_limit is None:
            continue
        unit = "N" if motor.linear else "Nm"
        ahead = 0.0 if motor.feedforward is None else float(np.max(np.abs(motor.feedforward)))
        limit = f"limit of {motor.torque_limit:g} {unit} ({motor.limited_by})"
        if motor.saturated_share is not None and motor.saturated_share > _LONG:
            yield (
                f"the command of {motor.joint} is at its {limit} for {1e2 * motor.saturated_share:.3g} % of the run, "
                "where no feedback can act"
            )
        if motor.overload_share:
            yield (
                f"the feedforward torque of {motor.joint} alone exceeds the {limit} for "
                f"{1e2 * motor.overload_share:.3g} % of the run (up to {ahead:.4g} {unit}): the "
                "motor cannot follow this motion; slow it down or raise the limit"
            )
