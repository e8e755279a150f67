"""The nominal model of the feedback benchmark over topics: equal to the benchmark in process, to the last bit.

Its measures of a log are tested in `tests/benchmark/test_recorded.py`.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from flexros.benchmark.models import NOMINAL, ROBOT, set_values
from flexros.benchmark.simulation import RegulatorSimulation
from flexros.control.base import control_law
from flexros.control.design.fixed_structure import biquad_system, pid_system
from flexros.logs.reader import read_log
from flexros.robot import load_robot
from flexros.scenario.scenario import load_scenario

pytest.importorskip("rclpy", reason="needs ROS 2")

from flexros_nodes.bringup.run import run_scenario

pytestmark = pytest.mark.usefixtures("ros_domain")

SECONDS = 7.0
"""Beginning of the benchmark, with a step of the torque at tool and motor."""


def test_matrices_over_topics_equal_the_benchmark_in_process(tmp_path: Path) -> None:
    system = pid_system(24.0, 100.0, 2.35, 2.6e-3, 5e-4).then(biquad_system(60.0, 0.5, 80.0, 0.7, 5e-4))
    np.savez(tmp_path / "k.npz", A=system.A, B=system.B, C=system.C, D=system.D, dt=5e-4)
    controller = {"kind": "state_space", "file": str(tmp_path / "k.npz")}
    changes = {"controller": controller, "duration": SECONDS}
    content = load_scenario("feedback_benchmark").with_values(changes).settings()
    (tmp_path / "mine.yaml").write_text(json.dumps({**content, "controller": controller}))  # JSON is YAML
    summary = run_scenario(str(tmp_path / "mine.yaml"), tmp_path / "log")
    assert (summary.exit_code, summary.missing) == (0, 0)
    log = read_log(tmp_path / "log")
    robot = load_robot(ROBOT)
    runs = RegulatorSimulation(robot).run(
        control_law(controller),
        set_values(robot, NOMINAL),
        lambda _, z, u: (z.copy(), u.copy()),
        noise=3e-4,
        seeds=(1,),
    )
    deflection, command = runs[0][0]
    assert log.joint_commands is not None
    assert log.tool_pose is not None
    assert log.joint_commands.effort is not None
    n = round(SECONDS / 5e-4) + 1
    assert np.array_equal(log.joint_commands.effort[:, 0], command[:n])
    assert np.array_equal(1e3 * log.tool_pose.position[:, 0], deflection[:n])
