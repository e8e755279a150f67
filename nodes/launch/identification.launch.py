"""Identification experiment; begin_at_once:=false waits for the service identification/start."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description(
        "identify_e12", "identify_two_mass", "identify_six_axis", "identify_six_axis_friction", "friction_two_mass"
    )
