"""Shared memory of a ROS domain, by which a test finds what was left behind."""

from __future__ import annotations

import re
from pathlib import Path
from time import monotonic, sleep

from flexros_nodes.shell.domain import FIRST_PORT, PORTS_PER_DOMAIN
from flexros_nodes.shell.shared_memory import FOLDER


def _ports(domain: int, names: set[str]) -> set[str]:
    first = FIRST_PORT + PORTS_PER_DOMAIN * domain
    return names & {f"fastrtps_port{port}" for port in range(first, first + PORTS_PER_DOMAIN)}


def left_ports(domain: int, patience: float = 5.0) -> set[str]:
    """Name the ports of a domain of which this machine still has shared memory after a while [s] at most.

    The cleaner of another run that ends just now may have locked one, to remove it.
    """
    deadline = monotonic() + patience
    while (left := _ports(domain, {path.name for path in FOLDER.iterdir()})) and monotonic() < deadline:
        sleep(0.05)
    return left


def own_ports(domain: int) -> set[str]:
    """Name the ports of a domain that this process has mapped: those of participants it still has."""
    return _ports(domain, set(re.findall(r"fastrtps_port\d+", Path("/proc/self/maps").read_text(encoding="utf-8"))))
