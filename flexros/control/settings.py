"""Settings that are given once for all motors, or one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np
from pydantic import Field

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray

NotNegative: TypeAlias = Annotated[float, Field(ge=0.0)]
Positive: TypeAlias = Annotated[float, Field(gt=0.0)]
Gain: TypeAlias = NotNegative | tuple[NotNegative, ...]
TorqueLimit: TypeAlias = Positive | tuple[Positive, ...] | None


def per_motor(name: str, value: float | tuple[float, ...], n_motors: int) -> FloatArray:
    """Spread a setting over the motors.

    Args:
        name: Name of the setting, for the error.
        value: One number for all motors, or one for each.
        n_motors: Number of motors M.

    Returns:
        The setting of each motor, shape (M,).

    Raises:
        InputError: The number of values is neither one nor M.
    """
    values: FloatArray = np.atleast_1d(np.asarray(value, dtype=float))
    if values.size not in (1, n_motors):
        raise InputError(
            f"controller.{name} has {values.size} values, allowed is one, or one for each of the {n_motors} motors"
        )
    return values * np.ones(n_motors)


def gain_vector(
    gains: Mapping[str, float | tuple[float, ...]],
    torque_limit: float | tuple[float, ...] | None,
    robot_limits: FloatArray | None,
    n_motors: int,
) -> FloatArray:
    """Put gains and torque limit of all motors behind one another.

    Args:
        gains: Gains by name.
        torque_limit: Limit that the scenario sets [Nm]; none if None.
        robot_limits: Limits of the robot's motors [Nm], shape (M,); none if None. The lower of both holds.
        n_motors: Number of motors M.

    Returns:
        Each gain for all motors, then the limit, shape ((len(gains) + 1) * M,).
    """
    limits = np.full(n_motors, np.inf) if robot_limits is None else np.asarray(robot_limits, dtype=float)
    if torque_limit is not None:
        limits = np.minimum(limits, per_motor("torque_limit", torque_limit, n_motors))
    return np.concatenate([*(per_motor(name, value, n_motors) for name, value in gains.items()), limits])


def gain_vector_names(gains: tuple[str, ...], n_motors: int) -> tuple[str, ...]:
    """Name the entries of `gain_vector`, e.g. "motor_1.kp"."""
    return tuple(f"motor_{motor}.{gain}" for gain in (*gains, "torque_limit") for motor in range(1, n_motors + 1))
