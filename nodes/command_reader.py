"""Reading torque commands, or refusing them; free of ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import FlexrosError, RunError
from flexros.logs.joint_state_message import JointStateView
from flexros_nodes.breakdown import BRAKED

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray


class CommandReader:
    """Turns messages of joint_commands into torques.

    Args:
        names: Joint names in the order of the motors; a sender may use another order.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self._names = tuple(names)
        self._view = JointStateView(names)

    def read(self, message: bytes, k: int) -> FloatArray:
        """Read a command.

        Args:
            message: Serialised sensor_msgs/msg/JointState.
            k: Sample that it answers, for the error.

        Returns:
            Torques [Nm or N], shape (M,).

        Raises:
            RunError: Wrong size, unknown joint name, empty effort, or a value that is not finite.
        """
        try:
            sample = self._view.unpack(message)
        except FlexrosError as error:
            raise self._refusal(k, str(error)) from error
        effort = sample.effort
        if effort is None:
            raise self._refusal(k, "its effort is empty")
        if not math.isfinite(sum(effort)):
            raise self._refusal(k, f"its effort is {list(effort)}")
        return np.array(effort)

    def _refusal(self, k: int, problem: str) -> RunError:
        return RunError(
            f"the command on joint_commands for sample {k} is refused: {problem}; needed is one finite effort for "
            f"each of {', '.join(self._names)}; {BRAKED}"
        )
