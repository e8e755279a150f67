"""Error of the weight of a body."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

import casadi as ca
from pydantic import Field

from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.ranges import Range
from flexros.robot.symbolic.body_frame import body_frame, long_axis, moved_bodies

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.effects.kinds.arm_law import ArmState
    from flexros.effects.kinds.base import Stage
    from flexros.robot import Robot
    from flexros.robot.symbolic.kinematics import Value


class GravityError(AbstractArmLaw):
    """Unmodelled weight of a body: a share of its weight, or a mass moment, without change of inertia.

    With gravity vector g, mass m and centre of mass c(q) of the body, relative error r, unmodelled mass moment s and
    direction e(q) of the body (along its length, or its x axis where it has none), the forces on the arm coordinates
    are the gradient of the work of the unmodelled weight,

        d/dq [ r m g . c(q) + s g . e(q) ].

    Reference: Virtual work; Moberg 2007, equation 3.18: the term g(q_a).
    """

    name: ClassVar[str] = "gravity_error"
    stage: ClassVar[Stage] = "load"
    plain: ClassVar[bool] = True
    size: ClassVar[str] = "relative"
    further_sizes: ClassVar[tuple[str, ...]] = ("moment",)
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType(
        {"relative": Range("relative", 0.003, 0.9, 4, signed=True, widest=9.0)}
    )
    signatures: ClassVar[tuple[str, ...]] = ("torque_over_position", "tool_error")
    fingerprint: ClassVar[str] = (
        "a disturbance torque that depends on the pose alone, by sine and cosine, independent of direction and speed; "
        "not visible in frequency responses"
    )

    relative: float = Field(0.0, ge=-1.0, lt=10.0, description="unmodelled share of the body's weight [1]")
    moment: float = Field(0.0, description="unmodelled mass moment along the body [kg m]")

    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the bodies that move, on robots under gravity."""
        if not any(robot.spec.gravity.value):
            return ()
        return tuple(f"body_{body + 1}" for body in moved_bodies(robot))

    def force(self, arm: ArmState, values: Mapping[str, Value]) -> ca.SX:
        """Return the gradient of the work of the unmodelled weight."""
        q = ca.SX.sym("q", arm.robot.n_arm)
        body = int(arm.location.removeprefix("body_")) - 1
        frame = body_frame(arm.robot, body, q, arm.parameter)
        gravity = ca.vertcat(*[ca.SX(arm.parameter(f"gravity.{axis}")) for axis in "xyz"])
        mass = arm.parameter(f"{arm.location}.mass")
        along = frame.rotation @ ca.SX(ca.DM(long_axis(arm.robot, body)))
        work = values["relative"] * mass * ca.dot(gravity, frame.center) + values["moment"] * ca.dot(gravity, along)
        return ca.substitute(ca.densify(ca.gradient(work, q)), q, arm.position)
