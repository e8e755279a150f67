"""Diagnosis experiment: robot:=NAME chooses the robot, effects:=... what its model lacks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description("diagnosis", "hidden_effect")
