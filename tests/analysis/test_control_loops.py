"""Linear loops of laws with further sensors, against other ways to the same loop."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.control_loops import control_loops, rest_signals
from flexros.benchmark.controllers import load_controller
from flexros.benchmark.demands import StabilityDemands
from flexros.benchmark.models import benchmark_robot
from flexros.control.design.closed_loop import closed_loops
from flexros.control.design.methods.base import DesignProblem
from flexros.control.linear_controller import LinearController, linear_controller
from flexros.control.pid import Pid
from flexros.control.state_feedback import StateFeedback
from flexros.control.torque_feedback import TorqueFeedback
from flexros.errors import InputError
from flexros.robot import Robot, load_robot
from flexros.robot.robot import robot_from_data
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario, scenario_names
from flexros.simulate.sensor_timing import SensorTiming

OF_ELBOW = [name for name in scenario_names() if name.startswith("elbow_")]


def with_link_sensors(name: str, **timing: float) -> Robot:
    data = load_robot(name).spec.model_dump()
    data["sensors"]["link"] = {"position": {}, "torque": {}, **timing}
    return robot_from_data(data, f"{name} with link sensors")


@pytest.mark.parametrize("name", OF_ELBOW)
def test_every_law_of_the_elbow_holds_it_at_rest_and_is_stable_there(name: str) -> None:
    experiment = Experiment.prepare(load_scenario(name))
    law, context = experiment.scenario.controller, experiment.loop_context
    pose = np.array([0.3, 0.5])
    r, y = rest_signals(context, pose)
    state = context.robot.equilibrium(pose)
    function, gains = law.function(context), law.gains(context)
    command, memory = function(law.initial_state(context), r, y, gains)
    command, _ = function(memory, r, y, gains)
    close = 1e-2 if law.kind == "computed_torque" else 1e-6  # it takes gravity at the motors, not at the links
    assert command.full().ravel() == pytest.approx(context.robot.holding_torque(state), rel=close)
    problem = DesignProblem.of(experiment.nominal, [pose], sample_time=experiment.sample_time)
    (loop,) = control_loops(law, problem)
    for entry in loop.margins:
        assert entry.largest_eigenvalue < 1.0
        assert entry.gain_up > 1.5
        assert 1.0 < entry.sensitivity < 3.0
        assert entry.settling < 1.0


def test_loop_with_the_tool_acceleration_has_the_eigenvalues_of_the_benchmark() -> None:
    given = load_controller("acceleration_1")
    robot = benchmark_robot(given.sensors)
    wanted = StabilityDemands(robot).eigenvalues(given.nominal, nominal_only=True)["stability, nominal"][0]
    (loop,) = control_loops(given.nominal, DesignProblem.of(robot))
    assert max(entry.largest_eigenvalue for entry in loop.margins) == pytest.approx(wanted, rel=1e-12)


def test_delay_margin_with_a_link_encoder_is_where_the_loop_becomes_unstable() -> None:
    robot = with_link_sensors("two_mass")
    gains = {"motor_position": 5e4, "motor_speed": 900.0, "link_position": -1e4, "link_speed": 200.0}
    law = StateFeedback.model_validate(gains)
    margin = control_loops(law, DesignProblem.of(robot))[0].margins[0].delay
    for share, stable in ((0.97, True), (1.03, False)):
        later = control_loops(law, DesignProblem.of(robot, delay=robot.delay + share * margin))[0]
        assert bool(later.margins[0].largest_eigenvalue < 1.0) is stable


def test_late_sensor_has_the_loop_of_a_controller_that_gets_it_late() -> None:
    robot = with_link_sensors("two_mass", delay=2e-3)
    law = TorqueFeedback(kp=5e4, kd=900.0, kt=0.3)
    problem = DesignProblem.of(robot)
    (loop,) = control_loops(law, problem)
    context = law.context(robot, problem.sample_time)
    timing = SensorTiming.of(robot.further_sensors, problem.sample_time)
    behind = timing.behind(law.function(context), robot.n_motors)

    class Late(TorqueFeedback):
        def function(self, context: object) -> object:
            return behind

        def state_size(self, context: object) -> int:
            return int(behind.numel_in(0))

    late = linear_controller(Late.model_validate(law.model_dump()), context, rest_signals(context, robot.home))
    immediate = control_loops(law, DesignProblem.of(with_link_sensors("two_mass")))[0]
    columns = [0, 2]  # the joint torque is the second of the further sensors
    used = LinearController(
        late.from_state, late.from_reference, late.from_measured[:, columns],
        late.state_step, late.state_reference, late.state_measured[:, columns],
    )  # fmt: skip
    other = np.linalg.eigvals(closed_loops(immediate.plants, used)[0])
    own = np.linalg.eigvals(closed_loops(loop.plants, loop.controller)[0])
    soon = np.linalg.eigvals(closed_loops(immediate.plants, immediate.controller)[0])
    largest, expected, without = (np.sort(np.abs(each))[-4:] for each in (own, other, soon))
    assert largest == pytest.approx(expected, rel=1e-6)
    assert np.max(np.abs(largest - without)) > 1e-4


def test_linear_law_has_one_loop_for_all_poses_and_a_model_based_one_has_one_each() -> None:
    robot = load_robot("elbow")
    problem = DesignProblem.of(robot, [np.array([0.0, 0.3]), np.array([0.5, 1.2])])
    (one,) = control_loops(Pid(kp=1e5, kd=6e3), problem)
    assert len(one.plants) == 2
    law = load_scenario("elbow_computed_torque").controller
    loops = control_loops(law, problem)
    assert [loop.plants.labels for loop in loops] == [("elbow pose 1",), ("elbow pose 2",)]
    assert loops[0].margins[0].gain_up != pytest.approx(loops[1].margins[0].gain_up, rel=1e-3)


def test_sensor_that_shows_the_torque_of_a_rigid_motor_at_once_is_refused() -> None:
    data = load_robot("two_mass").spec.model_dump()
    data["bodies"][0]["directions"]["rz"]["spring"] = "rigid"
    data["sensors"]["link"] = {"torque": {}}
    robot = robot_from_data(data, "rigid")
    with pytest.raises(InputError, match="joint_torque"):
        control_loops(TorqueFeedback(kp=5e4, kd=900.0, kt=0.3), DesignProblem.of(robot))
