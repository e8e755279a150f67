"""Friction and inertia that the torques of a log show: recovery of known values by inverse dynamics."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.candidates.tolerance import Tolerance, tolerance_of
from flexros.gap.fit.torques.missing_load import load_beside
from flexros.gap.fit.torques.position_torque import PositionTorque
from flexros.gap.fit.torques.regression import regress_torque
from flexros.gap.fit.torques.unknown_numbers import UNCERTAIN, unknown_numbers
from flexros.gap.settings import TorqueStartSettings
from flexros.record.record import Record
from flexros.robot import robot_from_data
from tests.gap.rigid_arm import COULOMB, INERTIA, VISCOUS, T, arm, motion, record_of_arm
from tests.ur5e import ur5e, ur5e_record


def test_friction_and_inertia_of_all_motors_are_found_at_once() -> None:
    found = regress_torque(record_of_arm(), RobotWithEffects(arm(), ()), tolerance_of(arm(), {}))
    assert found is not None
    np.testing.assert_allclose(found.inertia, INERTIA, rtol=0.03)
    np.testing.assert_allclose(found.viscous_friction, VISCOUS, rtol=0.03)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.03)
    assert np.all(found.left < 0.1)


def test_a_body_that_is_heavier_within_tolerance_is_a_deviation_not_friction() -> None:
    light = arm().with_values({"body_2.mass": 3 / 1.1})
    found = regress_torque(record_of_arm(), RobotWithEffects(light, ()), Tolerance(("body_2.mass",), (0.05,)))
    assert found is not None
    assert found.deviations[0] == pytest.approx(np.log(1.1) / 0.05, rel=0.1)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.05)


def test_constant_torque_of_a_motor_that_turns_in_one_direction_is_its_friction() -> None:
    """The other motor turns back: its friction and offset are both known."""
    record = record_of_arm()
    forward = replace(record, valid=motion()[1, :, 0] > 0)
    model, tolerance = RobotWithEffects(arm(), ()), tolerance_of(arm(), {})
    found = regress_torque(forward, model, tolerance)
    assert found is not None
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.1)
    np.testing.assert_array_equal(found.bias, 0)
    shifted = regress_torque(record_of_arm(offset=3.0), model, tolerance)
    assert shifted is not None
    assert shifted.bias[0] == pytest.approx(-3.0, rel=0.02)
    assert shifted.coulomb_friction[0] == pytest.approx(COULOMB[0], rel=0.03)


def test_a_log_without_motion_shows_nothing() -> None:
    still = Record("still", T, np.zeros((4000, 2)), np.ones((4000, 2)), np.ones(4000, dtype=bool))
    assert regress_torque(still, RobotWithEffects(arm(), ()), Tolerance()) is None


def test_inertias_that_a_robot_file_lacks_are_estimated_and_uncertain() -> None:
    model = RobotWithEffects(arm(), ())
    unknown = unknown_numbers(record_of_arm(), model, tolerance_of(arm(), {}))
    np.testing.assert_allclose(list(unknown.inertias.values()), INERTIA, rtol=0.03)
    robot = unknown.given_to(model).robot
    assert robot.parameters["motor_2.inertia"].value == pytest.approx(0.3, rel=0.03)
    tolerance = unknown.tolerated(tolerance_of(robot, {}), robot)
    deviations = dict(zip(tolerance.names, tolerance.deviations))
    assert deviations["motor_1.inertia"] == UNCERTAIN
    assert deviations["body_1.mass"] == 0.05


@pytest.mark.slow
def test_load_that_a_urdf_lacks_is_estimated_beside_friction_and_rotors() -> None:
    """MuJoCo's UR5e carries 1.5 kg at 0.07 m."""
    robot, record = ur5e(), ur5e_record().part(0, 2000)
    model = RobotWithEffects(robot, ())
    unknown = unknown_numbers(record, model, tolerance_of(robot, {}))
    assert unknown.load is not None
    assert unknown.load.mass == pytest.approx(1.5, rel=0.02)
    np.testing.assert_allclose((unknown.load.x, unknown.load.y, unknown.load.z), (0, 0.07, 0), atol=0.003)
    np.testing.assert_allclose(list(unknown.inertias.values()), (1.4, 1.4, 1.1, 0.25, 0.25, 0.25), rtol=0.06)
    loaded = unknown.given_to(model)
    assert unknown.lacked_by(loaded).load is None
    assert unknown.lacked_by(model).load is unknown.load
    tolerance = unknown.tolerated(tolerance_of(loaded.robot, {}), loaded.robot)
    assert dict(zip(tolerance.names, tolerance.deviations))["body_7.mass"] == UNCERTAIN


