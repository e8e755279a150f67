"""Settings given once for all motors, or per motor."""

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
    """Return the setting of each motor, shape (M,).

    Args:
        key: Key of the setting, for the error message, e.g. "controller.kp".
        value: One value for all motors, or one per motor.
        n_motors: Number of motors M.

    Raises:
        InputError: The number of values is neither one nor M.
    """
    values: FloatArray = np.atleast_1d(np.asarray(value, dtype=np.float64))
    if values.size not in (1, n_motors):
        raise InputError(
            f"{key} has {values.size} values, allowed is one, or one for each of the {n_motors} motors; correct it"
        )
    return np.array(np.broadcast_to(values, (n_motors,)))
