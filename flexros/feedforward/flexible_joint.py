"""Feedforward of the flexible-joint robot by flatness; directions without motor are rigid."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.feedforward.base import AbstractFeedforward
from flexros.feedforward.equivalent_stiffness import gear_compliance
from flexros.feedforward.rigid_arm import RigidArm, rigid_arm

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.feedforward.motion import Motion
    from flexros.feedforward.problem import FeedforwardProblem


class FlexibleJointFeedforward(AbstractFeedforward):
    """Equations 5.4 and 5.5 of Moberg (2007): undamped linear gears, whose stiffness includes the other springs."""

    name: ClassVar[str] = "flexible_joint"

    def motions(self, problem: FeedforwardProblem, chunk: int) -> Iterator[Motion]:
        """Compute the whole motion and yield it in chunks; see `AbstractFeedforward.motions`."""
        robot = problem.robot
        arm = RigidArm(robot, problem.laws) if problem.laws else rigid_arm(robot)
        gears = problem.gear_motion(4)
        start = robot.equilibrium(problem.rigid_start)
        compliance = gear_compliance(robot, start, problem.output, problem.specification.stiffness)
        yield from arm.inverse_dynamics(gears, compliance).chunks(chunk)
