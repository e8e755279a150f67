"""Decoding and validation of torque commands."""

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
"""Number of recent commands kept for comparison, chosen: a second controller lags by a few samples."""


class CommandReader:
    """Decodes messages of joint_commands.

    Args:
        names: Joint names in the order of the motors; a sender may use another order.
        senders: Returns the number of publishers of joint_commands; called when two commands for one sample differ.
    """

    def __init__(self, names: Sequence[str], senders: Callable[[], int] = lambda: 1) -> None:
        self._names = tuple(names)
        self._view = JointStateView(names)
        self._senders = senders
        self._accepted: dict[int, bytes] = {}

    def stamp(self, message: bytes) -> int:
        """Read the stamp of a command [ns].

        Raises:
            MessageError: The bytes hold no stamp.
            RunError: The command differs from the accepted one of the same stamp, and two nodes publish.
        """
        stamp = stamp_of(message)
        accepted = self._accepted.get(stamp)
        if accepted is not None and accepted != message and (senders := self._senders()) > 1:
            raise RunError(
                f"two commands for stamp {stamp / NANOSECONDS:.4f} s on joint_commands differ, and {senders} nodes "
                f"publish it: a plant accepts one controller; stop the other; {BRAKED}"
            )
        return stamp

    def read(self, message: bytes, k: int) -> FloatArray:
        """Decode a command.

        Args:
            message: Serialised sensor_msgs/msg/JointState.
            k: Sample that it answers, for error messages.

        Returns:
            Torques [Nm or N], shape (M,).

        Raises:
            RunError: Wrong size, unknown joint name, empty effort, or a value that is not finite.
        """
        try:
            sample = self._view.unpack(message)
        except FlexrosError as error:
            raise self._rejection(k, str(error)) from error
        effort = sample.effort
        if effort is None:
            raise self._rejection(k, "its effort is empty")
        if not math.isfinite(sum(effort)):
            raise self._rejection(k, f"its effort is {list(effort)}")
        self._accepted[sample.stamp_ns] = message
        if len(self._accepted) > MEMORY:
            del self._accepted[next(iter(self._accepted))]
        return np.array(effort)

    def _rejection(self, k: int, problem: str) -> RunError:
        return RunError(
            f"the command on joint_commands for sample {k} is rejected: {problem}; required is one finite effort for "
            f"each of {', '.join(self._names)}; {BRAKED}"
        )
