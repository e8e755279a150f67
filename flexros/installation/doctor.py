"""All checks of the installation, in the order in which they are shown."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.installation.folders import check_cache, check_home, check_temporary
from flexros.installation.machine import check_processor, check_real_time, check_shared_memory
from flexros.installation.packages import check_extras, check_packages, check_python
from flexros.installation.ros import check_middleware, check_ros

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.installation.finding import Finding


def examine(environment: Mapping[str, str]) -> tuple[Finding, ...]:
    """Check the installation on this machine; ROS 2 is loaded in a process of its own.

    Args:
        environment: Environment variables.
    """
    ros = check_ros(environment)
    found = (
        check_python(),
        check_packages(),
        check_extras(),
        ros,
        check_middleware(ros, environment),
        check_shared_memory(),
        check_real_time(),
        check_processor(),
        check_cache(),
        check_home(environment),
        check_temporary(),
    )
    return tuple(finding for finding in found if finding is not None)


def healthy(findings: tuple[Finding, ...]) -> bool:
    """Return whether FlexROS works: nothing is broken, whatever is limited."""
    return all(finding.state != "broken" for finding in findings)
