"""No feedforward torque: the feedback alone follows the position of the rigid arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.feedforward.base import AbstractFeedforward
from flexros.feedforward.rigid_arm import rigid_arm

if TYPE_CHECKING:
    from collections.abc import Iterator

    from flexros.feedforward.motion import Motion
    from flexros.feedforward.problem import FeedforwardProblem


class NoFeedforward(AbstractFeedforward):
    """Motor positions by the inverse kinematics of the rigid arm, torque zero."""

    name: ClassVar[str] = "none"

    def motions(self, problem: FeedforwardProblem, chunk: int) -> Iterator[Motion]:
        """Compute the whole motion and yield it in chunks; see `AbstractFeedforward.motions`."""
        arm = rigid_arm(problem.robot)
        gears = problem.gear_motion(2)
        yield from arm.inverse_dynamics(gears).without_torque().chunks(chunk)
