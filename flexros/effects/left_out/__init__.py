"""Numbers that a robot file leaves out, which a diagnosis estimates."""

from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad

__all__ = ["RotorInertia", "ToolLoad"]
