"""Regulator problem of Moberg (2007), Paper C: torque disturbances at motor and tool."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description("regulator_four_mass", "two_mass_step", "feedback_benchmark", "four_mass_state_space")
