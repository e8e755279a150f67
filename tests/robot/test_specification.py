"""Error messages of invalid robot files."""

from __future__ import annotations

import copy
import math
from pathlib import Path
from typing import Any

import pytest

from flexros.config.yaml_file import read_yaml
from flexros.errors import InputError
from flexros.robot import load_robot, robot_from_data, robot_names
from flexros.robot.robot import LIBRARY


@pytest.fixture
def e12_data() -> dict[str, Any]:
    return copy.deepcopy(read_yaml(LIBRARY / "e12.yaml"))


def _refused(data: dict[str, Any]) -> str:
    with pytest.raises(InputError) as caught:
        robot_from_data(data, "my_robot.yaml")
    text = str(caught.value)
    assert text.startswith("my_robot.yaml")
    assert "\n" not in text
    return text


def test_built_in_robots_of_the_contract() -> None:
    contract = {"two_mass", "elbow", "e12", "four_mass", "four_mass_linear", "six_axis", "emps"}
    assert contract <= set(robot_names())


def test_every_built_in_value_is_declared_exact() -> None:
    for name in robot_names():
        assert {p.tolerance for p in load_robot(name).parameters.values()} == {0.0}, name


def test_gravity_is_exact_unless_it_states_a_tolerance(e12_data: dict[str, Any]) -> None:
    e12_data["defaults"]["tolerance"] = 0.03
    e12_data["gravity"] = {"value": [0, 0, -9.81], "unit": "m/s2"}
    parameters = robot_from_data(e12_data, "my_robot.yaml").parameters
    assert parameters["body_1.mass"].tolerance == 0.03
    assert parameters["gravity.z"].tolerance == 0.0
    e12_data["gravity"]["tolerance"] = 0.001
    assert robot_from_data(e12_data, "my_robot.yaml").parameters["gravity.z"].tolerance == 0.001


def test_lengths_may_have_a_tolerance_of_their_own(e12_data: dict[str, Any]) -> None:
    e12_data["defaults"] |= {"tolerance": 0.5, "length_tolerance": 0.003}
    parameters = robot_from_data(e12_data, "my_robot.yaml").parameters
    tolerances = {name: parameters[name].tolerance for name in ("body_1.length.z", "body_1.center_of_mass.z")}
    assert tolerances == {"body_1.length.z": 0.003, "body_1.center_of_mass.z": 0.5}


def test_lengths_have_the_tolerance_of_all_where_none_is_stated_for_them(e12_data: dict[str, Any]) -> None:
    e12_data["defaults"]["tolerance"] = 0.05
    assert robot_from_data(e12_data, "my_robot.yaml").parameters["body_1.length.z"].tolerance == 0.05


def test_unknown_robot_offers_the_nearest() -> None:
    with pytest.raises(InputError, match="unknown robot 'e21'.*did you mean 'e12'.*allowed are e12, .*elbow"):
        load_robot("e21")


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read .*nothing\.yaml: No such file"):
        load_robot(tmp_path / "nothing.yaml")


def test_broken_yaml_names_the_line(tmp_path: Path) -> None:
    file = tmp_path / "broken.yaml"
    file.write_text("name: a\nbodies: [1, 2\nx: }\n")
    with pytest.raises(InputError, match=r"broken\.yaml, line 3: broken YAML"):
        load_robot(file)


def test_unknown_key_offers_the_nearest(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][1]["masss"] = 3
    assert "unknown key 'bodies[1].masss': did you mean 'mass'?" in _refused(e12_data)


