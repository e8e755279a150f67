"""Fixtures for tests of nodes: comparison of logs, manually spun nodes, scenarios."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import fields
from functools import partial
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from flexros.logs.time_series import Log
from flexros.scenario.scenario import load_scenario

if TYPE_CHECKING:
    from flexros_nodes.shell.node_base import FlexrosNode

CHECKOUT = Path(__file__).parents[2]
EXAMPLES = CHECKOUT / "docs" / "examples"
PATIENCE = 60.0

StartProcess = Callable[..., subprocess.Popen[str]]

SAMPLED = ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference")


def differences(first: Log, second: Log) -> list[str]:
    """Name the topics and fields that differ in any bit."""
    found = []
    for topic in SAMPLED:
        one, other = getattr(first, topic), getattr(second, topic)
        if one is None or other is None:
            found.append(f"{topic} is missing")
            continue
        for field in fields(one):
            a, b = getattr(one, field.name), getattr(other, field.name)
            same = np.array_equal(a, b) if isinstance(a, np.ndarray) and isinstance(b, np.ndarray) else a is b or a == b
            if not same:
                found.append(f"{topic}.{field.name}")
    return found


def started_node(node: str, *parameters: str) -> subprocess.Popen[str]:
    arguments = [word for parameter in parameters for word in ("-p", parameter)]
    return subprocess.Popen(
        [sys.executable, "-m", f"flexros_nodes.{node}", "--ros-args", *arguments],
        cwd=CHECKOUT,
        env={**os.environ, "PYTHONPATH": str(CHECKOUT)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def kept(start: StartProcess) -> Iterator[StartProcess]:
    """Yield a start function whose processes end with the test."""
    processes: list[subprocess.Popen[str]] = []

    def begin(*arguments: str) -> subprocess.Popen[str]:
        processes.append(start(*arguments))
        return processes[-1]

    yield begin
    for process in processes:
        process.kill()
        process.communicate()


@pytest.fixture(autouse=True)
def short_bare_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    """Measure the bare loop after a run in real time for a moment only."""
    if (module := sys.modules.get("flexros_nodes.bringup.run")) is not None:
        monkeypatch.setattr(module, "BARE_LOOP", 0.05)


@pytest.fixture
def start_node() -> Iterator[StartProcess]:
    """Yield the start of a node as a process, from its name and parameters `name:=value`."""
    yield from kept(started_node)


def started_example(name: str, *arguments: str) -> subprocess.Popen[str]:
    return subprocess.Popen(
        [sys.executable, str(EXAMPLES / name), *arguments],
        env={key: value for key, value in os.environ.items() if key != "PYTHONPATH"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def start_example() -> Iterator[StartProcess]:
    """Yield the start of an example of the guide as a user process without FlexROS on its path."""
    yield from kept(started_example)


def ended_with(plant: subprocess.Popen[str], *others: subprocess.Popen[str], spin: Callable[[], None]) -> str:
    deadline = monotonic() + PATIENCE
    while plant.poll() is None:
        assert monotonic() < deadline, "the plant did not end"
        spin()
    said, errors = plant.communicate(timeout=PATIENCE)
    assert plant.returncode == 0, errors
    for process in others:
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=PATIENCE)
        assert process.returncode == 0, errors
    return said or ""


@pytest.fixture
def end_with_plant() -> Callable[..., str]:
    """Give the end of a run of processes: the plant by itself, then the others by SIGTERM; all of them well.

    Called with the plant, the others and `spin`, what to do while the plant works; gives what the plant has printed.
    """
    return partial(ended_with, spin=partial(sleep, 0.02))


@pytest.fixture
def log_differences() -> Callable[[Log, Log], list[str]]:
    """Return the comparison of two logs."""
    return differences


@pytest.fixture
def long_scenario(tmp_path: Path) -> Path:
    """Write a scenario that holds the circle's start for a minute: long enough to be interrupted."""
    settings = {**load_scenario("circle_pd").settings(), "duration": 60.0, "name": "long"}
    path = tmp_path / "long.yaml"
    path.write_text(json.dumps(settings))
    return path


@pytest.fixture
def short_scenario(tmp_path: Path) -> Path:
    """Write the beginning of the circle: 0.2 s, 401 samples."""
    settings = {**load_scenario("circle_dae").settings(), "duration": 0.2}
    path = tmp_path / "short.yaml"
    path.write_text(json.dumps(settings))
    return path


def identification_settings() -> dict[str, Any]:
    """Return the settings of a short identification of the two-mass robot: two positions, two blocks, 4.2 s."""
    return {
        **{key: load_scenario("two_mass_step").settings()[key] for key in ("robot", "controller")},
        "name": "identify",
        "identification": {
            "positions": [[0.0], [0.3]],
            "blocks": 2,
            "excitation": {"kind": "multisine", "period": 0.2, "lowest": 5, "highest": 40, "amplitude": 0.02},
            "periods": 2,
            "transient_periods": 1,
            "fade": 0.05,
            "settle": 0.1,
        },
    }


@pytest.fixture
def identification_scenario(tmp_path: Path) -> Path:
    """Write a short identification of the two-mass robot."""
    path = tmp_path / "identify.yaml"
    path.write_text(json.dumps(identification_settings()))
    return path


class Bench:
    """Nodes in a context of their own, with an executor to spin them."""

    def __init__(self, domain: int) -> None:
        import rclpy
        from rclpy.context import Context

        from flexros_nodes.shell.spinning import make_executor

        self.context = Context()
        rclpy.init(context=self.context, args=[], domain_id=domain)
        self.executor = make_executor(self.context)
        self.nodes: list[Any] = []

    def close(self) -> None:
        import rclpy

        from flexros_nodes.shell.removal import limited_removal

        with limited_removal():
            self.executor.shutdown()
            for node in self.nodes:
                node.destroy_node()
            rclpy.try_shutdown(context=self.context)

    def add(self, node_class: type[FlexrosNode], **values: Any) -> Any:
        return self.hold(node_class(context=self.context, values={"scenario": "circle_dae", **values}))

    def hold(self, node: Any) -> Any:
        self.nodes.append(node)
        self.executor.add_node(node)
        return node

    def spin_for(self, time: float) -> None:
        end = monotonic() + time
        while monotonic() < end:
            self.executor.spin_once(timeout_sec=0.02)

    def spin_until(self, condition: Callable[[], bool], timeout: float = 20.0) -> None:
        deadline = monotonic() + timeout
        while not condition():
            assert monotonic() < deadline, "the condition did not come true"
            self.executor.spin_once(timeout_sec=0.02)


@pytest.fixture
def bench(ros_domain: int) -> Iterator[Bench]:
    """Yield a context and an executor for nodes created by the test."""
    bench = Bench(ros_domain)
    yield bench
    bench.close()
