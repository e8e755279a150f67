"""Serialised JointState messages as columns, many at once, in the order of the motors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.logs.cdr_cursor import MessageError
from flexros.logs.messages.joint_state import FIELDS, read_joint_state_layout
from flexros.record.joint_columns import motor_columns

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray, IntArray
    from flexros.logs.messages.joint_state import JointStateLayout
    from flexros.robot import Robot


class JointMessages:
    """Decodes messages of one topic; the layout of the last sender is kept.

    Args:
        robot: The robot whose motors are wanted.
        topic: Name of the topic.
        field: "position" or "effort".
        states: Reader of the joint states, whose order of foreign names counts for this topic too; None for none.

    Attributes:
        ordered: Joint names of the topic in the order of the motors; empty before the first message.
        unusable: Number of messages that could not be used.
        problem: Reason for the last of them; empty where all could be used.
    """

    def __init__(self, robot: Robot, topic: str, field: str, states: JointMessages | None = None) -> None:
        self._robot, self._topic, self._span = robot, topic, FIELDS.index(field)
        self._field = field
        self._layout: JointStateLayout | None = None
        self._columns: list[int] = []
        self._states = states
        self._known: tuple[str, ...] = ()
        self.ordered: tuple[str, ...] = ()
        self.unusable = 0
        self.problem = ""

    def take(self, messages: Sequence[bytes]) -> tuple[IntArray, FloatArray]:
        """Decode messages.

        Args:
            messages: Serialised messages in the order of arrival.

        Returns:
            Stamps [ns], shape (n,), and values of the field in the order of the motors, shape (n, M).
        """
        if self._states is not None and self._states.ordered != self._known:
            self._layout, self._known = None, self._states.ordered
        decoded_messages = self._at_once(messages) or [
            decoded for message in messages for decoded in self._one(message)
        ]
        if not decoded_messages:
            return np.zeros(0, dtype=np.int64), np.zeros((0, self._robot.n_motors))
        return np.concatenate([stamp for stamp, _ in decoded_messages]), np.concatenate(
            [values for _, values in decoded_messages]
        )

    def _at_once(self, messages: Sequence[bytes]) -> list[tuple[IntArray, FloatArray]]:
        """Decode messages of the known layout; empty where one has another."""
        if self._layout is None or not messages or len(set(map(len, messages))) > 1:
            return []
        table = np.frombuffer(b"".join(messages), np.uint8).reshape(len(messages), -1)
        layout = self._layout.message
        if not layout.matches(table).all():
            return []
        return [(layout.stamps(table), layout.numbers(table, self._span)[:, self._columns])]

    def _one(self, message: bytes) -> list[tuple[IntArray, FloatArray]]:
        """Decode a message of any layout; empty where it cannot be used."""
        if found := self._at_once([message]):
            return found
        try:
            layout = read_joint_state_layout(message)
            if not layout.message.spans[self._span].size:
                raise InputError(f"{self._topic} has no {self._field}")
            owner = f"robot {self._robot.name}"
            self._columns = motor_columns(
                layout.names, self._robot.joint_names, self._topic, [], owner=owner, states=self._known
            )
        except (MessageError, InputError) as error:
            self.unusable += 1
            self.problem = str(error)
            return []
        self._layout, self.ordered = layout, tuple(layout.names[column] for column in self._columns)
        return self._at_once([message])