def test_three_seconds_suffice_as_each_sample_has_an_equation_for_every_motor() -> None:
    """After decimation fewer samples are left than twice the columns of all six motors."""
    found = regress_torque(ur5e_record().part(0, 1600), RobotWithEffects(ur5e(), ()), Tolerance(), load="point")
    assert found is not None
    np.testing.assert_allclose(found.inertia, (1.4, 1.4, 1.1, 0.25, 0.25, 0.25), rtol=0.15)
    assert found.load[0] == pytest.approx(1.5, rel=0.05)


def test_arm_that_carries_nothing_has_no_load() -> None:
    assert unknown_numbers(record_of_arm(), RobotWithEffects(arm(), ()), tolerance_of(arm(), {})).load is None


def test_inertias_that_are_given_stay() -> None:
    given = RobotWithEffects(arm().with_values({"motor_1.inertia": 0.1, "motor_2.inertia": 0.2}), ())
    assert not unknown_numbers(record_of_arm(), given, Tolerance()).inertias
    assert not unknown_numbers(record_of_arm(simulated=True), RobotWithEffects(arm(), ()), Tolerance()).inertias


def test_a_small_rotor_may_be_in_the_inertia_of_the_bodies() -> None:
    """Of 0.12 kg m2 beside 1.3 of the bodies, it is clear where these are known to 0.05, and not where to 0.5."""
    model, record = RobotWithEffects(arm(), ()), record_of_arm(rotors=(0.12, 0.0))
    tolerance = tolerance_of(arm(), {})
    clear = unknown_numbers(record, model, tolerance).inertias
    assert clear == {"motor_1": pytest.approx(0.12, rel=0.05)}
    rough = replace(tolerance, deviations=tuple(10 * one for one in tolerance.deviations))
    found = regress_torque(record, model, rough)
    assert found is not None
    assert found.inertia_deviation[0] > 0.05
    assert not unknown_numbers(record, model, rough).inertias


def test_an_arm_without_rotors_has_none() -> None:
    record = record_of_arm(rotors=(0.0, 0.0))
    assert not unknown_numbers(record, RobotWithEffects(arm(), ()), tolerance_of(arm(), {})).inertias


@pytest.mark.parametrize("rotor", [0.0, 0.12])
def test_a_counterbalance_does_not_pass_for_a_rotor(rotor: float) -> None:
    """Regressed without it, the rotor has 2 kg m2."""
    record = record_of_arm(rotors=(rotor, 0.0), balance=(60.0, 10.0))
    found = unknown_numbers(record, RobotWithEffects(arm(), ()), tolerance_of(arm(), {})).inertias
    assert found == ({"motor_1": pytest.approx(rotor, rel=0.2)} if rotor else {})


@pytest.mark.slow
def test_load_is_estimated_where_the_rotors_are_given_too() -> None:
    """A load elsewhere than the centre of mass of the last body is no payload error."""
    robot = ur5e()
    rotors = dict(zip((f"{name}.inertia" for name in robot.joint_names), (1.4, 1.4, 1.1, 0.25, 0.25, 0.25)))
    given = robot.with_values(rotors)
    unknown = unknown_numbers(ur5e_record().part(0, 2000), RobotWithEffects(given, ()), tolerance_of(given, {}))
    assert not unknown.inertias
    assert unknown.load is not None
    assert unknown.load.mass == pytest.approx(1.5, rel=0.02)


def test_a_heavier_last_body_is_no_load() -> None:
    """It is a payload error."""
    given = arm().with_values({"motor_1.inertia": INERTIA[0], "motor_2.inertia": INERTIA[1]})
    heavy = record_of_arm(imported=True, load=1.0)
    assert unknown_numbers(heavy, RobotWithEffects(given, ()), tolerance_of(given, {})).load is None


def test_a_motor_that_is_not_driven_carries_no_load() -> None:
    """A load that takes the weight of its body away would explain that it has no torque."""
    given = RobotWithEffects(arm().with_values({"motor_1.inertia": 0.8, "motor_2.inertia": 0.3}), ())
    record = record_of_arm(imported=True)
    passive = replace(record, torque=record.torque * [1.0, 0.0])
    found = regress_torque(passive, given, Tolerance(), load="point")
    assert found is not None
    assert found.left[1] < 0.01
    assert unknown_numbers(passive, given, tolerance_of(given.robot, {})).load is None


