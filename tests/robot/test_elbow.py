"""The elbow against equations 3.25 to 3.38; the thesis' (x, y) plane is (x, z) here."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.robot.inverse_kinematics import two_link_elbow
from flexros.robot.robot import LIBRARY

G = 9.81


@pytest.fixture(scope="module")
def elbow() -> Robot:
    return load_robot("elbow")


@pytest.fixture(scope="module")
def numbers(elbow: Robot) -> dict[str, float]:
    value = {name: parameter.value for name, parameter in elbow.parameters.items()}
    return {
        "l1": value["body_1.length.z"],
        "l2": value["body_2.length.x"],
        "m1": value["body_1.mass"],
        "m2": value["body_2.mass"],
        "xi1": value["body_1.center_of_mass.z"],
        "xi2": value["body_2.center_of_mass.x"],
        "j1": value["body_1.inertia.yy"],
        "j2": value["body_2.inertia.yy"],
    }


@pytest.mark.parametrize("q", [(0.0, 0.0), (0.3, -0.7), (-1.2, 0.9)])
def test_forward_kinematics(elbow: Robot, numbers: dict[str, float], q: tuple[float, float]) -> None:
    l1, l2 = numbers["l1"], numbers["l2"]
    expected = [l1 * np.sin(q[0]) + l2 * np.cos(sum(q)), l1 * np.cos(q[0]) - l2 * np.sin(sum(q))]
    np.testing.assert_allclose(elbow.forward_kinematics(q), expected, atol=1e-14)


@pytest.mark.parametrize("configuration", [1, -1])
def test_closed_form_inverse_kinematics(elbow: Robot, numbers: dict[str, float], configuration: int) -> None:
    point = np.array([0.7, 0.6])
    q = two_link_elbow(numbers["l1"], numbers["l2"], point, configuration)
    np.testing.assert_allclose(elbow.forward_kinematics(q), point, atol=1e-14)


@pytest.mark.parametrize("configuration", [1, -1])
def test_configuration_chooses_the_closed_form(elbow: Robot, numbers: dict[str, float], configuration: int) -> None:
    point = np.array([0.7, 0.6])
    closed = two_link_elbow(numbers["l1"], numbers["l2"], point, configuration)
    np.testing.assert_array_equal(elbow.inverse_kinematics(point, configuration=configuration), closed)
    np.testing.assert_array_equal(elbow.inverse_kinematics(point, near=closed + 0.1), closed)


def test_angles_stay_in_the_turn_of_the_pose_nearby(elbow: Robot) -> None:
    q = np.array([0.3, 0.4]) + 2 * np.pi * np.array([1, -1])
    point = elbow.forward_kinematics(q)
    np.testing.assert_allclose(elbow.inverse_kinematics(point, near=q + 0.2), q, atol=1e-12)


def _edited(**changes: Any) -> Robot:
    return robot_from_data({**read_yaml(LIBRARY / "elbow.yaml"), **changes}, "my.yaml")


@pytest.mark.parametrize("configuration", [1, -1])
def test_numerical_inverse_kinematics_stays_in_the_configuration(numbers: dict[str, float], configuration: int) -> None:
    point = np.array([0.7, 0.6])
    closed = two_link_elbow(numbers["l1"], numbers["l2"], point, configuration)
    numerical = _edited(inverse_kinematics="numerical")
    np.testing.assert_allclose(numerical.inverse_kinematics(point, near=closed + 0.1), closed, atol=1e-10)


def test_unknown_configuration_is_refused(elbow: Robot) -> None:
    with pytest.raises(InputError, match="configuration is 2, but robot elbow has the configurations 1 and -1"):
        elbow.inverse_kinematics([0.7, 0.6], configuration=2)


def test_configuration_where_there_is_no_closed_form_is_refused(elbow: Robot) -> None:
    with pytest.raises(InputError, match="output 'joints' of robot elbow, .*numerical.*give near"):
        elbow.inverse_kinematics([0.1, 0.2], output="joints", configuration=1)


def test_other_outputs_of_the_elbow_are_solved_numerically(elbow: Robot) -> None:
    np.testing.assert_allclose(elbow.inverse_kinematics([0.1, 0.2], output="joints"), [0.1, 0.2], atol=1e-12)


def test_elastic_direction_and_tool_point_are_part_of_the_links() -> None:
    data = read_yaml(LIBRARY / "elbow.yaml")
    data["bodies"][0]["directions"]["rz"] = {"spring": 1e5}
    data["bodies"][0]["inertia"] = data["bodies"][1]["inertia"] = {"xx": 4, "yy": 4, "zz": 4}
    robot = _edited(bodies=data["bodies"], tool={"position": [0.5, 0, 0]}, home=[0.2, 0, 0.3])
    q = robot.inverse_kinematics([0.7, 0.6], configuration=-1)
    assert q[1] == 0
    np.testing.assert_allclose(robot.forward_kinematics(q), [0.7, 0.6], atol=1e-12)


@pytest.mark.parametrize(
    "changes",
    [
        {"tool": {"position": [0.8, 0, 0.1]}},
        {"outputs": {"tool": {"pose": ["z", "x"]}}},
        {
            "bodies": read_yaml(LIBRARY / "elbow.yaml")["bodies"][:1],
            "outputs": {"tool": {"pose": ["x", "z"]}},
            "home": [0],
        },
        {"bodies": read_yaml(LIBRARY / "elbow.yaml")["bodies"][::-1]},
    ],
)
def test_chain_that_is_no_elbow_is_refused(changes: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="my.yaml: inverse_kinematics is 'two_link_elbow'"):
        _edited(**changes)


def test_out_of_reach_names_the_range(numbers: dict[str, float]) -> None:
    with pytest.raises(InputError, match="reach from 0.1 m to 1.7 m"):
        two_link_elbow(numbers["l1"], numbers["l2"], np.array([2.0, 0.0]), 1)


def test_robot_out_of_reach_names_the_range(elbow: Robot) -> None:
    with pytest.raises(InputError, match=r"the point \[2.0, 0.0\] is 2 m away.*reach from 0.1 m to 1.7 m"):
        elbow.inverse_kinematics([2.0, 0.0])


def test_numerical_out_of_reach_names_the_point() -> None:
    with pytest.raises(InputError, match=r"\[2.0, 0.0\] of output 'tool' is out of reach of robot elbow"):
        _edited(inverse_kinematics="numerical").inverse_kinematics([2.0, 0.0])


def test_inertia_matrix(elbow: Robot, numbers: dict[str, float]) -> None:
    q = (0.4, -0.6)
    n, s2 = numbers, np.sin(q[1])
    j12 = n["j2"] + n["m2"] * (n["xi2"] ** 2 - n["l1"] * n["xi2"] * s2)
    j11 = n["j1"] + n["m1"] * n["xi1"] ** 2 + n["j2"]
    j11 += n["m2"] * (n["l1"] ** 2 + n["xi2"] ** 2 - 2 * n["l1"] * n["xi2"] * s2)
    expected = [[j11, j12], [j12, n["j2"] + n["m2"] * n["xi2"] ** 2]]
    np.testing.assert_allclose(np.asarray(elbow.model.arm_inertia(q, [])), expected, rtol=1e-13)


def test_velocity_and_gravity_terms(elbow: Robot, numbers: dict[str, float]) -> None:
    q, v, n = (0.4, -0.6), (0.9, -1.3), numbers
    c2, s1, c12 = np.cos(q[1]), np.sin(q[0]), np.cos(sum(q))
    h = n["m2"] * n["l1"] * n["xi2"] * c2
    C = np.array([-h * (2 * v[0] * v[1] + v[1] ** 2), h * v[0] ** 2])
    gravity = -G * np.array(
        [n["m1"] * n["xi1"] * s1 + n["m2"] * (n["l1"] * s1 + n["xi2"] * c12), n["m2"] * n["xi2"] * c12]
    )
    torque = np.asarray(elbow.model.arm_inverse_dynamics(q, v, np.zeros(2), [])).ravel()
    np.testing.assert_allclose(torque, C + gravity, rtol=1e-12)


def test_jacobian(elbow: Robot, numbers: dict[str, float]) -> None:
    q = np.array([0.4, -0.6])
    l1, l2 = numbers["l1"], numbers["l2"]
    s12, c12 = np.sin(q.sum()), np.cos(q.sum())
    expected = [
        [l1 * np.cos(q[0]) - l2 * s12, -l2 * s12],
        [-l1 * np.sin(q[0]) - l2 * c12, -l2 * c12],
    ]
    _, slope = elbow.model.output_with_slope()(q)
    np.testing.assert_allclose(np.asarray(slope), expected, atol=1e-14)
