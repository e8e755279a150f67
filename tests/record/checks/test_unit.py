"""Units and sides of the gear."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.record.balance.joint_assignments import WEIGHTLESS
from flexros.record.balance.torque_balance import BalanceFit
from flexros.record.checks import unit
from flexros.record.checks.base import Finding
from flexros.record.checks.run import findings
from flexros.record.checks.unit import Unit, _common_causes, _refusal, _share_of_limits
from flexros.record.smoothing import smooth_motion
from flexros.robot import load_robot

pytestmark = pytest.mark.slow


def refusal(findings: tuple[Finding, ...]) -> str:
    assert findings[0].hopeless
    return findings[0].text


def test_degrees_are_named(found, healthy) -> None:
    text = refusal(found("four_mass_linear", position=np.degrees(healthy("four_mass_linear").position)))
    assert "(motor_1: 0.0175), allowed is a factor of 2.7 either way: it looks like positions in degrees" in text
    assert text.endswith("correct unit, gear ratio or torque constant when importing, or give the right robot")


def test_one_joint_in_degrees_is_named(found, healthy, scaled) -> None:
    text = refusal(found("e12", position=scaled(healthy("e12").position, 1, np.degrees(1.0))))
    assert "motor_2: 0.0" in text
    assert "degrees" in text
    assert "motor_1" not in text


@pytest.mark.parametrize(
    ("position", "torque", "words"),
    [
        (1 / 220, 1.0, "one of torque and position on the other side of the gear"),
        (1.0, 220.0, "one of torque and position on the other side of the gear"),
        (1 / 220, 220.0, "torque and position on the arm side of the gear"),
        (1.0, 1000.0, "milli (torques)"),
    ],
)
def test_gear_ratio_and_milli_are_named(found, healthy, position: float, torque: float, words: str) -> None:
    record = healthy("four_mass_linear")
    assert words in refusal(
        found("four_mass_linear", position=position * record.position, torque=torque * record.torque)
    )


def test_share_of_the_limit_is_named(found, healthy) -> None:
    assert "torques in % of the limit" in refusal(found("emps", torque=healthy("emps").torque / 351.506 * 100))


def test_unknown_factor_of_all_torques(found, healthy) -> None:
    text = refusal(found("e12", torque=30 * healthy("e12").torque))
    assert "the torques or the motions have another unit" in text


def test_factor_of_two_is_told_only(found, healthy) -> None:
    (finding,) = found("e12", torque=2.2 * healthy("e12").torque[:, :] * np.array([1.0, 1 / 2.2]))
    assert not finding.hopeless
    assert finding.of_either
    assert "the torque of motor_1 is 2." in finding.text


def test_log_of_another_robot_is_refused(healthy) -> None:
    text = refusal(findings(healthy("emps"), load_robot("two_mass")))
    assert "torque or motion have another unit, or the robot is another one" in text


def test_load_and_rotors_that_a_urdf_lacks_are_no_unit(ur5e, ur5e_record) -> None:
    """The wrists of a UR5e with an unknown tool need several times the torque of its URDF; its shoulder does not."""
    problems = findings(ur5e_record, ur5e)
    assert not any(finding.hopeless for finding in problems)
    assert any("motor_5" in finding.text for finding in problems)


def test_friction_and_rotors_that_a_urdf_lacks_may_be_most_of_the_torque(ur5e, ur5e_record) -> None:
    problems = findings(replace(ur5e_record, torque=1.6 * ur5e_record.torque), ur5e)
    assert any("the torque of motor_2 is" in finding.text for finding in problems)
    assert not any(finding.hopeless for finding in problems)


def test_rotors_and_friction_far_beyond_what_bodies_need_are_no_unit(ur5e, ur5e_record) -> None:
    """Beside them the bodies need what they should; without them factors of 28 and more would be left."""
    _, speed, acceleration = smooth_motion(ur5e_record.position, ur5e_record.sample_time, 10.0)
    torque = ur5e_record.torque + 20 * np.tanh(speed / 0.02) + 30 * acceleration
    problems = findings(replace(ur5e_record, torque=torque), ur5e)
    assert not any(finding.hopeless for finding in problems)
    assert any(finding.hopeless for finding in findings(replace(ur5e_record, torque=8 * torque), ur5e))


@pytest.mark.parametrize(("torque", "words"), [(1000.0, "motor_2"), (np.array([1, 1, 1, 1, 1000, 1]), "motor_5")])
def test_wrong_units_of_such_a_robot_are_refused(ur5e, ur5e_record, torque, words: str) -> None:
    wrong = replace(ur5e_record, torque=torque * ur5e_record.torque)
    assert words in refusal(findings(wrong, ur5e))


def test_rotors_that_are_far_off_are_no_unit(ur5e, ur5e_record) -> None:
    """Public models of this arm state a tenth of a kg m2 at every joint."""
    rotors = ur5e.with_values({f"{name}.inertia": 0.1 for name in ur5e.joint_names})
    assert not any(finding.hopeless for finding in findings(ur5e_record, rotors))


@pytest.mark.parametrize(("wrist", "base", "hopeless"), [(3.8, 1.2, False), (0.3, 1.2, True), (3.8, 3.8, True)])
def test_a_load_multiplies_the_torque_of_a_light_wrist_without_gravity_too(
    ur5e, wrist: float, base: float, hopeless: bool
) -> None:
    """Of inertias it is as of weights; a wrong unit makes torques smaller, or multiplies all of them."""
    weightless = ur5e.with_values(WEIGHTLESS | {f"{name}.inertia": 0.1 for name in ur5e.joint_names})
    factors = (base, base, base, 1.0, 1.0, wrist)
    checked: Any = SimpleNamespace(
        order_is_wrong=False,
        fits_nominal_rate=False,
        wrongly_assigned=False,
        robot=weightless,
        balance=SimpleNamespace(needed=np.array([[50.0, 30.0, 10.0, 1.0, 1.0, 0.1]])),
        record=SimpleNamespace(position=np.zeros((2, 6)), valid=np.ones(2, dtype=bool)),
        own=tuple(BalanceFit(factor, 0.95, 0.5, 0.95, 0.9) for factor in factors),
        slow_parts=(np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((2, 6, 4))),
    )
    assert any(finding.hopeless for finding in Unit().look(checked)) is hopeless


@pytest.mark.parametrize(
    ("factors", "named"),
    [((1.95, 3.05), True), ((1.95, 2.0), False), ((1.0, 3.05), False)],
    ids=["shares of the limits", "one factor", "one motor"],
)
def test_torques_in_per_cent_of_limits_that_differ(factors: tuple[float, float], named: bool) -> None:
    fits = tuple(BalanceFit(factor, 0.95, 0.7, 0.95, 0.9) for factor in factors)
    motors = [SimpleNamespace(torque_limit=limit) for limit in (50.0, 32.0)]
    robot = SimpleNamespace(name="arm", joint_names=["motor_1", "motor_2"], motors=motors)
    assert bool(_share_of_limits(SimpleNamespace(robot=robot, own=fits))) is named


def test_the_mistake_of_most_motors_is_named_though_friction_moves_the_factor_of_one() -> None:
    motors = [SimpleNamespace(torque_limit=np.inf, gear_ratio=100.0, rotary=True) for _ in range(3)]
    robot: Any = SimpleNamespace(name="arm", joint_names=["motor_1", "motor_2", "motor_3"], motors=motors)
    off = {k: BalanceFit(factor, 0.9, 0.0, 0.9, 0.9) for k, factor in enumerate((0.0095, 0.0098, 0.0135))}
    assert "the other side of the gear (ratio 100)" in _refusal(off, _common_causes(off, robot), robot, 3)


@pytest.mark.parametrize(("factors", "rough"), [((1.3, 1.5, 1.2), True), ((1.3, 6.0, 1.2), False)])
def test_where_friction_hides_the_largest_torque_other_heavy_joints_tell_the_unit(
    factors: tuple[float, float, float], rough: bool
) -> None:
    """A load at a light wrist, and a shoulder whose torque hardly agrees: the joints between have the right unit."""
    agreements = (0.23, 0.78, 0.88)
    own = [SimpleNamespace(factor=f, agreement=a) for f, a in zip((*factors, 6.1), (*agreements, 0.5), strict=True)]
    needed = np.sqrt(np.array([[3e8, 2e8, 1e7, 1e4]]))
    robot = SimpleNamespace(n_motors=4)
    checked: Any = SimpleNamespace(balance=SimpleNamespace(needed=needed), robot=robot, own=own)
    refused: Any = {motor: fit for motor, fit in enumerate(own) if fit.factor > 2.7 and fit.agreement > 0.4}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(unit, "rotor_unknown", lambda _: np.zeros(4, dtype=bool))
        assert unit._model_may_be_rough(checked, refused, {}) is rough


@pytest.mark.parametrize(
    ("factors", "rough"),
    [((1.3, 1.6, 2.9), True), ((2.9, 2.9, 2.9), False), ((1.3, 1.6, 5.5), False), ((2.9, 1.6, 1.2), False)],
    ids=["a load", "a unit", "too much for a load", "a shoulder"],
)
def test_a_load_may_multiply_the_torque_of_a_joint_beyond_others_that_fit(
    factors: tuple[float, float, float], rough: bool
) -> None:
    own = [SimpleNamespace(factor=factor, agreement=0.9) for factor in factors]
    needed = np.sqrt(np.array([[3e6, 2e6, 1e5]]))
    checked: Any = SimpleNamespace(balance=SimpleNamespace(needed=needed), robot=SimpleNamespace(n_motors=3), own=own)
    refused: Any = {motor: fit for motor, fit in enumerate(own) if fit.factor > 2.7}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(unit, "rotor_unknown", lambda _: np.zeros(3, dtype=bool))
        assert unit._model_may_be_rough(checked, refused, {}) is rough


@pytest.mark.parametrize(("wrist", "rough"), [(6.0, True), (20.0, False)])
def test_a_load_adds_no_more_at_a_wrist_than_nearer_to_the_base(wrist: float, rough: bool) -> None:
    """Where most of what an elbow needs is friction, the factor beside that counts; a wrist of 1/7 of it may need 6."""
    own = [SimpleNamespace(factor=factor, agreement=0.5) for factor in (5.6, 2 * wrist)]
    needed = np.sqrt(np.array([[50.0, 1.0]]))
    checked: Any = SimpleNamespace(balance=SimpleNamespace(needed=needed), robot=SimpleNamespace(n_motors=2), own=own)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(unit, "rotor_unknown", lambda _: np.ones(2, dtype=bool))
        refused: Any = {1: own[1]}
        assert unit._model_may_be_rough(checked, refused, {0: 2.5, 1: wrist}) is rough
