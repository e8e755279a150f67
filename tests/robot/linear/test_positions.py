"""Linear models of positions against the library's linearisation, and their slopes against differences."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import Robot, load_robot, robot_from_data
from flexros.robot.linear.linearise import linear_model
from flexros.robot.linear.positions import LinearisedPositions, linearise_positions

pytestmark = pytest.mark.slow

SPRINGS = ("body_2.rz.stiffness", "body_2.rz.damping", "body_3.rx.stiffness", "body_5.ry.damping")


def positions_of(robot: Robot, number: int = 2, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    home = robot.home[list(robot.gear_rows)]
    return home + 0.3 * rng.normal(size=(number, robot.n_motors))


@pytest.fixture(scope="module")
def six_axis() -> Robot:
    return load_robot("six_axis")


def loaded_elbow(spring: dict[str, object]) -> Robot:
    """Elbow under gravity whose first gear follows another law."""
    data = load_robot("elbow").spec.model_dump()
    data["bodies"][0]["directions"]["ry"]["spring"] = spring
    return robot_from_data(data, "test")


def test_matrices_are_those_of_the_linear_model(six_axis: Robot) -> None:
    motors = positions_of(six_axis)
    found = linearise_positions(six_axis, SPRINGS, motors)
    for place, held in enumerate(motors):
        rest = six_axis.equilibrium(motor_position=held)
        expected = linear_model(six_axis, rest[: six_axis.n_arm])
        np.testing.assert_allclose(found.coordinates[place], rest[: six_axis.n_coordinates], atol=1e-12)
        for name in ("mass", "damping", "stiffness"):
            matrix = getattr(expected, name)
            np.testing.assert_allclose(getattr(found, name)[place], matrix, atol=1e-9 * np.max(np.abs(matrix)))
        np.testing.assert_array_equal(np.eye(six_axis.n_coordinates)[found.motor_rows], expected.encoder)
        np.testing.assert_array_equal(expected.input, expected.encoder.T)


def test_values_change_matrices_and_rest_as_in_a_changed_robot(six_axis: Robot) -> None:
    motors = positions_of(six_axis, 1)
    values = np.array([six_axis.parameters[name].value for name in SPRINGS]) * [0.3, 2.0, 0.2, 3.0]
    found = linearise_positions(six_axis, SPRINGS, motors, values)
    changed = six_axis.with_values(dict(zip(SPRINGS, values, strict=True)))
    rest = changed.equilibrium(motor_position=motors[0])
    nominal = six_axis.equilibrium(motor_position=motors[0])
    np.testing.assert_allclose(found.coordinates[0], rest[: six_axis.n_coordinates], atol=1e-12)
    assert np.max(np.abs(rest - nominal)) > 1e-5  # gravity bends softer springs further
    expected = linear_model(changed, rest[: six_axis.n_arm])
    np.testing.assert_allclose(found.stiffness[0], expected.stiffness, atol=1e-9 * np.max(expected.stiffness))


def at(robot: Robot, names: tuple[str, ...], found: LinearisedPositions, theta: np.ndarray) -> tuple[np.ndarray, ...]:
    """Matrices of a changed robot at the coordinates of given positions, by its own functions."""
    changed = robot.with_values(dict(zip(names, theta, strict=True)))
    n = robot.n_coordinates
    model = changed.model
    matrices: list[list[np.ndarray]] = [[], [], []]
    for q in found.coordinates:
        x = (q, np.zeros(n), np.zeros(robot.n_motors), np.zeros(6), model.parameter_values)
        slopes = model.force.jacobian()(*x, model.force(*x))
        matrices[0].append(model.mass_matrix(q, model.parameter_values).full())
        matrices[1].append(-slopes[1].full())
        matrices[2].append(-slopes[0].full())
    return tuple(np.array(matrix) for matrix in matrices)


@pytest.mark.parametrize(
    ("name", "names"),
    [
        ("six_axis", SPRINGS),
        ("e12", ("body_1.ry.stiffness", "motor_2.inertia", "body_3.ry.damping")),
        ("four_mass", ("body_1.rz.stiffness", "body_2.rz.damping", "motor_1.viscous_friction", "motor_1.inertia")),
        ("emps", ("motor_1.inertia", "motor_1.viscous_friction")),
    ],
)
def test_rank_one_terms_follow_other_values_exactly(name: str, names: tuple[str, ...]) -> None:
    robot = load_robot(name)
    found = linearise_positions(robot, names, positions_of(robot))
    theta = found.values * np.linspace(0.5, 3.0, len(names))
    assert found.sloped.size == 0
    for matrix, expected in zip(found.matrices(theta), at(robot, names, found, theta), strict=True):
        np.testing.assert_allclose(matrix, expected, atol=1e-11 * np.max(np.abs(expected)))


def test_other_parameters_have_the_slopes_of_differences() -> None:
    names = ("body_2.mass", "body_2.center_of_mass.x", "body_2.inertia.yy", "body_1.length.z", "body_2.ry.stiffness")
    robot = load_robot("elbow")
    found = linearise_positions(robot, names, positions_of(robot))
    np.testing.assert_array_equal(found.sloped, [0, 1, 2, 3])
    for number, place in enumerate(found.sloped):
        step = 1e-5 * found.values[place] * np.eye(len(names))[place]
        ends = [at(robot, names, found, found.values + sign * step) for sign in (1, -1)]
        given = (found.mass_slopes, found.damping_slopes, found.stiffness_slopes)
        for slopes, high, low in zip(given, *ends, strict=True):
            expected = (high - low) / (2 * step[place])
            scale = max(1e-3, np.max(np.abs(expected)))
            np.testing.assert_allclose(slopes[:, number], expected, atol=2e-5 * scale)


def test_motor_inertia_with_inertial_coupling_is_no_rank_one_term() -> None:
    coupled = robot_from_data({**load_robot("elbow").spec.model_dump(), "inertial_coupling": True}, "test")
    names = ("motor_2.inertia", "body_2.ry.stiffness")
    found = linearise_positions(coupled, names, positions_of(coupled))
    np.testing.assert_array_equal(found.sloped, [0])
    theta = found.values * [1.5, 1.0]
    for matrix, expected in zip(found.matrices(theta), at(coupled, names, found, theta), strict=True):
        np.testing.assert_allclose(matrix, expected, atol=1e-9 * np.max(np.abs(expected)))


@pytest.mark.parametrize(
    ("spring", "slope"),
    [
        ({"cubic": {"linear": 1e5, "cubic": 3e9}}, lambda d: 1e5 + 9e9 * d**2),
        ({"piecewise_linear": {"knots": [1e-4], "slopes": [5e4, 2e5]}}, lambda d: 2e5 if abs(d) > 1e-4 else 5e4),
    ],
)
def test_factor_of_a_nonlinear_spring_is_its_slope_under_load(spring: dict[str, object], slope: object) -> None:
    robot = loaded_elbow(spring)
    found = linearise_positions(robot, ["body_1.ry.stiffness", "body_2.ry.stiffness"], [[0.4, 0.2], [-0.5, 0.1]])
    deflections = found.coordinates[:, 2] - found.coordinates[:, 0]
    assert np.min(np.abs(deflections)) > 1e-4
    np.testing.assert_allclose(found.factors[:, 0], [slope(d) for d in deflections])  # type: ignore[operator]
    np.testing.assert_array_equal(found.factors[:, 1], 1.0)
    expected = at(robot, ("body_1.ry.stiffness",), found, np.array([1.3]))[2]
    np.testing.assert_allclose(found.matrices(np.array([1.3, 1e5]))[2], expected, rtol=1e-9, atol=1e-6)


def test_stiffness_holds_the_gravity_load() -> None:
    robot = load_robot("elbow")
    found = linearise_positions(robot, ["body_1.ry.stiffness"], [[0.2, 0.3]])
    without = linearise_positions(robot.with_values({"gravity.z": 0.0}), ["body_1.ry.stiffness"], [[0.2, 0.3]])
    moment = 9.81 * 45 * 0.35  # of the forearm about its joint, of the order of its gravity stiffness
    difference = np.max(np.abs(found.stiffness - without.stiffness))
    assert 0.1 * moment < difference < 10 * moment


def test_wrong_number_of_values_is_reported() -> None:
    with pytest.raises(InputError, match="2 values were given for 1 unknown parameters of robot two_mass"):
        linearise_positions(load_robot("two_mass"), ["body_1.rz.stiffness"], [[0.0]], [1.0, 2.0])


def test_non_finite_value_is_reported() -> None:
    with pytest.raises(InputError, match=r"the value of body_1.rz.stiffness is not a finite number; give one"):
        linearise_positions(load_robot("two_mass"), ["body_1.rz.stiffness"], [[0.0]], [np.nan])


def test_wrong_motor_positions_are_reported() -> None:
    with pytest.raises(InputError, match=r"motor positions have shape \(2,\), but robot e12 needs finite numbers"):
        linearise_positions(load_robot("e12"), ["body_1.ry.stiffness"], [0.0, 0.0])


def test_duplicate_parameter_is_reported() -> None:
    with pytest.raises(InputError, match=r"unknown parameters name body_1.ry.damping more than once"):
        linearise_positions(load_robot("e12"), ["body_1.ry.damping"] * 2, [[0.0, 0.0]])


def test_unknown_parameter_is_reported() -> None:
    with pytest.raises(InputError, match=r"body_9.ry.stiffness"):
        linearise_positions(load_robot("e12"), ["body_9.ry.stiffness"], [[0.0, 0.0]])


def test_springs_too_soft_for_gravity_are_reported() -> None:
    data = load_robot("emps").spec.model_dump()
    body = {"label": "load", "mass": 10.0, "directions": {"tz": {"spring": 1e4, "damper": 10.0}}}
    data = {**data, "gravity": [0, 0, -9.81], "bodies": [data["bodies"][0], body]}
    lift = robot_from_data(data, "test")
    with pytest.raises(
        InputError, match=r"no equilibrium at motor positions \[0.0\] with body_2.tz.stiffness = 0: its spr"
    ):
        linearise_positions(lift, ["body_2.tz.stiffness"], [[0.0]], [0.0])
