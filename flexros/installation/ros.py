"""ROS 2: whether nodes can run, where it comes from, and with which middleware. Looks without importing it here."""

from __future__ import annotations

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from flexros.installation.finding import Finding

if TYPE_CHECKING:
    from collections.abc import Mapping

WANTED = "jazzy"
"""Distribution for which the nodes are written."""
FAST = "rmw_fastrtps"
"""Middleware whose sockets a run can bind to this machine alone."""
_LONGEST = 60.0
"""Time after which a process that imports rclpy counts as hung [s] (chosen)."""
_PROGRAM = """
import json, rclpy
from rclpy.utilities import get_rmw_implementation_identifier
print(json.dumps({"rclpy": rclpy.__file__, "middleware": get_rmw_implementation_identifier()}))
"""


def check_ros(environment: Mapping[str, str]) -> Finding:
    """Look for ROS 2 and load it in a process of its own.

    Args:
        environment: Environment variables; ROS_DISTRO names a sourced distribution, RMW_IMPLEMENTATION a middleware.
    """
    sourced = environment.get("ROS_DISTRO", "")
    spec = find_spec("rclpy")
    facts: dict[str, Any] = {"ros_distro": sourced, "domain_id": environment.get("ROS_DOMAIN_ID", "")}
    without = "everything but the nodes works, runs are made in-process"
    if spec is None:
        where = f"ROS 2 {sourced} is sourced, but this Python cannot import rclpy" if sourced else "no ROS 2 is sourced"
        remedy = (
            f"make the environment with the Python of ROS 2 {sourced}, such that it sees the packages of the system"
            if sourced
            else "source ROS 2 Jazzy, or on Linux x86_64: pip install 'flexros[ros]'"
        )
        return Finding("ROS 2", "limited", f"{where}: {without}", remedy, {**facts, "found": False})
    try:
        command = [sys.executable, "-c", _PROGRAM]
        done = subprocess.run(  # noqa: S603 - our own words
            command, capture_output=True, text=True, timeout=_LONGEST, check=False, env=dict(environment)
        )
        loaded = json.loads(done.stdout.splitlines()[-1]) if done.returncode == 0 else None
        why = "" if loaded else (done.stderr.strip().splitlines() or ["no message"])[-1]
    except (subprocess.TimeoutExpired, json.JSONDecodeError, IndexError, OSError) as error:
        loaded, why = None, str(error)
    if loaded is None:
        text = f"rclpy is at {spec.origin}, but cannot be loaded: {why}"
        return Finding("ROS 2", "broken", text, "repair ROS 2, or leave it out: runs work in-process", facts)
    within = Path(loaded["rclpy"]).is_relative_to(sys.prefix)
    origin = "wheels" if within else "sourced" if sourced else "path"
    facts |= {"found": True, "origin": origin, **loaded}
    names = {"wheels": "wheels", "sourced": f"ROS 2 {sourced}", "path": "the path of Python, no ROS 2 is sourced"}
    text = f"rclpy from {names[origin]}: {loaded['rclpy']}"
    if sourced and sourced != WANTED:
        remedy = f"the nodes are written for ROS 2 {WANTED.capitalize()}; source that"
        return Finding("ROS 2", "limited", f"{text}: distribution {sourced}", remedy, facts)
    return Finding("ROS 2", "ok", text, facts=facts)


def check_middleware(ros: Finding, environment: Mapping[str, str]) -> Finding | None:
    """Judge the middleware.

    Args:
        ros: The finding on ROS 2; without ROS 2 there is nothing to judge.
        environment: Environment variables.
    """
    name = ros.facts.get("middleware")
    if not name:
        return None
    facts = {"name": name, "chosen_by_RMW_IMPLEMENTATION": bool(environment.get("RMW_IMPLEMENTATION"))}
    if str(name).startswith(FAST):
        return Finding("middleware", "ok", f"{name}: runs are bound to 127.0.0.1 unless asked otherwise", facts=facts)
    text = f"{name}: runs are kept to this machine by ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST"
    return Finding("middleware", "limited", text, "rates of FlexROS are measured with rmw_fastrtps_cpp", facts)
