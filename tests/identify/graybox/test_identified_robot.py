from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.graybox.covariance import parameter_covariance
from flexros.identify.graybox.fit import fit
from flexros.identify.graybox.identified_robot import identified_robot, identified_yaml, write_identified_robot
from flexros.identify.graybox.problem import graybox_problem
from flexros.robot.robot import load_robot

if TYPE_CHECKING:
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot.robot import Robot
    from tests.identify.graybox.conftest import Measure

    Responses = tuple[FrequencyResponse, ...]


def test_written_robot_loads_with_values_sources_and_tolerances(
    e12: Robot, e12_names: list[str], noisy_e12: Responses, tmp_path: Path
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names, "LLS", "optimal")
    result = fit(problem, problem.scale.nominal * 1.1)
    covariance = parameter_covariance(problem, result)
    write_identified_robot(tmp_path / "mine.yaml", e12, result, covariance, "3 positions")
    robot = load_robot(tmp_path / "mine.yaml")
    for place, name in enumerate(e12_names):
        parameter = robot.parameters[name]
        assert parameter.value == result.values[place]
        assert parameter.tolerance == pytest.approx(covariance.relative[place], rel=1e-3)
        assert parameter.source == "identified by FlexROS, LLS with optimal weights, 3 positions"


@pytest.mark.slow
def test_everything_else_stays(six_axis: Robot, six_axis_responses: Responses) -> None:
    problem = graybox_problem(six_axis, six_axis_responses, ["body_3.ry.stiffness", "motor_2.viscous_friction"])
    result = fit(problem)
    robot = identified_robot(six_axis, result, parameter_covariance(problem, result))
    assert robot.parameters["body_3.ry.stiffness"].source.startswith("identified by FlexROS")
    for name, parameter in six_axis.parameters.items():
        if name not in problem.names:
            assert robot.parameters[name] == parameter
    assert robot.spec.unknown_parameters == six_axis.spec.unknown_parameters
    np.testing.assert_array_equal(robot.home, six_axis.home)
    assert robot.spec.outputs == six_axis.spec.outputs


def test_parameters_may_keep_what_the_robot_had(e12: Robot, e12_names: list[str], noisy_e12: Responses) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    result = fit(problem)
    robot = identified_robot(e12, result, parameter_covariance(problem, result), kept=e12_names[:2])
    for place, name in enumerate(e12_names):
        known = e12.parameters[name].value if place < 2 else result.values[place]
        assert robot.parameters[name].value == known
    assert robot.parameters[e12_names[0]] == e12.parameters[e12_names[0]]


def test_file_says_what_the_robots_own_file_says_one_quantity_per_line(
    e12: Robot, e12_names: list[str], noisy_e12: Responses
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    result = fit(problem)
    text = identified_yaml(e12, result, parameter_covariance(problem, result))
    assert "    mass: {value: 100.0, unit: kg}\n" in text
    assert "        spring: {value: 99" in text or "        spring: {value: 100" in text
    assert "cubic" not in text


def test_value_the_file_leaves_out_is_added_with_the_tolerance_of_its_vector(e12: Robot, measured: Measure) -> None:
    friction = e12.with_values({"motor_1.viscous_friction": 25.0, "body_2.center_of_mass.x": 0.52})
    responses = measured(friction, np.array([[0.0, 0.3], [0.2, 1.2]]), np.linspace(1.0, 40.0, 50), noise=1e-3)
    names = ["motor_1.viscous_friction", "body_2.center_of_mass.x", "body_2.center_of_mass.z"]
    problem = graybox_problem(e12, responses, names)
    result = fit(problem)
    covariance = parameter_covariance(problem, result)
    robot = identified_robot(e12, result, covariance)
    for name, value in zip(names, result.values):
        assert robot.parameters[name].value == value
    assert robot.parameters["motor_1.viscous_friction"].tolerance == pytest.approx(covariance.relative[0], rel=1e-3)
    both = robot.parameters["body_2.center_of_mass.z"].tolerance  # of the vector: length of deviation over length
    length = np.linalg.norm(covariance.relative[1:] * result.values[1:]) / np.linalg.norm(result.values[1:])
    assert both == pytest.approx(min(length, 10.0), rel=1e-3)


def test_nonlinear_spring_keeps_its_law(measured: Measure) -> None:
    robot = load_robot("four_mass")
    responses = measured(robot, np.array([[0.0]]), np.linspace(1.0, 60.0, 40), noise=1e-3)
    problem = graybox_problem(robot, responses, ["body_1.rz.stiffness", "body_2.rz.stiffness"])
    result = fit(problem, np.array([1.2, 1.1]) * problem.scale.nominal)
    identified = identified_robot(robot, result, parameter_covariance(problem, result))
    spring, nominal = (each.spec.bodies[0].directions["rz"].spring for each in (identified, robot))
    assert not isinstance(spring, str)
    assert not isinstance(nominal, str)
    assert spring.piecewise_linear is not None
    assert nominal.piecewise_linear is not None
    ratio = np.array(spring.piecewise_linear.slopes) / np.array(nominal.piecewise_linear.slopes)
    np.testing.assert_allclose(ratio, result.values[0])
    assert spring.piecewise_linear.source.startswith("identified by FlexROS")


def test_folder_that_is_not_there_is_refused(
    e12: Robot, e12_names: list[str], noisy_e12: Responses, tmp_path: Path
) -> None:
    problem = graybox_problem(e12, noisy_e12, e12_names)
    result = fit(problem)
    covariance = parameter_covariance(problem, result)
    with pytest.raises(InputError, match=r"the identified robot cannot be written to .*nowhere.*; give another file"):
        write_identified_robot(tmp_path / "nowhere" / "mine.yaml", e12, result, covariance)
    assert list(tmp_path.iterdir()) == []
