"""Reading torque commands, or refusing them; free of ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import FlexrosError, RunError
from flexros.logs.joint_state_message import JointStateView
from flexros.logs.stamps import NANOSECONDS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray

BRAKED = "the plant has braked to zero torque, the log is readable up to there"
"""What a broken-off run ends with, for the user to read."""


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


def silence_text(k: int, stamp: int, silence: float, resends: int) -> str:
    """Say that the controller has fallen silent.

    Args:
        k: Sample whose command is missing.
        stamp: Its stamp [ns].
        silence: Time without a command [s].
        resends: Times that the state was sent again.
    """
    return (
        f"no command for sample {k} (stamp {stamp / NANOSECONDS:.4f} s) within {silence:.3g} s although the state was "
        f"sent again {resends} times: the controller is gone or lacks its reference; {BRAKED}"
    )
