"""Settings that are given once for all motors, or one by one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import numpy as np
from pydantic import Field

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

NotNegative: TypeAlias = Annotated[float, Field(ge=0.0)]
Positive: TypeAlias = Annotated[float, Field(gt=0.0)]
NotNegativePerMotor: TypeAlias = NotNegative | tuple[NotNegative, ...]
PositivePerMotor: TypeAlias = Positive | tuple[Positive, ...]


def per_motor(key: str, value: float | tuple[float, ...], n_motors: int) -> FloatArray:
    """Spread a setting over the motors.

    Args:
        key: Key of the setting, for the error, e.g. "controller.kp".
        value: One number for all motors, or one for each.
        n_motors: Number of motors M.

    Returns:
        The setting of each motor, shape (M,).

    Raises:
        InputError: The number of values is neither one nor M.
    """
    values: FloatArray = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if values.size not in (1, n_motors):
        raise InputError(
            f"{key} has {values.size} values, allowed is one, or one for each of the {n_motors} motors; correct it"
        )
    return np.array(np.broadcast_to(values, (n_motors,)))
