"""Orientation along a path: rotation about one axis between quaternions, as roll, pitch and yaw."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory import taylor
from flexros.trajectory.path import MAX_DERIVATIVES, AbstractPath, point, text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class Extended(AbstractPath):
    """A path of positions with further coordinates that change in proportion to its parameter.

    Args:
        position: Path of the positions [m].
        first: Further coordinates at the start [rad], shape (n_more,).
        last: Further coordinates at the end [rad], shape (n_more,).
    """

    position: AbstractPath
    first: FloatArray
    last: FloatArray

    @property
    def parameter_unit(self) -> str:  # type: ignore[override]
        """Unit of the position path's parameter."""
        return self.position.parameter_unit

    @property
    def extent(self) -> float:
        """Extent of the position path."""
        return self.position.extent

    @property
    def n_out(self) -> int:
        """Number of positions and further coordinates."""
        return self.position.n_out + self.first.size

    @property
    def pace(self) -> float:
        """Pace of the positions."""
        return self.position.pace

    @property
    def coordinate_pace(self) -> FloatArray:
        """Pace of every coordinate, shape (n_out,)."""
        return np.concatenate((self.position.coordinate_pace, np.abs(self.last - self.first) / self.extent))

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`."""
        s = np.asarray(s, dtype=float)
        more = np.zeros((order + 1, s.size, self.first.size))
        more[0] = self.first + (s / self.extent)[:, None] * (self.last - self.first)
        if order >= 1:
            more[1] = (self.last - self.first) / self.extent
        return np.concatenate((self.position.derivatives(s, order), more), axis=2)


@dataclass(frozen=True, eq=False)
class RollPitchYaw(AbstractPath):
    """A path [x y z, rotation vector] given as [x y z, roll, pitch, yaw] with exact derivatives.

    The orientation is exp(rotation vector) R0 with R0 the reference; roll, pitch and yaw are about the fixed axes of
    the base, R = Rz(yaw) Ry(pitch) Rx(roll), as in the outputs of a robot file, with roll and yaw in (-pi, pi].

    Args:
        turning: Path of six coordinates, the last three a rotation vector in the base frame [rad].
        reference: Quaternion of R0 [qx qy qz qw], shape (4,).
    """

    turning: AbstractPath
    reference: FloatArray

    @property
    def parameter_unit(self) -> str:  # type: ignore[override]
        """Unit of the inner path's parameter."""
        return self.turning.parameter_unit

    @property
    def extent(self) -> float:
        """Extent of the inner path."""
        return self.turning.extent

    @property
    def n_out(self) -> int:
        """6."""
        return 6

    @property
    def pace(self) -> float:
        """Pace of the positions (of the angle for a turn on the spot)."""
        return self.turning.pace

    @property
    def coordinate_pace(self) -> FloatArray:
        """Pace of the inner path's coordinates, shape (6,)."""
        return self.turning.coordinate_pace

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`.

        Raises:
            InputError: The pitch reaches +-90 degrees, where roll and yaw are not defined.
        """
        result = self.turning.derivatives(s, order)
        factorials = np.array([math.factorial(k) for k in range(order + 1)])[:, None, None]
        result[:, :, 3:] = factorials * self._angles(result[:, :, 3:] / factorials, np.asarray(s, dtype=float))
        return result

    def _angles(self, vector: FloatArray, s: FloatArray) -> FloatArray:
        """Convert the Taylor series of the rotation vector to those of roll, pitch, yaw; shape (order + 1, n, 3)."""
        # quaternion exp(vector / 2) R0 as series, then the elements of its rotation matrix that define the angles
        half = [0.5 * vector[:, :, i] for i in range(3)]
        square = taylor.multiply(half[0], half[0])
        for component in half[1:]:
            square = square + taylor.multiply(component, component)
        cosine, sine_over = taylor.compose(_COSINE, square), taylor.compose(_SINE_OVER, square)
        x, y, z, w = _product([taylor.multiply(h, sine_over) for h in half] + [cosine], self.reference)
        r20 = 2.0 * (taylor.multiply(x, z) - taylor.multiply(w, y))
        r21 = 2.0 * (taylor.multiply(y, z) + taylor.multiply(w, x))
        r22 = taylor.constant(1.0, w) - 2.0 * (taylor.multiply(x, x) + taylor.multiply(y, y))
        r10 = 2.0 * (taylor.multiply(x, y) + taylor.multiply(w, z))
        r00 = taylor.constant(1.0, w) - 2.0 * (taylor.multiply(y, y) + taylor.multiply(z, z))
        level = taylor.multiply(r00, r00) + taylor.multiply(r10, r10)
        if np.any(level[0] < 1e-12):
            parameter = float(s[int(np.argmin(level[0]))])
            raise InputError(
                f"the pitch of the tool is 90 degrees at path parameter {parameter:.6g} {self.parameter_unit}, where "
                "roll and yaw are not defined, allowed are orientations between -90 and 90 degrees of pitch; choose "
                "another orientation"
            )
        angles = (taylor.arctan2(r21, r22), taylor.arctan2(-r20, taylor.root(level)), taylor.arctan2(r10, r00))
        return np.stack(angles, axis=2)


def quaternion(values: object, name: str) -> FloatArray:
    """Check and normalise a quaternion.

    Args:
        values: [qx qy qz qw].
        name: What it is, for the message.

    Returns:
        Unit quaternion, shape (4,).

    Raises:
        InputError: Not four finite numbers, or a norm that differs from 1 by more than 1 %.
    """
    given = point(values, name)
    size = float(np.linalg.norm(given))
    if given.size != 4 or abs(size - 1.0) > 0.01:
        raise InputError(
            f"the {name} is {text(given)}, allowed is a quaternion [qx, qy, qz, qw] of size 1; correct its numbers"
        )
    return given / size


def rotation_vectors(reference: FloatArray, quaternions: Sequence[FloatArray]) -> FloatArray:
    """Return orientations as rotation vectors in the base frame relative to a reference, each near the previous one.

    Args:
        reference: Unit quaternion R0, shape (4,).
        quaternions: Unit quaternions R, each of shape (4,).

    Returns:
        Vectors with exp(vector) R0 = R [rad], without jumps of a full turn, shape (n, 3).
    """
    from scipy.spatial.transform import Rotation  # loads slowly

    back = Rotation.from_quat(reference).inv()
    result, before = [], np.zeros(3)
    for given in quaternions:
        vector = (Rotation.from_quat(given) * back).as_rotvec()
        angle = float(np.linalg.norm(vector))
        if angle > 0.0:
            axis = vector / angle
            vector = axis * (angle + 2.0 * np.pi * round((float(before @ axis) - angle) / (2.0 * np.pi)))
        result.append(vector)
        before = vector
    return np.array(result)


def quaternion_of(roll_pitch_yaw: FloatArray) -> FloatArray:
    """Return the quaternion [qx qy qz qw] of roll, pitch and yaw about the fixed axes [rad], shape (4,)."""
    from scipy.spatial.transform import Rotation  # loads slowly

    result: FloatArray = Rotation.from_euler("xyz", roll_pitch_yaw).as_quat()
    return result


_COSINE = [(-1.0) ** k / math.factorial(2 * k) for k in range(20)]
"""cos(sqrt(x)) in powers of x, to rounding for x up to pi^2 (rotation vectors up to a full turn)."""

_SINE_OVER = [(-1.0) ** k / math.factorial(2 * k + 1) for k in range(20)]
"""sin(sqrt(x)) / sqrt(x) in powers of x."""


def _product(first: list[FloatArray], second: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Multiply a quaternion of Taylor series [x, y, z, w] by a constant one."""
    x, y, z, w = first
    a, b, c, d = (float(value) for value in second)
    return (
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    )
