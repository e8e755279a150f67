"""Claims of topics on this machine: one plant, one controller and one reference stream per ROS domain and namespace.

A claim is an abstract Unix socket, which the kernel removes with its process. Two runs that the user has put into one
domain thus meet before any of their messages do, whatever the middleware has discovered by then. Nodes on other
machines, and those of the user, hold no claims: `Partners` finds them in the graph.
"""

from __future__ import annotations

import os
import socket
import struct
import sys
from typing import TYPE_CHECKING

from flexros.errors import InputError
from flexros_nodes.shell.domain import DOMAIN_VARIABLE
from flexros_nodes.shell.exposure import RANGE_VARIABLE

if TYPE_CHECKING:
    from collections.abc import Mapping

PRODUCERS = {"joint_states": "plant", "joint_commands": "controller", "joint_reference_ahead": "reference stream"}
"""Topics with one producer in a run, and what produces them."""

_PROCESS_OF_PEER = getattr(socket, "SO_PEERCRED", None)


class TopicClaim:
    """Claim of a topic by a node, held until `release`.

    Args:
        domain: ROS domain of the node.
        topic: Resolved name of the topic, e.g. "/left/joint_states".
        run: Identity of the run, empty for a node that was started by itself.
        environment: Environment variables.

    Raises:
        InputError: Another node of this machine publishes the topic in this domain.
    """

    def __init__(self, domain: int, topic: str, run: str, environment: Mapping[str, str]) -> None:
        self._sockets: list[socket.socket] = []
        if not _supported(environment):
            return
        if (holder := _held_by(_name(domain, topic))) is not None:
            raise InputError(_refusal(domain, topic, holder))
        for name in (_name(domain, topic, run), _name(domain, topic)) if run else (_name(domain, topic),):
            self._hold(domain, topic, name)

    def _hold(self, domain: int, topic: str, name: str) -> None:
        claim = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self._sockets.append(claim)
        try:
            claim.bind(name)
        except OSError as error:
            self.release()
            raise InputError(_refusal(domain, topic, _held_by(name) or 0)) from error
        claim.listen()

    def release(self) -> None:
        """Give the topic up."""
        for claim in self._sockets:
            claim.close()
        self._sockets.clear()


def refuse_claims_of_others(domain: int, topic: str, run: str, environment: Mapping[str, str]) -> None:
    """Refuse to take part in a domain in which a topic of the run belongs to another run.

    Args:
        domain: ROS domain of the node.
        topic: Resolved name of the topic.
        run: Identity of the run; a node without one takes part in any run.
        environment: Environment variables.

    Raises:
        InputError: A node of another run on this machine publishes the topic.
    """
    if not run or not _supported(environment) or _held_by(_name(domain, topic, run)) is not None:
        return
    if (holder := _held_by(_name(domain, topic))) is not None:
        raise InputError(_refusal(domain, topic, holder))


def _supported(environment: Mapping[str, str]) -> bool:
    """Return whether claims exist here and are wanted: with the range OFF each process is alone in its domain."""
    return sys.platform == "linux" and environment.get(RANGE_VARIABLE, "").upper() != "OFF"


def _name(domain: int, topic: str, run: str = "") -> str:
    return f"\0flexros/{domain}{topic}" + (f"#{run}" if run else "")


def _held_by(name: str) -> int | None:
    """Return the process that holds a claim, 0 if the system does not tell; None if nobody does."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as probe:
        probe.setblocking(False)
        try:
            probe.connect(name)
        except BlockingIOError:  # held, but nobody accepts the connections
            return 0
        except OSError:
            return None
        if _PROCESS_OF_PEER is None:
            return 0
        credentials = probe.getsockopt(socket.SOL_SOCKET, _PROCESS_OF_PEER, struct.calcsize("3i"))
        return int(struct.unpack("3i", credentials)[0])


def _refusal(domain: int, topic: str, holder: int) -> str:
    producer = PRODUCERS.get(topic.rpartition("/")[2], "node")
    who = f"process {holder}" if holder and holder != os.getpid() else "another node of this process"
    return (
        f"a {producer} of another run is in ROS domain {domain}: {who} publishes {topic} there; end that run, or give "
        f"this one a {DOMAIN_VARIABLE} of its own"
    )
