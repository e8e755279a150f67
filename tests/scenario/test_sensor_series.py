"""Further sensors of a run: in the log, in batches and sample by sample, and what they show."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from flexros.compile.loop.arrays import LoopInputs
from flexros.compile.loop.kernel import compile_loop
from flexros.config.yaml_file import read_yaml
from flexros.logs.time_series import ImuSeries, JointSeries
from flexros.robot.robot import LIBRARY
from flexros.scenario.batch import batch, whole_record
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant import delayed_start

SENSORS = {
    "link": {"position": {"noise": 1e-6}, "torque": {"noise": 0.5, "bias": 2.0}, "delay": 1e-3, "rate": 1000},
    "tool_imu": {
        "acceleration": {"noise": 0.02, "axes": ["x", "z"]},
        "turning_rate": {"noise": 1e-4},
        "position": [0.1, 0.0, 0.05],
        "orientation": [0.0, 0.3, 0.0],
    },
}


def robot_file(folder: Path, name: str = "elbow", sensors: object = None) -> str:
    data = dict(read_yaml(LIBRARY / f"{name}.yaml"))
    data["sensors"] = {**data["sensors"], **(SENSORS if sensors is None else sensors)}  # type: ignore[dict-item]
    (folder / f"{name}.yaml").write_text(yaml.safe_dump(data))
    return str(folder / f"{name}.yaml")


def moves(robot: str, **values: object) -> Scenario:
    return load_scenario("elbow_moves").with_values({"robot": robot, "duration": 0.6, **values})


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    return Experiment.prepare(moves(robot_file(tmp_path_factory.mktemp("robot"))))


def test_sensors_that_no_law_uses_change_no_bit(run: Experiment) -> None:
    without = closed_loop(Experiment.prepare(moves("elbow")))
    with_them = closed_loop(run)
    assert without.other_series == {}
    assert np.array_equal(with_them.joint_states.position, without.joint_states.position)  # type: ignore[arg-type]


def test_run_batch_and_single_samples_agree_to_the_bit(run: Experiment) -> None:
    log, record = closed_loop(run), batch(run, whole_record, seeds=[1])[0]
    link, imu = log.other_series["link_states"], log.other_series["tool_imu"]
    assert isinstance(link, JointSeries)
    assert isinstance(imu, ImuSeries)
    plant, controller, n = run.plant_in_time(), run.controller(), 100
    commands, held = [], []
    for reference in run.reference_signal[:n]:
        held.append(plant.further())
        commands.append(controller.step([*plant.measure(), *held[-1]], reference))
        plant.advance(commands[-1])
    seen = np.array(held)
    assert log.joint_commands is not None
    assert np.array_equal(log.joint_commands.effort, record.command)  # type: ignore[arg-type]
    assert np.array_equal(log.joint_commands.effort[:n], commands)  # type: ignore[index]
    assert np.array_equal(link.position[: n // 2], seen[::2, :2])  # type: ignore[index]
    assert np.array_equal(link.effort[: n // 2], seen[::2, 2:4])  # type: ignore[index]
    assert np.array_equal(imu.acceleration[:n, [0, 2]], seen[:, 4:6])  # type: ignore[index]
    assert np.all(np.isnan(imu.acceleration[:, 1]))  # type: ignore[index]
    assert np.array_equal(np.diff(link.stamp), np.full(len(link.stamp) - 1, 1_000_000))


def test_at_rest_they_show_gravity_bias_and_noise(tmp_path: Path) -> None:
    scenario = {"robot": robot_file(tmp_path), "duration": 0.5, "feedforward": {"method": "rigid", "output": "joints"}}
    law = {"kind": "pid", "kp": [1e5, 3e4], "kd": [6e3, 1.5e3], "ki": [3e5, 9e4]}
    run = Experiment.prepare(Scenario.model_validate({**scenario, "controller": law}))
    log = closed_loop(run)
    link, imu = log.other_series["link_states"], log.other_series["tool_imu"]
    assert isinstance(link, JointSeries)
    assert isinstance(imu, ImuSeries)
    assert np.nanmean(np.hypot(imu.acceleration[:, 0], imu.acceleration[:, 2])) == pytest.approx(9.81, abs=5e-3)  # type: ignore[index]
    weight = run.plant.model.arm_inverse_dynamics(run.start_state[:2], [0, 0], [0, 0], []).full().ravel()
    assert link.effort is not None
    assert link.effort.mean(axis=0) == pytest.approx(weight + 2.0, abs=0.3)
    assert link.effort.std(axis=0) == pytest.approx([0.5, 0.5], rel=0.3)
    assert imu.turning_rate is not None
    assert imu.turning_rate[:, 0].std() == pytest.approx(1e-4, rel=0.2)


def test_acceleration_is_the_second_derivative_of_the_place_of_the_sensor(tmp_path: Path) -> None:
    sensors = {"tool_imu": {"acceleration": {}}}
    log = closed_loop(Experiment.prepare(moves(robot_file(tmp_path, sensors=sensors), noise=False)))
    imu, pose = log.other_series["tool_imu"], log.tool_pose
    assert isinstance(imu, ImuSeries)
    assert pose is not None
    second = np.gradient(np.gradient(pose.position, 5e-4, axis=0), 5e-4, axis=0)
    angle = 2 * np.arctan2(pose.orientation[:, 1], pose.orientation[:, 3])
    wanted = np.cos(angle) * second[:, 0] - np.sin(angle) * (second[:, 2] + 9.81)
    middle = slice(450, 1100)
    assert np.max(np.abs(imu.acceleration[middle, 0] - wanted[middle])) < 0.02  # type: ignore[index]
    assert np.ptp(wanted[middle]) > 1.0


def test_engines_measure_the_same(run: Experiment) -> None:
    functions = run.plant_model.functions(feed_through(2, run.sensor_timing.size))
    inputs = LoopInputs(reference=run.reference_signal[:80], noise=run.signals(1).measurement_errors.rows(0, 80))
    results = []
    for engine in ("machine_code", "virtual_machine"):
        kernel = compile_loop(functions, sample_time=run.sample_time, engine=engine)  # type: ignore[arg-type]
        start = delayed_start(
            run.plant_model.start(run.start_state, run.start_torque), np.zeros(0), run.start_torque, 0
        )
        results.append(kernel.run(start, 80, LoopInputs(inputs.reference, inputs.noise, gains=np.zeros(0))).further)
    assert np.max(np.abs(results[0] - results[1])) < 1e-9
    assert results[0].shape == (80, 9)


def test_a_force_at_the_tool_is_felt_one_sample_later(tmp_path: Path) -> None:
    robot = robot_file(tmp_path, "four_mass", {"tool_imu": {"acceleration": {"axes": ["x"]}}})
    step = [{"kind": "step", "at": "tool.tz", "start": 0.1, "amplitude": 8.0}]
    scenario = load_scenario("regulator_four_mass").with_values(
        {"robot": robot, "duration": 0.2, "disturbances": step, "noise": False}
    )
    imu = closed_loop(Experiment.prepare(scenario)).other_series["tool_imu"]
    assert isinstance(imu, ImuSeries)
    x = imu.acceleration[:, 0]  # type: ignore[index]
    assert x[200] == pytest.approx(0.0, abs=1e-9)
    assert x[201] == pytest.approx(1.53 / 220 * 8.0 / 0.02, rel=0.02)  # l_3 / n v / J_a3
