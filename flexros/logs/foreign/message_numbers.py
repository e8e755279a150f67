"""All numbers of a ROS message by name, with joints and interfaces by their names instead of places."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.input_limits import MOST_ENTRIES, MOST_SIGNALS

if TYPE_CHECKING:
    from collections.abc import Sequence

LABELS = ("name", "joint_names", "interface_names")
"""Fields that name the entries of the lists beside and below them, in sensor_msgs, trajectory_msgs and control_msgs."""

_HEADER = "header"


def message_numbers(message: Any) -> dict[str, float]:
    """Take a message apart.

    The field of a field is named a.b. Entry k of a list is a[elbow] where the message names the entries of its lists,
    and that is name k, else a[k]. So a position is position[elbow] in a JointState, feedback.positions[elbow] in a
    JointTrajectoryControllerState and interface_values[elbow].values[position] in a DynamicJointState.

    Args:
        message: A decoded message: a dataclass.

    Returns:
        Numbers by name, without the header and without what is beyond `MOST_SIGNALS`.
    """
    found: dict[str, float] = {}
    _take(message, "", (), found)
    return found


def _take(message: Any, prefix: str, labels: Sequence[str], found: dict[str, float]) -> None:
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
        _collect(f"{prefix}{name}", value, labels, found)


def _collect(name: str, value: Any, labels: Sequence[str], found: dict[str, float]) -> None:
    if len(found) >= MOST_SIGNALS:
        return
    if isinstance(value, (bool, int, float)):
        found[name] = float(value)
    elif is_dataclass(value):
        _take(value, f"{name}.", labels, found)
    elif isinstance(value, (list, np.ndarray)) and len(value) <= MOST_ENTRIES:
        keys = labels if len(labels) == len(value) == len(set(labels)) else range(len(value))
        for key, entry in zip(keys, value.tolist() if isinstance(value, np.ndarray) else value, strict=True):
            _collect(f"{name}[{key}]", entry, (), found)
