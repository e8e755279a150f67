"""Joint moves of the elbow under model-based control, with sensors at links and tool."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description(
        "elbow_feedback_linearisation",
        "elbow_quasi_static",
        "elbow_state_feedback",
        "elbow_kalman",
        "elbow_extended_kalman",
        "elbow_accelerometer",
        "elbow_torque_feedback",
        "four_mass_lqg",
        "elbow_computed_torque",
        "elbow_gravity_pd",
    )
