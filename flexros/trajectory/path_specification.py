"""The key `path` of a trajectory: its settings and their geometry."""

from __future__ import annotations

from abc import abstractmethod
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias

import numpy as np
from pydantic import Field, model_validator

from flexros.config.settings import Settings
from flexros.errors import InputError
from flexros.trajectory.arc import PLANES, Arc, circle
from flexros.trajectory.line import JointMove, Line
from flexros.trajectory.path import AbstractPath, point
from flexros.trajectory.sequence import Sequence
from flexros.trajectory.tool_points import Point, Quaternion, target_point, turning_lines, with_angles

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class AbstractPathSpecification(Settings):
    """Base of the path types; a new one defines `type`, its keys and `paths`, and is added to `PathSpecification`."""

    @abstractmethod
    def paths(self, start: FloatArray, n_position: int) -> tuple[AbstractPath, ...]:
        """Build the geometry.

        Args:
            start: Tool coordinates or joint positions at rest, shape (n_out,).
            n_position: Number of leading tool coordinates that are positions.

        Returns:
            Successive paths, with a stop between them.

        Raises:
            InputError: The geometry is impossible.
        """


class LineSpecification(AbstractPathSpecification):
    """Straight line of the tool from the start."""

    type: Literal["line"]
    end: Point | None = Field(
        default=None, description="last point [m]; all coordinates of the output, or the positions alone if angles stay"
    )
    end_from_start: Point | None = Field(default=None, description="the same, as a displacement from the start [m]")
    end_orientation: Quaternion | None = Field(
        default=None, description="orientation at the end [qx, qy, qz, qw]; kept when left out"
    )

    @model_validator(mode="after")
    def _one_end(self) -> LineSpecification:
        if self.end is not None and self.end_from_start is not None:
            raise ValueError("both end and end_from_start are given, allowed is one of them; leave one out")
        if self.end is None and self.end_from_start is None and self.end_orientation is None:
            raise ValueError("no end is given, allowed are end, end_from_start, end_orientation; add one")
        return self

    def paths(self, start: FloatArray, n_position: int) -> tuple[AbstractPath, ...]:
        """See `AbstractPathSpecification.paths`."""
        given = self.end if self.end is not None else self.end_from_start or (0.0,) * start.size
        end = target_point(start, given, n_position, relative=self.end is None, name="end of the line")
        if self.end_orientation is None:
            return (Line(start, end, n_position),)
        return turning_lines([start, end], [self.end_orientation], n_position, 0.0)


class CircleSpecification(AbstractPathSpecification):
    """Circle that begins at the start."""

    type: Literal["circle"]
    radius: float | None = Field(default=None, gt=0.0, description="radius [m]; from centre_from_start when left out")
    centre_from_start: Point | None = Field(
        default=None,
        description="centre as a displacement from the start [m]; from radius and start_angle when left out",
    )
    start_angle: float | None = Field(
        default=None,
        description="angle of the start on the circle [rad], from the plane's first towards its second coordinate; "
        "from centre_from_start when left out, else 0 (centre at start - (radius, 0))",
    )
    turns: float = Field(
        default=1.0, description="number of turns [1], positive from the plane's first towards its second coordinate"
    )
    plane: Literal["xy", "yz", "xz"] = Field(
        default="xy", description="plane of the circle for outputs with three positions; two positions are the plane"
    )
    end_orientation: Quaternion | None = Field(
        default=None, description="orientation at the end [qx, qy, qz, qw]; kept when left out"
    )

    @model_validator(mode="after")
    def _determined(self) -> CircleSpecification:
        if self.radius is None and self.centre_from_start is None:
            raise ValueError("the circle has neither radius nor centre_from_start, allowed is one or both; add radius")
        return self

    def paths(self, start: FloatArray, n_position: int) -> tuple[AbstractPath, ...]:
        """See `AbstractPathSpecification.paths`."""
        radius, angle = self._radius_and_angle(n_position)
        round_path = circle(start[:n_position], radius, angle, self.turns, self.plane)
        return (with_angles(round_path, start, n_position, self.end_orientation),)

    def _radius_and_angle(self, n_position: int) -> tuple[float, float]:
        if self.centre_from_start is None:
            return self.radius or 0.0, self.start_angle or 0.0
        offset = point(self.centre_from_start, "centre_from_start of the circle", n_position)
        cosine, sine = PLANES[self.plane] if n_position == 3 else (0, 1)
        if n_position < 2 or np.count_nonzero(np.delete(offset, [cosine, sine])):
            raise InputError(
                f"the circle has centre_from_start {list(self.centre_from_start)}, allowed is a displacement within "
                f"the plane {self.plane}; correct centre_from_start or plane"
            )
        radius = float(np.hypot(offset[cosine], offset[sine]))
        if self.radius is not None and abs(radius - self.radius) > 1e-6 * self.radius:
            raise InputError(
                f"the circle has radius {self.radius:g} m but its centre_from_start is {radius:g} m away, allowed are "
                "equal numbers; leave one of the two keys out"
            )
        angle = float(np.arctan2(-offset[sine], -offset[cosine]))
        if self.start_angle is None:
            return self.radius or radius, angle
        if abs(np.angle(np.exp(1j * (self.start_angle - angle)))) > 1e-6:
            raise InputError(
                f"the circle has start_angle {self.start_angle:g} rad but its centre_from_start means {angle:g} rad, "
                "allowed are equal angles; leave one of the two keys out"
            )
        return self.radius or radius, self.start_angle


