"""Healthy logs and their robots, and what spoils them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from flexros.record.checks.base import Finding
from flexros.record.checks.run import findings
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

LENGTH = 10.0  # s
RECORDED = 10.5
"""What the checks see of a robot of several axes, whose balance takes long [s]: below 10 s they tell the length."""


@cache
def robot_named(name: str) -> Robot:
    return load_robot(name)


@cache
def healthy_record(name: str, effects: tuple[str, ...] = (), *, whole: bool = False) -> Record:
    """Record of a short diagnosis experiment, with effects in the plant where given; of several axes its first part."""
    scenario = load_scenario("diagnosis").with_values({"robot": name, "diagnosis.length": LENGTH}, "test")
    if effects:
        scenario = scenario.with_values({"plant.effects": list(effects)}, "test")
    log = closed_loop(Experiment.prepare(scenario))
    record = read_record(log, robot_named(name), name="log")
    complete = whole or record.position.shape[1] == 1
    return record if complete else record.part(0, round(RECORDED / record.sample_time))


@pytest.fixture(name="healthy", scope="session")
def healthy_fixture() -> Callable[..., Record]:
    return healthy_record


@pytest.fixture(name="robots", scope="session")
def robots_fixture() -> Callable[[str], Robot]:
    return robot_named


@pytest.fixture(name="found", scope="session")
def found_fixture() -> Callable[..., tuple[Finding, ...]]:
    def found(name: str, record: Record | None = None, **changes: object) -> tuple[Finding, ...]:
        """Findings of the checks in a record, by default the healthy one of a robot with changed signals."""
        base = healthy_record(name) if record is None else record
        return findings(replace(base, **changes), robot_named(name))

    return found


def scaled(values: np.ndarray, column: int, factor: float) -> np.ndarray:
    """Multiply one column."""
    changed = values.copy()
    changed[:, column] *= factor
    return changed


@pytest.fixture(name="scaled", scope="session")
def scaled_fixture() -> Callable[[np.ndarray, int, float], np.ndarray]:
    return scaled