def test_negative_mass(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["mass"] = -1
    text = _refused(e12_data)
    assert "bodies[0].mass" in text
    assert "is -1 kg, but must be at least 0 kg" in text


def test_wrong_unit(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["mass"] = {"value": 100, "unit": "g"}
    assert "has unit 'g', but the unit here is 'kg'" in _refused(e12_data)


def test_wrong_unit_of_a_spring(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][2]["directions"]["ry"]["spring"] = {"value": 1e5, "unit": "N/m"}
    assert "has unit 'N/m', but the unit here is 'Nm/rad'" in _refused(e12_data)


@pytest.mark.parametrize(
    ("key", "given", "message"),
    [
        ("torque_limit", {"value": 0.35, "unit": "kN"}, "has unit 'kN', but the unit here is 'Nm'"),
        ("speed_limit", {"value": 3, "unit": "rpm"}, "has unit 'rpm', but the unit here is 'rad/s'"),
        ("encoder_noise", {"value": 1, "unit": "um"}, "has unit 'um', but the unit here is 'rad'"),
        ("viscous_friction", {"value": 1, "unit": "N s/m"}, "has unit 'N s/m', but the unit here is 'Nm s/rad'"),
        ("inertia", {"value": 100, "unit": "kg"}, "has unit 'kg', but the unit here is 'kg m2'"),
    ],
)
def test_wrong_unit_at_a_motor_is_named(
    e12_data: dict[str, Any], key: str, given: dict[str, Any], message: str
) -> None:
    e12_data["bodies"][0]["directions"]["ry"]["motor"][key] = given
    assert f"key 'bodies[0]': directions.ry.motor.{key} {message}" in _refused(e12_data)


def test_units_of_a_linear_motor_are_those_of_a_translation() -> None:
    data = copy.deepcopy(read_yaml(LIBRARY / "emps.yaml"))
    motor = data["bodies"][0]["directions"]["tx"]["motor"]
    motor["inertia"] = {"value": 1, "unit": "kg"}
    assert robot_from_data(data, "emps").parameters["motor_1.inertia"].value == 1
    motor["inertia"] = {"value": 1, "unit": "kg m2"}
    assert "directions.tx.motor.inertia has unit 'kg m2', but the unit here is 'kg'" in _refused(data)


@pytest.mark.parametrize(("key", "value"), [("torque_limit", -5), ("speed_limit", 0), ("gear_ratio", 0)])
def test_limits_and_gear_ratio_are_positive(e12_data: dict[str, Any], key: str, value: float) -> None:
    e12_data["bodies"][0]["directions"]["ry"]["motor"][key] = value
    text = _refused(e12_data)
    assert f"bodies[0].directions.ry.motor.{key}" in text
    assert f"is {value}, but must be positive" in text


def test_wrong_unit_of_a_product_of_inertia(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["inertia"]["xy"] = {"value": 1, "unit": "g mm2"}
    assert "has unit 'g mm2', but the unit here is 'kg m2'" in _refused(e12_data)


def test_wrong_unit_of_the_friction_of_a_body(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["viscous_friction"] = {"value": 1, "unit": "N s/m"}
    assert "has unit 'N s/m', but the unit here is 'Nm s/rad'" in _refused(e12_data)


def test_wrong_unit_of_the_tool_noise(e12_data: dict[str, Any]) -> None:
    e12_data["sensors"]["tool_noise"] = {"value": 20, "unit": "um"}
    assert "has unit 'um', but the unit here is 'm'" in _refused(e12_data)


def test_unit_of_the_encoder_noise_is_that_of_the_motors(e12_data: dict[str, Any]) -> None:
    e12_data["sensors"]["encoder_noise"] = {"value": 1e-6, "unit": "m"}
    text = _refused(e12_data)
    assert "sensors.encoder_noise, which also applies to the motor of body_1.ry, has unit 'm'" in text
    for body in e12_data["bodies"][:2]:
        body["directions"]["ry"]["motor"]["encoder_noise"] = {"value": 2e-6, "unit": "rad"}
    assert robot_from_data(e12_data, "own").encoder_noise.tolist() == [2e-6, 2e-6]


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_not_a_finite_number(e12_data: dict[str, Any], value: float) -> None:
    e12_data["bodies"][2]["directions"]["ry"]["damper"] = value
    text = _refused(e12_data)
    assert "bodies[2].directions.ry.damper" in text
    assert "finite" in text


def test_non_physical_inertia(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["directions"]["rz"] = {"spring": 1e5}
    del e12_data["home"]
    assert "violate the triangle inequality" in _refused(e12_data)


def test_disconnected_chain(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][2]["parent"] = "body_1"
    assert "bodies[2] names parent 'body_1'" in _refused(e12_data)


def test_motor_behind_a_flexible_gear_needs_inertia(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["directions"]["ry"]["motor"] = {"inertia": 0}
    assert "motor of body_1.ry has inertia 0" in _refused(e12_data)


def test_motor_that_nothing_connects(e12_data: dict[str, Any]) -> None:
    gear = e12_data["bodies"][0]["directions"]["ry"]
    gear["spring"], gear["damper"] = 0, 0
    assert "the chain is disconnected" in _refused(e12_data)


def test_two_motors_on_a_body(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][0]["directions"]["rz"] = {"spring": 1e5, "motor": {"inertia": 1}}
    assert "at most one actuated direction" in _refused(e12_data)


def test_last_body_without_inertia(e12_data: dict[str, Any]) -> None:
    e12_data["bodies"][2]["mass"] = 0
    e12_data["bodies"][2]["inertia"] = {}
    assert "nothing behind body_3.ry has mass or inertia" in _refused(e12_data)


def test_wrong_number_of_slopes(e12_data: dict[str, Any]) -> None:
    spring = {"piecewise_linear": {"knots": [0.1, 0.2], "slopes": [1, 2]}}
    e12_data["bodies"][2]["directions"]["ry"]["spring"] = spring
    assert "has 2 knots and 2 slopes" in _refused(e12_data)


def test_unknown_output(e12_data: dict[str, Any]) -> None:
    e12_data["controlled"] = "hand"
    assert "controlled is 'hand', but outputs has only tool, joints" in _refused(e12_data)


def test_unknown_parameter_offers_the_nearest() -> None:
    with pytest.raises(
        InputError, match="unknown parameter of robot e12 'body_3.mas' in load: did you mean 'body_3.mass'"
    ):
        load_robot("e12").with_values({"body_3.mas": 1.0}, "load")


def test_changed_value_is_validated() -> None:
    with pytest.raises(InputError, match="is -5 kg"):
        load_robot("e12").with_values({"body_3.mass": -5.0}, "--load")


@pytest.mark.parametrize("pose", [[0, 0], [0, 0, 0, 0]])
def test_pose_of_wrong_size(pose: list[float]) -> None:
    with pytest.raises(InputError, match="robot e12 has 3 \\(body_1.ry, body_2.ry, body_3.ry\\)"):
        load_robot("e12").forward_kinematics(pose)


def test_pose_with_nan() -> None:
    with pytest.raises(InputError, match="must be finite"):
        load_robot("e12").forward_kinematics([0, math.nan, 0])


def test_every_parameter_can_be_replaced() -> None:
    robot = load_robot("six_axis")
    for name, parameter in robot.parameters.items():
        if name.endswith(("stiffness", "mass", "inertia.yy", "length.x", "motor_2.inertia", "gravity.z")):
            changed = robot.with_values({name: 1.01 * parameter.value + 0.001})
            assert changed.parameters[name].value == pytest.approx(1.01 * parameter.value + 0.001)


def test_scaling_a_nonlinear_spring() -> None:
    robot = load_robot("four_mass").with_values({"body_1.rz.stiffness": 2.0})
    spring = robot.spec.bodies[0].directions["rz"].spring
    assert spring.piecewise_linear.slopes[0] == pytest.approx(33.4)


def test_model_hash_changes_with_a_value() -> None:
    robot = load_robot("e12")
    assert robot.with_values({"body_3.mass": 190.0}).model_hash != robot.model_hash
    assert load_robot("e12").model_hash == robot.model_hash


def test_body_without_free_direction_rides_on_the_one_before(e12_data: dict[str, Any]) -> None:
    """Splitting a link in two rigidly joined halves changes nothing."""
    whole = robot_from_data(e12_data, "whole")
    split = copy.deepcopy(e12_data)
    first = split["bodies"][0]
    half = {"mass": 50, "center_of_mass": [0.25, 0, 0], "inertia": {"yy": 5 / 2 - 50 * 0.25**2}, "length": [0.5, 0, 0]}
    split["bodies"][0] = {**half, "directions": first["directions"]}
    split["bodies"].insert(1, half)
    split["outputs"]["joints"] = {"coordinates": ["body_1.ry", "body_3.ry"]}
    split["bodies"][0]["inertia"] = split["bodies"][1]["inertia"] = {"yy": 0}
    split["bodies"][1]["inertia"] = {"yy": 0}
    merged = robot_from_data(split, "split")
    assert merged.n_arm == whole.n_arm
    lumped = 2 * 50 * 0.25**2  # what the two point masses have about the common centre
    reference = whole.with_values({"body_1.inertia.yy": lumped})
    import numpy as np

    q = [0.2, 0.4, -0.1]
    np.testing.assert_allclose(
        np.asarray(merged.model.arm_inertia(q, [])), np.asarray(reference.model.arm_inertia(q, [])), rtol=1e-12
    )
