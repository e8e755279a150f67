"""Feedforward of the rigid robot: computed torque of arm and motors, all springs rigid."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.feedforward.base import AbstractFeedforward
from flexros.feedforward.rigid_arm import RigidArm, rigid_arm

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.feedforward.motion import Motion
    from flexros.feedforward.problem import FeedforwardProblem


class RigidFeedforward(AbstractFeedforward):
    """Inverse dynamics u = (M + M_m) theta'' + n(theta, theta') of the rigid robot (Moberg 2007, section 5.2.1)."""

    name: ClassVar[str] = "rigid"

    def motions(self, problem: FeedforwardProblem, chunk: int) -> Iterator[Motion]:
        """Compute the whole motion and yield it in chunks; see `AbstractFeedforward.motions`."""
        arm = RigidArm(problem.robot, problem.laws) if problem.laws else rigid_arm(problem.robot)
        gears = problem.gear_motion(2)
        yield from arm.inverse_dynamics(gears).chunks(chunk)
