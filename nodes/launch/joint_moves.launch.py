"""Joint moves of a robot under gravity, with DAE feedforward for the gear angles, or as fast as the torques allow."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description("elbow_moves", "elbow_time_optimal", "six_axis_moves")
