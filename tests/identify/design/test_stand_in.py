"""A robot that plays the real one: what differs, and what may not."""

from __future__ import annotations

import pytest

from flexros.errors import InputError
from flexros.identify.design.stand_in import stand_in_values
from flexros.robot import load_robot
from flexros.robot.robot import robot_from_data

NOMINAL = load_robot("e12")


def changed(**keys: object) -> dict[str, object]:
    return {**NOMINAL.spec.model_dump(mode="json", exclude_none=True), **keys}


def test_numbers_that_differ_are_listed() -> None:
    values = {"body_1.ry.stiffness": 1.3e5, "body_3.mass": 210.0, "body_2.length.x": 1.01, "delay": 2e-4}
    assert stand_in_values(NOMINAL, NOMINAL.with_values(values)) == values


def test_the_same_robot_has_none_whatever_its_texts() -> None:
    other = robot_from_data(changed(name="mine", description="my robot"), "mine.yaml")
    assert stand_in_values(NOMINAL, other) == {}


@pytest.mark.parametrize(
    ("keys", "place"),
    [
        ({"sample_time": 1e-3}, "sample_time.value"),
        ({"sensors": {"encoder_noise": {"value": 1e-5, "unit": "rad"}}}, "sensors.encoder_noise.value"),
    ],
)
def test_other_differences_are_refused_by_name(keys: dict[str, object], place: str) -> None:
    other = robot_from_data(changed(**keys), "other.yaml")
    with pytest.raises(InputError, match=rf"robot other.yaml cannot stand in for e12: they differ in '{place}'"):
        stand_in_values(NOMINAL, other)


def test_another_robot_is_refused() -> None:
    with pytest.raises(InputError, match="robot two_mass cannot stand in for e12: they differ in "):
        stand_in_values(NOMINAL, load_robot("two_mass"))
