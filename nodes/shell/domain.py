"""ROS domain of a run, which separates concurrent runs."""

from __future__ import annotations

import os
import socket
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

DOMAIN_VARIABLE = "ROS_DOMAIN_ID"

LAST_DOMAIN = 101
"""Highest domain whose ports are below the ephemeral ports of Linux."""

FIRST_PORT = 7400
"""First port of domain 0 (OMG DDSI-RTPS 2.2, section 9.6.1.1)."""

PORTS_PER_DOMAIN = 250

# Within the ports of a domain, offset 10 belongs to the first participant and 2 to 9 are unused.
_PARTICIPANT_OFFSET, _CLAIM_OFFSET = 10, 9


def is_free(domain: int) -> bool:
    """Return whether no participant of this machine is in a domain."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("", FIRST_PORT + PORTS_PER_DOMAIN * domain + _PARTICIPANT_OFFSET))
        except OSError:
            return False
    return True


def claim_domain(start: int) -> tuple[int, socket.socket]:
    """Find a domain without participants and reserve it.

    Args:
        start: Start of the search, e.g. the process identifier, so that runs seldom try the same domains.

    Returns:
        Domain, 1 to 101, and the socket that reserves it until it is closed.

    Raises:
        InputError: All domains are in use.
    """
    for step in range(LAST_DOMAIN):
        domain = 1 + (start + step) % LAST_DOMAIN
        claim = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            claim.bind(("127.0.0.1", FIRST_PORT + PORTS_PER_DOMAIN * domain + _CLAIM_OFFSET))
        except OSError:
            claim.close()
            continue
        if is_free(domain):
            return domain, claim
        claim.close()
    raise InputError(f"all ROS domains from 1 to {LAST_DOMAIN} are in use on this machine; set {DOMAIN_VARIABLE}")


@contextmanager
def domain_of_run(given: Mapping[str, str], start: int) -> Iterator[int]:
    """Yield the domain of a run: that of the user, else one that is reserved on this machine within the block.

    Args:
        given: Environment variables of the user.
        start: Start of the search for a free domain.

    Raises:
        InputError: The domain of the user is not a number from 0 to 232, or all are in use.
    """
    domain = given.get(DOMAIN_VARIABLE, "")
    if domain and (not domain.isdecimal() or int(domain) > 232):
        raise InputError(
            f"{DOMAIN_VARIABLE} is '{domain}', allowed is a number from 0 to 232; correct or unset the variable"
        )
    if domain:
        yield int(domain)
        return
    number, claim = claim_domain(start)
    with claim:
        yield number


@contextmanager
def environment(settings: Mapping[str, str]) -> Iterator[None]:
    """Set environment variables within the block; the ROS middleware reads them when a context is created."""
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
