"""Restrictions of a search to effects and motors."""

from __future__ import annotations

from dataclasses import replace

import pytest

from flexros.effects import effects
from flexros.effects.center_error import CenterError
from flexros.effects.kinds.base import AbstractEffect
from flexros.errors import InputError
from flexros.gap.candidates.candidate import distinct_locations
from flexros.gap.candidates.competitors import competitors, locations_of, not_sought
from flexros.gap.settings import SearchSettings
from flexros.record.read import read_record
from flexros.record.record import Record
from flexros.robot import load_robot
from flexros.robot.robot import Robot
from tests.gap.servo_logs import servo_log, servo_robot

ELBOW, SIX_AXIS = load_robot("elbow"), load_robot("six_axis")


def test_a_motor_has_its_springs_and_body() -> None:
    assert locations_of(ELBOW, ["motor_2"]) == {"motor_2", "body_2.ry", "body_2"}


def test_springs_across_the_axis_belong_to_the_motor_of_their_body() -> None:
    assert locations_of(SIX_AXIS, ["motor_2"]) == {"motor_2", "body_3.ry", "body_3.rx", "body_3.rz", "body_3"}


def test_what_is_before_the_first_motor_or_behind_the_last_belongs_to_it() -> None:
    first, last = locations_of(SIX_AXIS, ["motor_1"]), locations_of(SIX_AXIS, ["motor_6"])
    assert first is not None
    assert last is not None
    assert {"body_1", "body_1.rx", "body_2", "body_2.rz"} <= first
    assert {"body_7", "body_7.rx", "body_7.ry"} <= last


@pytest.mark.parametrize("motors", [[], ["motor_2", "motor_1"]])
def test_no_motor_and_all_motors_are_no_restriction(motors: list[str]) -> None:
    assert locations_of(ELBOW, motors) is None


def test_every_location_of_an_effect_belongs_to_a_motor_or_to_all() -> None:
    for robot in (ELBOW, SIX_AXIS):
        of_motors = set().union(*(locations_of(robot, [name]) or set() for name in robot.joint_names))
        listed = {place for effect in effects().values() for place in distinct_locations(effect, robot)}
        assert listed - of_motors == {"tool", "base", "all"} & listed


def test_the_name_of_a_joint_in_the_robot_file_names_its_motor() -> None:
    spec = ELBOW.spec.model_copy(update={"tags": {"motor_2.joint": "elbow_joint"}})
    assert locations_of(Robot(spec, ELBOW.source), ["elbow_joint"]) == locations_of(ELBOW, ["motor_2"])


def test_only_named_effects_compete() -> None:
    competing = competitors(ELBOW, SearchSettings(effects=("backlash",)))
    assert [effect.name for effect in effects().values() if competing.include(effect)] == ["backlash"]


@pytest.mark.parametrize(
    ("given", "argument", "text"),
    [
        ({"effects": ("backlach",)}, "effects", "backlash"),
        ({"joints": ("motor_3",)}, "joints", "motor_1, motor_2"),
        ({"joints": ("",)}, "joints", "motor_1, motor_2"),
        ({"effects": ("payload_error",), "joints": ("motor_1",)}, "joints", "payload_error"),
    ],
)
def test_what_does_not_exist_is_refused(given: dict[str, tuple[str, ...]], argument: str, text: str) -> None:
    with pytest.raises(InputError, match=text) as caught:
        competitors(ELBOW, SearchSettings(**given))
    assert caught.value.argument == argument


def test_an_effect_on_request_competes_where_it_is_named() -> None:
    assert not competitors(ELBOW, SearchSettings()).include(CenterError)
    assert competitors(ELBOW, SearchSettings(effects=("center_error",))).include(CenterError)


SERVOS = servo_robot().commanded_by("position")


def servo_record() -> Record:
    return read_record(servo_log(), servo_robot(), name="log", positions=True)


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["counterbalance"], "is not sought in this log: it is sought only in logs with torques, in those of servos"),
        (["backlash"], "it cannot act on robot"),
        (["counterbalance", "torque_curve"], ""),
        (["servo_stiffness_error", "coulomb_friction", "torque_gain_error", "rotor_inertia"], ""),
        ([], ""),
    ],
)
def test_named_effects_that_a_log_of_servos_is_not_searched_for_are_told(names: list[str], words: str) -> None:
    texts = not_sought(servo_record(), SERVOS, SearchSettings(effects=tuple(names)))
    assert len(texts) == bool(words)
    assert all(text.startswith(f"{names[0]} was named as a candidate, but") and words in text for text in texts)


def test_named_effects_that_a_log_of_torques_is_not_searched_for_are_told() -> None:
    settings = SearchSettings(effects=("counterbalance", "servo_stiffness_error", "kinematic_error"))
    texts = not_sought(replace(servo_record(), command=None), servo_robot(), settings)
    assert [text.partition(" ")[0] for text in texts] == ["servo_stiffness_error", "kinematic_error"]


def test_effects_that_are_not_always_sought_say_where() -> None:
    always = AbstractEffect.sought, AbstractEffect.sought_if_measured
    limited = [one for one in effects().values() if (one.sought, one.sought_if_measured) != always and one.ranges]
    begun_with = {"rotor_inertia", "tool_load", "torque_gain_error"}
    assert {one.name for one in limited if not one.sought_where} == begun_with
