"""Locations of gaps of the simulated plant, with the predictor of the diagnosis."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.prediction.predicted_log import PredictedLog
from flexros.gap.prediction.predictor import Predictor
from flexros.gap.settings import WhereSettings
from flexros.gap.signatures.signature_data import SignatureData
from flexros.gap.signatures.torque_over_speed import TorqueOverSpeed
from flexros.gap.signatures.torsion_over_torque import TorsionOverTorque
from flexros.gap.where.find import where
from flexros.prediction.observer import observer_gain
from flexros.record.record import Record
from flexros.robot import Robot, load_robot
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

FEW = WhereSettings(realisations=60)


@pytest.fixture(scope="module")
def elbow() -> Robot:
    return load_robot("elbow")


def evidence(robot: Robot, *effects: str) -> SignatureData:
    """Run the diagnosis experiment on a robot with effects and predict it without."""
    settings = {"robot": robot.name, "plant.effects": list(effects), "diagnosis.length": 12, "seed": 7}
    experiment = Experiment.prepare(load_scenario("diagnosis").with_values(settings))
    log = closed_loop(experiment)
    position, torque = log.joint_states.position, log.joint_commands.effort
    assert position is not None
    assert torque is not None
    record = Record("test", robot.sample_time, position, torque, np.ones(len(position), dtype=bool))
    observer = observer_gain(robot, robot.sample_time, 2e-3, robot.encoder_noise, experiment.start)
    predictor = Predictor(RobotWithEffects(robot, ()), (), Tolerance(), robot.sample_time)
    start = robot.equilibrium(experiment.start, motor_position=position[0])
    found = predictor.predict(np.zeros((0, 1)), record, observer, start, record_states=True)
    assert found.states is not None
    states = found.states[:, : 2 * robot.n_coordinates, 0]
    return SignatureData(
        robot, record, observer, PredictedLog(found.innovation[:, :, 0], observer.spread, states, 1000)
    )


def test_no_location_of_a_nominal_robot_is_reported(elbow: Robot) -> None:
    log = evidence(elbow)
    assert where(log.before, log.record, elbow, 1, settings=FEW).locations == ()


def test_friction_shows_at_its_motor_and_over_speed(elbow: Robot) -> None:
    log = evidence(elbow, "coulomb_friction@motor_2:level=10")
    found = where(log.before, log.record, elbow, 1, settings=FEW)
    assert found.locations[0].joint == "motor_2"
    assert found.locations[0].p_value < 0.02
    assert "reversal" in {location.regime for location in found.locations if location.joint == "motor_2"}
    picture = TorqueOverSpeed().picture(log, "motor_2")
    assert picture is not None
    curve = picture.series["before"]
    fast = np.abs(curve.x) > 0.1
    assert np.median(-curve.y[fast] * np.sign(curve.x[fast])) == pytest.approx(10, rel=0.1)


def test_backlash_shows_at_changes_of_the_gear_torque_and_as_a_step() -> None:
    robot = load_robot("four_mass_linear")
    log = evidence(robot, "backlash@motor_1:gap=0.01")
    locations = where(log.before, log.record, robot, 1, settings=FEW).locations
    shares = {location.regime: location.share for location in locations}
    assert shares["gear torque reversal"] > 0.5
    picture = TorsionOverTorque().picture(log, "motor_1")
    assert picture is not None
    curve = picture.series["rising torque"]
    loaded = np.abs(curve.x) > 2
    assert np.median(curve.y[loaded] * np.sign(curve.x[loaded])) == pytest.approx(0.005, rel=0.3)
