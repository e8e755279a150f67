"""Frames of the bodies of the true arm on /tf, where tf2_msgs is installed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry_msgs.msg import TransformStamped

from flexros.errors import InputError
from flexros.logs.stamps import NANOSECONDS
from flexros.logs.time_series import BASE_FRAME
from flexros.robot.body_placement import BodyPlacements
from flexros_nodes.shell.topic_interface import message_class, topic

if TYPE_CHECKING:
    from typing import Any

    from flexros.arrays import FloatArray
    from flexros.robot import Robot


class ArmFrames:
    """Fills one message of frames repeatedly.

    Args:
        robot: Robot with the bodies to show.
        prefix: Prefix of the body names, which distinguishes them from those of the rigid arm.

    Raises:
        InputError: tf2_msgs is not installed.
    """

    def __init__(self, robot: Robot, prefix: str) -> None:
        try:
            kind: Any = message_class(topic("tf").type)
        except ImportError as error:
            raise InputError(
                f"parameter frames of node plant is true, but /tf needs tf2_msgs, which cannot be imported ({error}); "
                "install it, or set frames to false"
            ) from error
        self._placements = BodyPlacements(robot)
        self._transforms = [TransformStamped() for _ in robot.spec.bodies]
        for number, transform in enumerate(self._transforms, 1):
            transform.header.frame_id = BASE_FRAME
            transform.child_frame_id = f"{prefix}body_{number}"
        self._message = kind(transforms=self._transforms)

    def fill(self, stamp: int, state: FloatArray) -> Any:
        """Return the message of a state.

        Args:
            stamp: Simulated time [ns].
            state: State that begins with the arm coordinates [rad or m], shape (n,).

        Returns:
            The message, the same object each time.
        """
        seconds, nanoseconds = divmod(stamp, NANOSECONDS)
        for stamped, pose in zip(self._transforms, self._placements.poses(state).tolist()):
            stamped.header.stamp.sec, stamped.header.stamp.nanosec = seconds, nanoseconds
            position, rotation = stamped.transform.translation, stamped.transform.rotation
            position.x, position.y, position.z, rotation.x, rotation.y, rotation.z, rotation.w = pose
        return self._message
