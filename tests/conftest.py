"""Fixtures for all tests: a separate ROS 2 domain."""

from __future__ import annotations

import gc
import importlib
import os
import sys
from typing import TYPE_CHECKING

import pytest

from flexros_nodes.shell.domain import claim_domain
from tests.segments import own_ports

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

# Workers and the processes that tests start run side by side: threads of BLAS would wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
# Hundreds of processes import the same modules: each would compile all of them again.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
# Message setters check types while tests run; read when a message package is first imported.
os.environ.setdefault("ROS_PYTHON_CHECK_FIELDS", "1")


# Collection makes many objects and hardly any garbage: searches for it would take an eighth of its time.
gc.disable()


def pytest_configure(config: pytest.Config) -> None:
    """Let the workers and all processes that tests start share machine code, apart from that of the user.

    It is kept for the next run. An object is named by all that determines it, so no old one can take part.
    """
    if hasattr(config.option, "loadscopereorder"):
        config.option.loadscopereorder = False  # files with most tests first: those with few long ones would end alone
    if not hasattr(config, "workerinput"):
        os.environ["FLEXROS_CACHE"] = str(config.rootpath / ".pytest_cache" / "machine_code")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark tests that start ROS 2 nodes, as they ask for a domain, and those of a study that takes seconds."""
    for item in items:
        if "ros_domain" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.ros)
        if "small_study" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.slow)
    items[:] = [item for file in in_order_of_work(items) for item in file]


def in_order_of_work(items: list[pytest.Item]) -> list[list[pytest.Item]]:
    """Give the tests of each file: files with long tests first, those that wait for nodes spread between the others."""
    files: dict[Path, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)
    waiting, long, short = [], [], []
    for file in files.values():
        marks = {mark.name for item in file for mark in item.iter_markers()}
        (waiting if "ros" in marks else long if "slow" in marks else short).append(file)
    places = [((k + 0.5) / len(group), file) for group in (waiting, long) for k, file in enumerate(group)]
    return [*(file for _, file in sorted(places, key=lambda place: place[0])), *short]


def pytest_collection_finish() -> None:
    """Leave what collection has made out of every later search for garbage: it stays until the end."""
    gc.collect()
    gc.freeze()
    gc.enable()


@pytest.fixture
def ros_domain(monkeypatch: pytest.MonkeyPatch) -> Iterator[int]:
    """Give the test, and processes it starts, a ROS 2 domain of its own on this machine only.

    Skips where rclpy cannot be imported, stating why. A test that leaves a participant in this process fails: it would
    be a partner of the next test.
    """
    try:
        importlib.import_module("rclpy")
    except ImportError as error:
        pytest.skip(f"needs ROS 2: rclpy cannot be imported ({error})")
    domain, claim = claim_domain(os.getpid())
    monkeypatch.setenv("ROS_DOMAIN_ID", str(domain))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with claim:
        yield domain
        assert not own_ports(domain), "the test left a participant in this process"
