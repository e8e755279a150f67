"""What every test may use: a ROS 2 domain of its own."""

from __future__ import annotations

import importlib
import os
import socket
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Iterator

# Workers and the processes that tests start run side by side: threads of BLAS would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Message setters check types while tests run; read when a message package is first imported.
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")

DOMAINS = range(1, 102)  # the domain numbers whose ports are free of the system's on every platform
FIRST_LOCK_PORT = 21_500


def claim_domain() -> tuple[int, socket.socket]:
    """Claim a domain number no other test process of this machine holds.

    Returns:
        The domain and the bound socket that stands for the claim; it ends when the socket closes or the process dies.
    """
    offset = os.getpid() % len(DOMAINS)
    for domain in (*DOMAINS[offset:], *DOMAINS[:offset]):
        claim = socket.socket()
        try:
            claim.bind(("127.0.0.1", FIRST_LOCK_PORT + domain))
        except OSError:
            claim.close()
            continue
        return domain, claim
    raise RuntimeError(f"all {len(DOMAINS)} ROS domains are claimed by running tests; end those first")


@pytest.fixture
def ros_domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Give the test, and processes it starts, a ROS 2 domain of its own on this machine only.

    Skips where rclpy cannot be imported, stating why.
    """
    try:
        importlib.import_module("rclpy")
    except ImportError as error:
        pytest.skip(f"needs ROS 2: rclpy cannot be imported ({error})")
    domain, claim = claim_domain()
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    try:
        yield domain
    finally:
        claim.close()
