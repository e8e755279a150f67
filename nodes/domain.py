"""A ROS domain and discovery range of one's own for a run, so that runs beside each other do not meet."""

from __future__ import annotations

import os
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

DOMAIN_VARIABLE = "ROS_DOMAIN_ID"
RANGE_VARIABLE = "ROS_AUTOMATIC_DISCOVERY_RANGE"
OLD_RANGE_VARIABLE = "ROS_LOCALHOST_ONLY"

LAST_DOMAIN = 101
"""Highest domain whose ports stay below those that Linux gives out by itself."""

# Ports of DDS (OMG DDSI-RTPS 2.2, section 9.6.1.1): 7400 + 250 domain + 10 is the first participant's own port.
_FIRST_PORT, _DOMAIN_STEP, _PARTICIPANT_OFFSET = 7400, 250, 10


def is_free(domain: int) -> bool:
    """Tell whether no participant of this machine is in a domain."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", _FIRST_PORT + _DOMAIN_STEP * domain + _PARTICIPANT_OFFSET))
        except OSError:
            return False
    return True


def free_domain(start: int) -> int:
    """Find a domain without participants.

    Args:
        start: Number from which the search begins, e.g. that of the process, so that runs seldom try the same.

    Returns:
        Domain, 1 to 101.

    Raises:
        InputError: All are taken.
    """
    for step in range(LAST_DOMAIN):
        domain = 1 + (start + step) % LAST_DOMAIN
        if is_free(domain):
            return domain
    raise InputError(f"all ROS domains from 1 to {LAST_DOMAIN} are taken on this machine; set {DOMAIN_VARIABLE}")


def run_environment(given: Mapping[str, str], start: int) -> dict[str, str]:
    """Give the settings of a run; what the user has set stays.

    Args:
        given: Environment of the user.
        start: Number from which the search for a free domain begins.

    Returns:
        Values of the variables that the run sets.

    Raises:
        InputError: The user's domain is not a number from 0 to 232.
    """
    settings = {}
    domain = given.get(DOMAIN_VARIABLE, "")
    if not domain:
        settings[DOMAIN_VARIABLE] = str(free_domain(start))
    elif not domain.isdigit() or int(domain) > 232:
        raise InputError(
            f"{DOMAIN_VARIABLE} is '{domain}', allowed is a number from 0 to 232; correct or unset the variable"
        )
    if not given.get(RANGE_VARIABLE) and not given.get(OLD_RANGE_VARIABLE):
        settings[RANGE_VARIABLE] = "LOCALHOST"
    return settings


@contextmanager
def environment(settings: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables while in the block; the ROS middleware reads them when a context begins."""
    before = {name: os.environ.get(name) for name in settings}
    os.environ.update(settings)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value
