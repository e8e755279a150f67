"""What a column of a foreign log can be, and which field of which topic it becomes."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping


@dataclass(frozen=True)
class Quantity:
    """Where a quantity goes.

    Attributes:
        topic: Topic of the contract.
        field: Field of its messages: "position", "velocity" or "effort".
        kind: Kind of its unit: "position", "velocity" or "torque".
    """

    topic: str
    field: str
    kind: str


QUANTITIES: Mapping[str, Quantity] = MappingProxyType(
    {
        "position": Quantity("joint_states", "position", "position"),
        "velocity": Quantity("joint_states", "velocity", "velocity"),
        "measured_torque": Quantity("joint_states", "effort", "torque"),
        "torque_command": Quantity("joint_commands", "effort", "torque"),
        "reference_position": Quantity("joint_reference", "position", "position"),
        "reference_velocity": Quantity("joint_reference", "velocity", "velocity"),
        "feedforward_torque": Quantity("joint_reference", "effort", "torque"),
    }
)
"""Every quantity of a motor that a mapping file may name."""
