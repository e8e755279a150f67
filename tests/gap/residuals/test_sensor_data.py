"""Further sensors as a fit sees them: whitened errors without offset, doubts, deflections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.checked_log import checked_log
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.residuals.sensor_channel import SensorChannel
from flexros.gap.settings import DiagnosisSettings
from flexros.logs.time_series import JointSeries
from flexros.record.record import Record
from flexros.robot import Robot, load_robot
from flexros.robot.quantity import Quantity
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario
from tests.gap.diagnosis_logs import ROBOT, predictor_of
from tests.gap.sensors.sensor_logs import NOISE, sensed, sensed_data, truth_of

NOTHING = np.zeros((0, 1))
SENSORS = ("link position", "joint torque", "tool acceleration", "link speed")


def residual_of(data: FitData) -> np.ndarray:
    """Weighted errors of the sensors under the nominal model."""
    assert data.sensors is not None
    return data.residuals(predictor_of(), NOTHING)[-data.sensors.size :, 0]


def channel_of(data: FitData) -> SensorChannel:
    assert data.sensors is not None
    return data.sensors.channels[0]


def with_values(record: Record, values: np.ndarray) -> Record:
    return replace(record, sensors=(replace(record.sensors[0], values=values),))


@pytest.mark.parametrize("every", [1, 7])
@pytest.mark.parametrize("sensor", SENSORS)
def test_errors_without_a_gap_are_white_of_variance_one(sensor: str, every: int) -> None:
    data = sensed_data(sensed(sensors=(sensor,), every=every))
    residual = residual_of(data)
    n = len(residual)
    assert channel_of(data).noise == pytest.approx(NOISE[sensor], rel=3 * data.floor_error / 2)
    assert np.mean(residual**2) == pytest.approx(1.0, abs=4 * np.hypot(np.sqrt(2 / n), data.floor_error))
    for lag in (1, 2, 50):
        assert abs(np.mean(residual[lag:] * residual[:-lag])) < 4 / np.sqrt(n)
    slow = np.abs(np.fft.rfft(residual)[1:40]) ** 2 / n
    assert slow.mean() < 1.0 + 4 / np.sqrt(len(slow))


def test_errors_of_motors_stay_as_they_are() -> None:
    record = sensed()
    both, motors = sensed_data(record), sensed_data(replace(record, sensors=()))
    assert both.sensors is not None
    n, late = record.n_samples, 2 * both.gain.settling
    residuals = [data.residuals(predictor_of(), NOTHING)[:, 0] for data in (both, motors)]
    np.testing.assert_allclose(residuals[0][late:n], residuals[1][late:n])
    assert len(residuals[0]) == n + both.sensors.size == both.used.size
    assert both.initial_state_errors is not None
    assert both.n_values == n + both.sensors.size - 1 - both.initial_state_errors.number


def test_an_offset_is_projected_out() -> None:
    record = sensed(sensors=("joint torque",))
    moved = with_values(record, record.sensors[0].values + 100.0)
    np.testing.assert_allclose(residual_of(sensed_data(moved)), residual_of(sensed_data(record)), atol=1e-2)


def test_noise_that_the_robot_file_declares_is_certain() -> None:
    record = sensed(sensors=("joint torque",))
    sensors = ROBOT.spec.sensors.model_copy(update={"joint_torque_noise": Quantity(value=0.1, unit="Nm")})
    declared = Robot(ROBOT.spec.model_copy(update={"sensors": sensors}), "test")
    shown, taken = (sensed_data(record, RobotWithEffects(robot, ())) for robot in (ROBOT, declared))
    assert shown.floor_error == pytest.approx(np.sqrt(2 * 2.63 / record.n_samples), rel=1e-6)
    assert (channel_of(taken).noise, taken.floor_error) == (0.1, 0.0)


def test_of_link_and_deflection_the_one_with_less_noise_is_compared() -> None:
    """A strain gauge is added to the position that the encoder of the motor shows, with the noise of that encoder."""
    record, states = sensed(), truth_of().states[:, :, 0]
    assert not channel_of(sensed_data(record)).deflection
    sensor = record.sensors[0]
    assert sensor.motor is not None
    deflection = states[:, ROBOT.gear_rows[0]] - states[:, ROBOT.motor_rows[0]]
    noise = 1e-6 * np.random.default_rng(3).standard_normal(len(deflection))
    data = sensed_data(with_values(record, sensor.motor + deflection + noise))
    channel = channel_of(data)
    assert channel.deflection
    assert channel.noise == pytest.approx(1e-6, rel=0.05)
    assert np.mean(residual_of(data) ** 2) == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("sensor", ["joint torque", "link position"])
@pytest.mark.parametrize(("factor", "told"), [(-1.0, "opposite"), (57.3, "its unit"), (1e-3, "its unit")])
def test_a_sensor_of_wrong_sign_or_unit_is_left_out_and_told(sensor: str, factor: float, told: str) -> None:
    record = sensed(sensors=(sensor,))
    data = sensed_data(with_values(record, factor * record.sensors[0].values))
    assert data.sensors is None
    assert any(told in text and sensor in text and "motor_1" in text for text in data.record.warnings)


def test_a_gauge_of_wrong_sign_is_told_by_its_deflection() -> None:
    record = sensed("stiffness_error@body_1.rz:relative=0.3")
    sensor = record.sensors[0]
    assert sensor.motor is not None
    data = sensed_data(with_values(record, 2 * sensor.motor - sensor.values))
    assert data.sensors is None
    assert any("opposite" in text for text in data.record.warnings)


def test_a_gauge_of_wrong_sign_is_told_where_the_model_is_far_off() -> None:
    """Three times too stiff, the model predicts other vibrations and a third of the deflection."""
    record = sensed(seed=2)
    stiffness = 3.0 * ROBOT.parameters["body_1.rz.stiffness"].value
    stiff = RobotWithEffects(ROBOT.with_values({"body_1.rz.stiffness": stiffness}), ())
    sensor = record.sensors[0]
    assert sensor.motor is not None
    right, wrong = sensed_data(record, stiff), sensed_data(with_values(record, 2 * sensor.motor - sensor.values), stiff)
    assert right.sensors is not None
    assert wrong.sensors is None
    assert any("opposite" in text for text in wrong.record.warnings)


def test_a_sensor_that_follows_something_else_is_told_and_kept() -> None:
    record = sensed(sensors=("joint torque",))
    values = 5.0 * np.sin(np.arange(record.n_samples) * 7.7e-3)
    data = sensed_data(with_values(record, values))
    assert data.sensors is not None
    assert any("hardly follows" in text for text in data.record.warnings)


def test_values_between_samples_are_interpolated() -> None:
    record = sensed(sensors=("link speed",))
    sensor = record.sensors[0]
    half = replace(sensor, time=sensor.time[:-1] + 0.5 * record.sample_time, values=sensor.values[:-1])
    channel = channel_of(sensed_data(replace(record, sensors=(half,))))
    outputs = np.arange(record.n_samples, dtype=float)[:, None]
    found = channel.predicted(outputs, outputs, np.arange(record.n_samples))
    np.testing.assert_allclose(found[:, 0], np.arange(record.n_samples - 1) + 0.5)


def test_real_machines_have_tolerance_in_scale_and_clock() -> None:
    record = sensed(sensors=("joint torque",))
    real = replace(record, imported=True, simulated=False)
    scaled = with_values(real, 1.04 * real.sensors[0].values)
    data, plain = sensed_data(scaled), sensed_data(real)
    assert channel_of(data).noise > 0.04 * np.std(real.sensors[0].values)
    assert channel_of(data).unknown.shape[1] == 3
    assert np.sum(residual_of(data) ** 2) < 1.1 * np.sum(residual_of(plain) ** 2) + 5


@pytest.mark.slow
def test_every_joint_has_the_channels_of_its_own_sensors() -> None:
    scenario = load_scenario("diagnosis").with_values({"robot": "elbow", "diagnosis.length": 10.0}, "test")
    log, elbow = closed_loop(Experiment.prepare(scenario)), load_robot("elbow")
    states, commands = log.joint_states, log.joint_commands
    assert states.position is not None
    assert commands is not None
    assert commands.effort is not None
    noise = np.random.default_rng(1).normal(size=states.position.shape)
    position, effort = states.position + 1e-4 * noise, commands.effort + 0.1 * noise
    position[:, 1], effort[:, 0] = np.nan, np.nan
    link = JointSeries(states.stamp, states.names, position=position, effort=effort)
    record = checked_log(replace(log, other_series={"link_states": link}), elbow, name="log")
    data = fit_data(record, RobotWithEffects(elbow, ()), DiagnosisSettings())
    assert data.sensors is not None
    assert data.sensors.wanted == (("link position", 0), ("joint torque", 1))
