"""Circle test of Moberg (2007), Paper B, with each method of feedforward."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros_nodes.bringup.launching import run_description

if TYPE_CHECKING:
    from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Describe arguments and nodes."""
    return run_description(
        "circle_dae",
        "circle_dae2",
        "circle_fj",
        "circle_pd",
        "smooth_dae",
        "smooth_dae2",
        "circle_stable_inversion",
        "circle_flexible_links",
    )
