"""Messages on joint_states that are not of this robot: any node, such as a gripper, may publish its joints there."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.logs.cdr_cursor import CdrCursor

if TYPE_CHECKING:
    from collections.abc import Iterable

_STAMP = 8
_AFTER_STAMP = 12  # encapsulation and stamp


class OwnJoints:
    """Decides whether a sensor_msgs/JointState is of a robot, by its names.

    Args:
        names: Names of the robot's joints.

    Attributes:
        foreign: Messages so far that hold joints, but none of the robot.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._names = frozenset(names)
        self._last = (_AFTER_STAMP, b"none yet")
        self.foreign = 0

    def are_in(self, message: bytes) -> bool:
        """Return whether a message holds a joint of the robot, or none at all, which is for the reader to reject.

        Raises:
            MessageError: The bytes are not a JointState.
        """
        end, header = self._last
        if message[_AFTER_STAMP:end] == header:  # as the own message before
            return True
        cursor = CdrCursor(message)
        cursor.skip(_STAMP, "header.stamp")
        cursor.string("header.frame_id")
        names = cursor.strings("name")
        if names and self._names.isdisjoint(names):
            self.foreign += 1
            return False
        self._last = cursor.position, bytes(message[_AFTER_STAMP : cursor.position])
        return True