class ArcSpecification(AbstractPathSpecification):
    """Arc of a circle: through two further points, or about a centre by an angle."""

    type: Literal["arc"]
    via: Point | None = Field(default=None, description="point on the way [m]")
    end: Point | None = Field(default=None, description="last point [m]")
    via_from_start: Point | None = Field(default=None, description="point on the way, as a displacement [m]")
    end_from_start: Point | None = Field(default=None, description="last point, as a displacement [m]")
    centre_from_start: Point | None = Field(default=None, description="centre, as a displacement [m]")
    angle: float | None = Field(default=None, description="angle about the centre [rad], right-handed about the normal")
    normal: tuple[float, float, float] | None = Field(
        default=None, description="axis of rotation [1], for outputs with three positions"
    )
    end_orientation: Quaternion | None = Field(
        default=None, description="orientation at the end [qx, qy, qz, qw]; kept when left out"
    )

    @model_validator(mode="after")
    def _one_form(self) -> ArcSpecification:
        given = {key for key in ("via", "end", "via_from_start", "end_from_start", "centre_from_start", "angle")
                 if getattr(self, key) is not None}  # fmt: skip
        forms = ({"via", "end"}, {"via_from_start", "end_from_start"}, {"centre_from_start", "angle"})
        if given not in forms:
            raise ValueError(
                f"the arc has the keys {', '.join(sorted(given)) or 'none'}, allowed are via and end, via_from_start "
                "and end_from_start, or centre_from_start and angle; give one of these pairs"
            )
        return self

    def paths(self, start: FloatArray, n_position: int) -> tuple[AbstractPath, ...]:
        """See `AbstractPathSpecification.paths`."""
        first = start[:n_position]
        if self.centre_from_start is not None and self.angle is not None:
            centre = first + point(self.centre_from_start, "centre_from_start of the arc", n_position)
            normal = None if self.normal is None else np.array(self.normal)
            arc = Arc.about(centre, first, self.angle, normal)
        else:
            relative = self.via is None
            via = point(self.via or self.via_from_start, "via point of the arc", n_position)
            end = point(self.end or self.end_from_start, "end of the arc", n_position)
            arc = Arc.through(first, first + via if relative else via, first + end if relative else end)
        return (with_angles(arc, start, n_position, self.end_orientation),)


class AbstractPointsSpecification(AbstractPathSpecification):
    """Base of the paths through several points."""

    points: tuple[Point, ...] | None = Field(default=None, min_length=1, description="points after the start")
    points_from_start: tuple[Point, ...] | None = Field(
        default=None, min_length=1, description="the same, each as a displacement from the start"
    )
    zone: float | tuple[float, ...] = Field(
        default=0.0,
        description="radius of the corner zones, one for all or one per corner, in m (joint moves: norm of the joint "
        "vector in rad): within it the corner is rounded and passed without a stop; 0: stop at every point",
    )

    @model_validator(mode="after")
    def _one_list(self) -> AbstractPointsSpecification:
        if (self.points is None) == (self.points_from_start is None):
            raise ValueError("give either points or points_from_start; correct the path")
        return self

    @property
    def stops(self) -> bool:
        """Whether the motion stops at every point."""
        return bool(np.all(np.asarray(self.zone) == 0.0))

    @property
    def given(self) -> tuple[Point, ...]:
        """The points as written."""
        return self.points or self.points_from_start or ()


class LinesSpecification(AbstractPointsSpecification):
    """Straight lines of the tool through points, with rounded corners or stops."""

    type: Literal["lines"]
    orientations: tuple[Quaternion, ...] | None = Field(
        default=None, description="orientation at every point [qx, qy, qz, qw]; kept when left out"
    )

    def paths(self, start: FloatArray, n_position: int) -> tuple[AbstractPath, ...]:
        """See `AbstractPathSpecification.paths`."""
        nodes = [start]
        for i, given in enumerate(self.given, start=1):
            nodes.append(
                target_point(start, given, n_position, relative=self.points is None, name=f"point {i} of the lines")
            )
        if self.orientations is not None:
            return turning_lines(nodes, list(self.orientations), n_position, self.zone)
        if self.stops:
            return tuple(Line(a, b, n_position) for a, b in pairwise(nodes))
        return (Sequence(nodes, np.asarray(self.zone), n_position=n_position),)


class JointMovesSpecification(AbstractPointsSpecification):
    """Straight moves in joint space through joint positions, with rounded corners or stops."""

    type: Literal["joint_moves"]

    def paths(self, start: FloatArray, n_position: int) -> tuple[AbstractPath, ...]:
        """See `AbstractPathSpecification.paths`."""
        base = start if self.points is None else np.zeros(start.size)
        nodes = [start]
        nodes += [
            base + point(q, f"point {i} of the joint moves", start.size) for i, q in enumerate(self.given, start=1)
        ]
        if self.stops:
            return tuple(JointMove(a, b) for a, b in pairwise(nodes))
        return (Sequence(nodes, np.asarray(self.zone), joints=True),)


PathSpecification: TypeAlias = Annotated[
    LineSpecification | CircleSpecification | ArcSpecification | LinesSpecification | JointMovesSpecification,
    Field(discriminator="type"),
]
