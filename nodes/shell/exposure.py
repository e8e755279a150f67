"""Network exposure of a run: by default this machine only.

`ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST` restricts discovery, but the sockets listen on every interface of the machine.
A run therefore gives Fast DDS a profile that binds them to 127.0.0.1. Other nodes on this machine still find it.
"""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.errors import InputError, RunError
from flexros_nodes.shell.domain import FIRST_PORT, PORTS_PER_DOMAIN

if TYPE_CHECKING:
    from collections.abc import Mapping

RANGE_VARIABLE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
OLD_RANGE_VARIABLE = "ROS_LOCALHOST_ONLY"
PROFILE_VARIABLE = "FASTRTPS_DEFAULT_PROFILES_FILE"
MIDDLEWARE_VARIABLE = "RMW_IMPLEMENTATION"

CHOICES = (RANGE_VARIABLE, OLD_RANGE_VARIABLE, PROFILE_VARIABLE, "ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER")
"""Variables by which a user controls discovery; if one is set, the run sets none of them."""

PROFILE = Path(__file__).resolve().parent / "local_host.xml"
"""Profile of Fast DDS that binds every socket to 127.0.0.1."""

PROCESS = Path("/proc/self")
_LOCAL_HOST = "0100007F"  # 127.0.0.1 in the notation of the kernel


def exposure_settings(given: Mapping[str, str], *, network: bool) -> dict[str, str]:
    """Return the environment settings that expose a run to this machine only, or to the network.

    Args:
        given: Environment variables of the user; their middleware settings are kept.
        network: Whether other machines can access the run.

    Returns:
        Values of the variables to set.

    Raises:
        InputError: Network access is requested and the environment forbids it.
    """
    forbidding = {RANGE_VARIABLE: ("LOCALHOST", "OFF"), OLD_RANGE_VARIABLE: ("1",)}
    for variable, values in forbidding.items():
        if network and given.get(variable, "").upper() in values:
            raise InputError(f"network access is requested, but {variable} is '{given[variable]}'; unset the variable")
    if any(given.get(variable) for variable in CHOICES):
        return {}
    if network:
        return {RANGE_VARIABLE: "SUBNET"}
    if not given.get(MIDDLEWARE_VARIABLE, "rmw_fastrtps").startswith("rmw_fastrtps"):
        return {RANGE_VARIABLE: "LOCALHOST"}  # supported by every middleware
    return {RANGE_VARIABLE: "SYSTEM_DEFAULT", PROFILE_VARIABLE: str(PROFILE)}


def check_exposure(settings: Mapping[str, str], domain: int, process: Path = PROCESS) -> None:
    """Verify that this process, if the profile is set, listens on 127.0.0.1 only.

    Fast DDS reads the profile at its first use in a process: a process that had nodes before lacks it.

    Args:
        settings: Environment with the settings of the run.
        domain: ROS domain of the run.
        process: Folder of the process in the proc file system.

    Raises:
        RunError: A socket of the run is bound to another address.
    """
    if settings.get(PROFILE_VARIABLE) != str(PROFILE):
        return
    first = FIRST_PORT + PORTS_PER_DOMAIN * domain
    ports = range(first, first + PORTS_PER_DOMAIN)
    if any(port in ports and address != _LOCAL_HOST for address, port in _udp_sockets(process)):
        raise RunError(
            "this process has used ROS 2 before with sockets open to the network, which cannot be undone; start the "
            "run in a process of its own, or request network access"
        )


def _udp_sockets(process: Path) -> list[tuple[str, int]]:
    """Return address, in hexadecimal digits of the kernel, and port of the UDP sockets of a process."""
    own = set()
    with suppress(OSError):  # a system without /proc
        for link in (process / "fd").iterdir():
            with suppress(OSError):  # closed in the meantime
                own.add(str(link.readlink()))
        rows = [row.split() for row in (process / "net" / "udp").read_text(encoding="utf-8").splitlines()[1:]]
        endpoints = [row[1].split(":") for row in rows if f"socket:[{row[9]}]" in own]
        return [(address, int(port, 16)) for address, port in endpoints]
    return []
