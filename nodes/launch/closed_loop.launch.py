"""Any scenario as a closed loop: ros2 launch flexros closed_loop.launch.py robot:=e12 scenario:=circle_dae."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description("circle_pd")
