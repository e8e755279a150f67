"""Reading torque commands, or refusing them; free of ROS."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import FlexrosError, RunError
from flexros.logs.messages.joint_state import JointStateView
from flexros.logs.stamps import NANOSECONDS, stamp_of
from flexros_nodes.protocol.loop.abort_messages import BRAKED

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray


MEMORY = 16
"""Samples for which a second command is compared with the first, chosen: a second controller lags by a few."""


class CommandReader:
    """Turns messages of joint_commands into torques.

    Args:
        names: Joint names in the order of the motors; a sender may use another order.
        senders: Counts who publishes joint_commands; asked when two commands for one sample differ.
    """

    def __init__(self, names: Sequence[str], senders: Callable[[], int] = lambda: 1) -> None:
        self._names = tuple(names)
        self._view = JointStateView(names)
        self._senders = senders
        self._taken: dict[int, bytes] = {}

    def stamp(self, message: bytes) -> int:
        """Read the stamp of a command [ns].

        Raises:
            MessageError: The bytes hold no stamp.
            RunError: The command contradicts the one that was taken for the same stamp, and two nodes send.
        """
        stamp = stamp_of(message)
        taken = self._taken.get(stamp)
        if taken is not None and taken != message and (senders := self._senders()) > 1:
            raise RunError(
                f"two commands for stamp {stamp / NANOSECONDS:.4f} s on joint_commands differ, and {senders} nodes "
                f"publish it: a plant obeys one controller; stop the other; {BRAKED}"
            )
        return stamp

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
        self._taken[sample.stamp_ns] = message
        if len(self._taken) > MEMORY:
            del self._taken[next(iter(self._taken))]
        return np.array(effort)

    def _refusal(self, k: int, problem: str) -> RunError:
        return RunError(
            f"the command on joint_commands for sample {k} is refused: {problem}; needed is one finite effort for "
            f"each of {', '.join(self._names)}; {BRAKED}"
        )
