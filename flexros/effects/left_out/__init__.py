"""Numbers that a robot file leaves out, or has roughly, which a diagnosis estimates."""

from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad

__all__ = ["BodyDifference", "RotorInertia", "ToolLoad"]
