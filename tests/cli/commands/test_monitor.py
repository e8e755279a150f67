"""flexros monitor."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from flexros.logs.write_log import write_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

Command = Callable[..., Any]


def record(folder: Path, *effects: str) -> str:
    motion = {"diagnosis.length": 10, "diagnosis.parts": ["multisine"]}
    changes = {"robot": "elbow", **motion, "seed": 41, "plant.effects": list(effects)}
    write_log(closed_loop(Experiment.prepare(load_scenario("diagnosis").with_values(changes, "test"))), folder)
    return str(folder)


@pytest.fixture(scope="module")
def nominal(tmp_path_factory: pytest.TempPathFactory) -> str:
    return record(tmp_path_factory.mktemp("monitor") / "nominal")


@pytest.fixture(scope="module")
def rough(tmp_path_factory: pytest.TempPathFactory) -> str:
    return record(tmp_path_factory.mktemp("monitor") / "rough", "coulomb_friction@motor_2:level=1")


def test_a_log_of_the_model_ends_with_zero(flexros: Command, nominal: str) -> None:
    ended = flexros("monitor", nominal, "--model", "elbow")
    assert ended.code == 0, ended.err
    assert "no alarm in " in ended.out


def test_an_alarm_ends_with_one_and_names_the_joint(flexros: Command, rough: str) -> None:
    ended = flexros("monitor", rough, "--model", "elbow", "--json")
    assert ended.code == 1, ended.err
    content = json.loads(ended.out)
    assert [alarm["joint"] for alarm in content["alarms"]] == ["motor_2"]
    assert content["motors"]["motor_2"]["missing_torque_rms"] == pytest.approx(1.0, rel=0.5)
    assert flexros("monitor", rough, "--model", "elbow").out.startswith("alarm since ")


def test_what_a_calibration_accepts_is_no_alarm(flexros: Command, rough: str, tmp_path: Path) -> None:
    file = str(tmp_path / "accepted.json")
    made = flexros("monitor", rough, "--model", "elbow", "--calibrate", file)
    assert made.code == 0, made.err
    assert "accepted gap, over noise: motor_1 " in made.out
    ended = flexros("monitor", rough, "--model", "elbow", "--thresholds", file)
    assert ended.code == 0, ended.out


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--false-alarms", "0"), "--false-alarms is 0, allowed are rates from 1e-6 to 100 per hour"),
        (("--thresholds", "a", "--calibrate", "b"), "--thresholds and --calibrate exclude each other"),
        (("--thresholds", "nowhere.json"), "the calibration nowhere.json cannot be read"),
    ],
)
def test_options_that_make_no_sense_are_refused(
    flexros: Command, nominal: str, options: tuple[str, ...], told: str
) -> None:
    ended = flexros("monitor", nominal, "--model", "elbow", *options)
    assert ended.code == 2
    assert told in ended.err
