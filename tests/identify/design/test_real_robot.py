"""A robot that plays the real one: what differs, and what may not."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros.identify.design.real_robot import stand_in_values
from flexros.identify.robot_file import IdentifiedValue, identified_file
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


@pytest.mark.parametrize("name", ["e12", "two_mass", "four_mass", "six_axis"])
def test_identified_robot_stands_in(name: str, tmp_path: Path) -> None:
    nominal = load_robot(name)
    chosen = [one for one in nominal.parameters if one.endswith((".stiffness", "motor_1.viscous_friction"))]
    values = {one: 1.1 * nominal.parameters[one].value + 0.01 for one in chosen}
    file = tmp_path / "identified.yaml"
    file.write_text(identified_file(nominal, {one: IdentifiedValue(values[one], 0.1) for one in chosen}, "a test"))
    assert stand_in_values(nominal, load_robot(file)) == pytest.approx(values, rel=1e-12)


def test_spring_of_another_law_is_refused() -> None:
    four_mass = load_robot("four_mass")
    data = four_mass.spec.model_dump(mode="json", exclude_none=True)
    data["bodies"][0]["directions"]["rz"]["spring"]["piecewise_linear"]["slopes"][1] *= 1.1
    with pytest.raises(InputError, match=r"they differ in 'bodies\[0\].directions.rz.spring.piecewise_linear.slopes"):
        stand_in_values(four_mass, robot_from_data(data, "other.yaml"))


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
