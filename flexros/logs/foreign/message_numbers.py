"""All numbers of a ROS message by name, with entries of lists by joint or interface name."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.input_limits import MOST_ENTRIES, MOST_SIGNALS

if TYPE_CHECKING:
    from collections.abc import Sequence

LABELS = ("name", "joint_names", "interface_names")
"""Fields that name the entries of lists at and below their level, in sensor_msgs, trajectory_msgs and control_msgs."""

_HEADER = "header"


def message_numbers(message: Any) -> dict[str, float]:
    """Return all numbers of a message.

    The field of a field is named a.b. Entry k of a list is named a[elbow] if the message names the entries of its lists
    and name k is elbow, else a[k]. A position is position[elbow] in a JointState, feedback.positions[elbow] in a
    JointTrajectoryControllerState and interface_values[elbow].values[position] in a DynamicJointState.

    Args:
        message: A decoded message: a dataclass.

    Returns:
        Numbers by name, without the header, at most `MOST_SIGNALS`.
    """
    numbers: dict[str, float] = {}
    _collect_message(message, "", (), numbers)
    return numbers


def _collect_message(message: Any, prefix: str, labels: Sequence[str], numbers: dict[str, float]) -> None:
    """Collect the numbers of a message whose lists have these labels, unless it has labels of its own."""
    values = {field.name: getattr(message, field.name) for field in fields(message)}
    for name in LABELS:
        own = values.get(name)
        if isinstance(own, list) and own and all(isinstance(label, str) for label in own):
            labels = own
            break
    for name, value in values.items():
        if name == _HEADER and not prefix:
            continue
        _collect(f"{prefix}{name}", value, labels, numbers)


def _collect(name: str, value: Any, labels: Sequence[str], numbers: dict[str, float]) -> None:
    if len(numbers) >= MOST_SIGNALS:
        return
    if isinstance(value, (bool, int, float)):
        numbers[name] = float(value)
    elif is_dataclass(value):
        _collect_message(value, f"{name}.", labels, numbers)
    elif isinstance(value, (list, np.ndarray)) and len(value) <= MOST_ENTRIES:
        keys = labels if len(labels) == len(value) == len(set(labels)) else range(len(value))
        for key, entry in zip(keys, value.tolist() if isinstance(value, np.ndarray) else value, strict=True):
            _collect(f"{name}[{key}]", entry, (), numbers)
