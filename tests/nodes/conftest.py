"""What tests of nodes share: comparing logs, bad controllers, a long scenario."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from flexros.config.scenario import load_scenario
from flexros.logs.time_series import Log

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


@pytest.fixture
def log_differences() -> Callable[[Log, Log], list[str]]:
    """Give the comparison of two logs."""
    return differences


@pytest.fixture
def long_scenario(tmp_path: Path) -> Path:
    """Write a scenario that holds the circle's start for two minutes: long enough to be interrupted."""
    settings = {**load_scenario("circle_pd").settings(), "duration": 120.0, "name": "long"}
    path = tmp_path / "long.yaml"
    path.write_text(json.dumps(settings))
    return path
