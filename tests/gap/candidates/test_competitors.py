"""Restrictions of a search to effects and motors."""

from __future__ import annotations

import pytest

from flexros.effects import effects
from flexros.effects.center_error import CenterError
from flexros.errors import InputError
from flexros.gap.candidates.candidate import distinct_locations
from flexros.gap.candidates.competitors import competitors, locations_of
from flexros.gap.settings import SearchSettings
from flexros.robot import load_robot
from flexros.robot.robot import Robot

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
