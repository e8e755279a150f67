"""Circles and arcs of circles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.trajectory.path import MAX_DERIVATIVES, AbstractPath, point, text
from flexros.trajectory.time_law import positive

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

PLANES = {"xy": (0, 1), "yz": (1, 2), "xz": (0, 2)}
"""Planes of a circle in space: the coordinates of the cosine and of the sine."""


@dataclass(frozen=True, eq=False)
class Arc(AbstractPath):
    """Arc of a circle, P(s) = centre + radius (cos(a0 + d s) u + sin(a0 + d s) v), d = +1 or -1.

    The parameter is the angle travelled [rad]. Use `circle`, `Arc.about` or `Arc.through` to create it.

    Args:
        centre: Centre [m], shape (2,) or (3,).
        radius: Radius [m].
        cosine_axis: Unit vector u, shape (n_out,).
        sine_axis: Unit vector v at right angles to u, shape (n_out,).
        start_angle: Angle a0 of the start [rad], from u towards v.
        angle: Angle travelled [rad]; positive from u towards v.

    Raises:
        InputError: Radius or angle is zero, negative (radius) or not finite.
    """

    centre: FloatArray
    radius: float
    cosine_axis: FloatArray
    sine_axis: FloatArray
    start_angle: float
    angle: float
    parameter_unit = "rad"

    def __post_init__(self) -> None:
        positive(self.radius, "radius", "m")
        if not (np.isfinite(self.angle) and self.angle != 0.0):
            raise InputError(
                f"the angle of the arc is {self.angle:g} rad, allowed is a finite angle other than 0; "
                "correct the angle or the number of turns"
            )
        if not np.isfinite(self.start_angle):
            raise InputError(f"the start angle is {self.start_angle:g} rad, allowed is a finite angle; correct it")

    @classmethod
    def about(cls, centre: FloatArray, start: FloatArray, angle: float, normal: FloatArray | None = None) -> Arc:
        """Return the arc that starts at a point and turns about a centre.

        Args:
            centre: Centre [m], shape (2,) or (3,).
            start: First point [m], shape as the centre.
            angle: Angle travelled [rad]; positive is right-handed about the normal, in the plane from the first
                towards the second coordinate.
            normal: Axis of rotation, needed in space, shape (3,); must be at right angles to start - centre.

        Returns:
            The arc.

        Raises:
            InputError: Start equals centre, or the normal is missing, zero or not at right angles to the radius.
        """
        middle = point(centre, "centre of the arc")
        spoke = point(start, "start of the arc", middle.size) - middle
        radius = float(np.linalg.norm(spoke))
        if radius == 0.0:
            raise InputError(
                f"the arc starts at its centre {text(middle)} so its radius is 0 m, allowed is a radius above 0; "
                "move the centre"
            )
        u = spoke / radius
        return cls(middle, radius, u, _sine_axis(u, normal), 0.0, float(angle))

    @classmethod
    def through(cls, start: FloatArray, via: FloatArray, end: FloatArray) -> Arc:
        """Return the arc through three points.

        Args:
            start: First point [m], shape (2,) or (3,).
            via: Intermediate point [m].
            end: Last point [m].

        Returns:
            The arc, with an angle below a full turn.

        Raises:
            InputError: The points are collinear (or two are the same), so that no circle passes through them.
        """
        first = point(start, "start of the arc")
        if first.size not in (2, 3):
            raise InputError(f"the arc has {first.size} coordinates, allowed are 2 or 3; use a line or joint moves")
        a = point(via, "via point of the arc", first.size) - first
        b = point(end, "end of the arc", first.size) - first
        aa, bb, ab = a @ a, b @ b, a @ b
        det = aa * bb - ab * ab
        if det <= 1e-16 * max(float(aa), float(bb), 1e-300) ** 2:
            raise InputError(
                f"the three points {text(first)}, {text(first + a)} and {text(first + b)} of the arc are "
                "collinear, allowed are points of a circle; move the via point or use a line"
            )
        spoke_to_centre = (bb * (aa - ab) * a + aa * (bb - ab) * b) / (2.0 * det)
        radius = float(np.linalg.norm(spoke_to_centre))
        u = -spoke_to_centre / radius
        towards_via = a - (a @ u) * u
        v = towards_via / np.linalg.norm(towards_via)

        def angle_of(difference: FloatArray) -> float:
            spoke = difference - spoke_to_centre
            return float(np.arctan2(spoke @ v, spoke @ u) % (2.0 * np.pi))

        to_via, to_end = angle_of(a), angle_of(b)
        angle = to_end if to_end > to_via else to_end - 2.0 * np.pi
        return cls(first + spoke_to_centre, radius, u, v, 0.0, angle)

    @property
    def extent(self) -> float:
        """Angle travelled [rad]."""
        return abs(self.angle)

    @property
    def n_out(self) -> int:
        """Number of coordinates, 2 or 3."""
        return self.centre.size

    @property
    def pace(self) -> float:
        """Radius [m]: length per radian."""
        return self.radius

    @property
    def coordinate_pace(self) -> FloatArray:
        """Bound of |dP_i/ds| (reached on a full circle) [m/rad], shape (n_out,)."""
        return self.radius * np.hypot(self.cosine_axis, self.sine_axis)

    def derivatives(self, s: FloatArray, order: int = MAX_DERIVATIVES) -> FloatArray:
        """See `AbstractPath.derivatives`."""
        sign = np.sign(self.angle)
        phase = self.start_angle + sign * np.asarray(s, dtype=float)
        result = np.empty((order + 1, phase.size, self.n_out))
        cos, sin = np.cos(phase), np.sin(phase)
        for k in range(order + 1):
            spoke = cos[:, None] * self.cosine_axis + sin[:, None] * self.sine_axis
            result[k] = self.radius * sign**k * spoke + (self.centre if k == 0 else 0.0)
            cos, sin = -sin, cos
        return result


def circle(start: FloatArray, radius: float, start_angle: float = 0.0, turns: float = 1.0, plane: str = "xy") -> Arc:
    """Return the circle of a given radius on which the first point has a given angle.

    Args:
        start: First point [m], shape (2,) or (3,).
        radius: Radius [m].
        start_angle: Angle of the start on the circle [rad], from the first towards the second coordinate of the plane;
            0 puts the centre at start - (radius, 0).
        turns: Number of turns, positive from the first towards the second coordinate, fractions allowed.
        plane: "xy", "yz" or "xz", for circles in space; ignored for two coordinates.

    Returns:
        The circle, beginning exactly at the start.

    Raises:
        InputError: Zero or negative radius, zero turns, unknown plane, or a start that is not in a plane or in space.
    """
    first = point(start, "start of the circle")
    if first.size not in (2, 3):
        raise InputError(f"the circle has {first.size} coordinates, allowed are 2 or 3; use a line or joint moves")
    if plane not in PLANES:
        raise InputError(f"the plane of the circle is '{plane}', allowed are {', '.join(PLANES)}; choose one of them")
    u, v = np.zeros(first.size), np.zeros(first.size)
    cosine, sine = PLANES[plane] if first.size == 3 else (0, 1)
    u[cosine] = v[sine] = 1.0
    spoke = positive(radius, "radius", "m") * (np.cos(start_angle) * u + np.sin(start_angle) * v)
    return Arc(first - spoke, float(radius), u, v, float(start_angle), 2.0 * np.pi * float(turns))


def _sine_axis(u: FloatArray, normal: FloatArray | None) -> FloatArray:
    """Return the unit vector in the direction of increasing angle: perpendicular to u and, in space, to the normal."""
    if u.size == 2:
        return np.array([-u[1], u[0]])
    if u.size != 3:
        raise InputError(f"the arc has {u.size} coordinates, allowed are 2 or 3; use a line or joint moves")
    if normal is None:
        raise InputError(
            "the arc in space has no normal, allowed is a vector of 3 numbers; give the axis it turns about"
        )
    axis = point(normal, "normal of the arc", 3)
    size = float(np.linalg.norm(axis))
    if size == 0.0 or abs(axis @ u) > 1e-6 * size:
        raise InputError(
            f"the normal of the arc is {text(axis)}, allowed is a vector at right angles to the radius direction "
            f"{text(u)}; correct normal or centre"
        )
    v = np.cross(axis, u)
    return v / float(np.linalg.norm(v))
