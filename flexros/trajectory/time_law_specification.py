"""The key `time_law` of a trajectory: its settings, and the time law built from them."""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from flexros.config.settings import Settings
from flexros.errors import InputError
from flexros.trajectory.bang_bang_snap import bang_bang_snap
from flexros.trajectory.limits import LIMIT_NAMES, Limits, joint_limits
from flexros.trajectory.polynomial import ninth_degree, quintic
from flexros.trajectory.time_optimal.specification import TimeOptimalSpecification

if TYPE_CHECKING:
    from flexros.trajectory.path import AbstractPath
    from flexros.trajectory.time_law import TimeLaw


def _limit(given: Any) -> Any:
    """Check one number or a list of numbers above 0."""
    values = list(given) if isinstance(given, list | tuple) else [given]
    numbers = [v for v in values if isinstance(v, int | float) and not isinstance(v, bool)]
    if not values or len(numbers) < len(values) or not all(math.isfinite(v) and v > 0.0 for v in numbers):
        raise ValueError(
            f"the limit is {given}, allowed is a finite number above 0 (joint_moves: or a list of them); correct it"
        )
    return tuple(values) if isinstance(given, list | tuple) else given


Limit: TypeAlias = Annotated[float | tuple[float, ...], BeforeValidator(_limit)]


class AbstractTimeLawSpecification(Settings):
    """Base of the time laws; a new one defines `type`, its keys and `law`, and is added to `TimeLawSpecification`.

    A limit is one number; for joint moves also one number per joint.
    """

    speed: Limit | None = Field(
        default=None, description="largest speed along the path [m/s], or of joints [rad/s, m/s]"
    )
    acceleration: Limit | None = Field(
        default=None, description="largest acceleration along the path [m/s^2], or of joints [rad/s^2, m/s^2]"
    )
    jerk: Limit | None = Field(
        default=None, description="largest jerk along the path [m/s^3], or of joints [rad/s^3, m/s^3]"
    )
    snap: Limit | None = Field(
        default=None, description="largest derivative of the jerk along the path [m/s^4], or of joints [rad/s^4, m/s^4]"
    )
    limits_of: Literal["path", "angle"] = Field(
        default="path",
        description="limited quantity: the length along the path, or for circle and arc its angle [rad/s, ...]",
    )

    @abstractmethod
    def law(self, path: AbstractPath, joints: bool) -> TimeLaw:
        """Build the time law of one path.

        Args:
            path: The geometry.
            joints: Whether it is in joint space.

        Returns:
            The law from 0 to the path's extent.

        Raises:
            InputError: Limits or duration cannot be met.
        """

    def limits(self, path: AbstractPath, joints: bool) -> Limits:
        """Convert the limits to those of the path parameter.

        Args:
            path: The geometry.
            joints: Whether it is in joint space.

        Returns:
            Limits in the unit of the parameter.

        Raises:
            InputError: A list of limits for a tool path, of wrong length, or angle limits of a path without angle.
        """
        given = [getattr(self, name) for name in LIMIT_NAMES]
        values = [math.inf if value is None else value for value in given]
        if joints:
            speed, acceleration, jerk, snap = (np.atleast_1d(np.asarray(value, dtype=float)) for value in values)
            return joint_limits(path, (speed, acceleration, jerk, snap))
        for name, value in zip(LIMIT_NAMES, values, strict=True):
            if isinstance(value, tuple):
                raise InputError(
                    f"the {name} of the time law is the list {list(value)}, allowed is one number along a path of the "
                    "tool; a list belongs to joint_moves"
                )
        numbers = Limits(*values)
        if self.limits_of == "path":
            return numbers.along(path)
        if path.parameter_unit != "rad":
            raise InputError(
                "the time law has limits_of: angle on a path without an angle, allowed there is path; leave "
                "limits_of out"
            )
        return numbers


class PolynomialSpecification(AbstractTimeLawSpecification):
    """Polynomial of every move: by its duration, or the fastest within limits; with both the limits are checked."""

    type: Literal["quintic", "ninth_degree"]
    duration: float | None = Field(default=None, gt=0.0, description="duration of every move between two stops [s]")

    @model_validator(mode="after")
    def _determined(self) -> PolynomialSpecification:
        if self.duration is None and all(getattr(self, name) is None for name in LIMIT_NAMES):
            raise ValueError("the time law has neither duration nor limits, allowed is either; add duration in s")
        if self.type == "quintic" and self.snap is not None:
            raise ValueError(
                "the quintic has no bounded snap because its jerk jumps at both ends, allowed is none; leave it out or "
                "choose ninth_degree or bang_bang_snap"
            )
        return self

    def law(self, path: AbstractPath, joints: bool) -> TimeLaw:
        """See `AbstractTimeLawSpecification.law`."""
        make = quintic if self.type == "quintic" else ninth_degree
        return make(path.extent, self.duration, self.limits(path, joints))


class BangBangSnapSpecification(AbstractTimeLawSpecification):
    """Bang-bang in the fourth derivative: the fastest symmetric motion within the limits; snap is required."""

    type: Literal["bang_bang_snap"]

    @model_validator(mode="after")
    def _determined(self) -> BangBangSnapSpecification:
        if self.snap is None:
            raise ValueError(
                "the time law bang_bang_snap has no snap, allowed is a number above 0; add snap, the largest "
                "derivative of the jerk"
            )
        return self

    def law(self, path: AbstractPath, joints: bool) -> TimeLaw:
        """See `AbstractTimeLawSpecification.law`."""
        return bang_bang_snap(path.extent, self.limits(path, joints))


TimeLawSpecification: TypeAlias = Annotated[
    PolynomialSpecification | BangBangSnapSpecification | TimeOptimalSpecification, Field(discriminator="type")
]
