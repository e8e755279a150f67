"""Robots side by side, each in a namespace: robots:="left=circle_dae, right=circle_pd"."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import robots_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return robots_description()