@pytest.mark.parametrize(("mass", "tolerated", "found"), [
    (0.2, 1.0, True),
    (0.2, 0.02, False),
    (0.8, 0.02, True),
    (0.01, 1.0, False),
])  # fmt: skip
def test_a_light_load_counts_where_errors_of_the_bodies_do_not_explain_it(
    mass: float, tolerated: float, found: bool
) -> None:
    """Of an arm of 9 kg; `tolerated` is what they leave of the torques, as 0.01 is left with the load."""

    def regress(tolerance: Tolerance, **load: object) -> Any:
        left = 0.01 if load.get("load") else tolerated if tolerance.names else 1.0
        return SimpleNamespace(load=np.array([mass, 0.1 * mass, 0.0, 0.0]), left=np.array([left, 1.0]))

    tolerance = tolerance_of(arm(), {})
    load = load_beside(regress, arm(), tolerance, regress(Tolerance()), (), TorqueStartSettings())
    assert (load is not None) is found


def test_numbers_of_a_counterbalance_are_found_beside_friction_and_rotors() -> None:
    record = record_of_arm(balance=(-90.0, 15.0))
    found = regress_torque(record, RobotWithEffects(arm(), ()), Tolerance(), position_torques=(PositionTorque(0),))
    assert found is not None
    np.testing.assert_allclose(found.position_torques[0].sizes, (-90.0, 15.0), rtol=0.01)
    np.testing.assert_allclose(found.inertia, INERTIA, rtol=0.03)
    np.testing.assert_allclose(found.coulomb_friction, COULOMB, rtol=0.03)
    plain = regress_torque(record, RobotWithEffects(arm(), ()), Tolerance())
    assert plain is not None
    assert plain.rest[0] > 10 * found.rest[0]


def test_load_behind_a_counterbalance_is_estimated() -> None:
    """The weight of a heavy arm is carried by a spring at its first motor, of which the file says nothing.

    At that motor the weight of a load at the second joint looks like the spring; its first moment there does not.
    """
    model, record = RobotWithEffects(arm(), ()), record_of_arm(load=1.0, balance=(-90.0, 15.0))
    plain = regress_torque(record, model, Tolerance(), load="point")
    assert plain is not None
    assert plain.rest[0] > 5.0
    unknown = unknown_numbers(record, model, tolerance_of(arm(), {}))
    assert unknown.load is not None
    assert unknown.load.mass * unknown.load.x == pytest.approx(3.0 * 0.15, rel=0.02)
    assert unknown.inertias["motor_2"] == pytest.approx(0.3, rel=0.03)


def test_load_is_sought_beside_a_counterbalance_that_relieves_its_motor_by_itself() -> None:
    """Else a motor that is not driven is explained by a load, and by a counterbalance of what that load weighs."""
    model, record = RobotWithEffects(arm(), ()), record_of_arm(load=1.0, balance=(-90.0, 15.0))
    plain, relieved = (
        regress_torque(record, model, Tolerance(), position_torques=one) for one in ((), (PositionTorque(0),))
    )
    assert plain is not None
    assert relieved is not None
    factor = plain.rest[0] / relieved.rest[0]
    for needed, found in ((0.9 * factor, True), (1.1 * factor, False)):
        settings = TorqueStartSettings(relieved=needed)
        assert (unknown_numbers(record, model, tolerance_of(arm(), {}), settings).load is not None) is found


def test_a_motor_at_rest_without_load_hides_no_other() -> None:
    """A gantry: nothing but rounding is left of the force of one axis, which would weigh more than the other axis."""
    axis = {"spring": "rigid", "damper": 0, "motor": {"inertia": 0}}
    data = {
        "name": "gantry",
        "bodies": [{"mass": 5, "directions": {"tx": axis}}, {"mass": 2, "directions": {"ty": axis}}],
        "outputs": {"joints": {"coordinates": ["body_1.tx", "body_2.ty"]}},
        "controlled": "joints",
    }
    robot, (q, v, a) = robot_from_data(data, "gantry.yaml"), motion()
    force = 2 * a[:, 1] + 4 * v[:, 1] + 6 * np.sign(v[:, 1])
    record = Record(
        "log",
        T,
        np.stack([np.zeros(len(q)), q[:, 1]], axis=-1),
        np.stack([np.full(len(q), 1e-12), force], axis=-1),
        np.ones(len(q), dtype=bool),
        measured_torque=True,
        imported=True,
    )
    found = regress_torque(record, RobotWithEffects(robot, ()), Tolerance())
    assert found is not None
    assert found.viscous_friction[1] == pytest.approx(4.0, rel=0.03)
    assert found.coulomb_friction[1] == pytest.approx(6.0, rel=0.03)
    assert found.coulomb_friction[0] == 0.0
