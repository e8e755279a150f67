from __future__ import annotations

from typing import Any

import pytest

from flexros.errors import InputError
from flexros.robot import load_robot, robot_from_data
from flexros.robot.beam import clamped_modes

BEAM: dict[str, Any] = {
    "mass": 1.2,
    "length": [1, 0, 0],
    "directions": {"rz": {"spring": "rigid", "motor": {"inertia": 0.01}}},
    "bending": {"rz": {"rigidity": 100, "modes": 2, "damping_ratio": 0.02}},
}


def robot(**changes: Any) -> Any:
    data = {
        "name": "beam",
        "bodies": [{**BEAM, **changes}],
        "outputs": {"joints": {"coordinates": ["body_1.rz"]}},
        "controlled": "joints",
    }
    return robot_from_data(data, "test robot")


def test_modes_are_arm_coordinates_with_a_spring_each() -> None:
    found = robot()
    assert found.arm_names == ("body_1.rz", "body_1.bending_rz_1", "body_1.bending_rz_2")
    assert found.spring_rows == (1, 2)
    # E I int phi''^2 = omega^2 m int phi^2, and int phi^2 = 1/4 for the largest deflection 1 of a clamped beam
    root = clamped_modes(1)[0].root
    stiffness = found.parameters["body_1.bending_rz_1.stiffness"]
    assert stiffness.value == pytest.approx(100 * root**4 / 4, rel=1e-9)
    assert stiffness.unit == "N/m"
    damping = found.parameters["body_1.bending_rz_1.damping"]
    assert damping.value == pytest.approx(2 * 0.02 * (stiffness.value * 1.2 / 4) ** 0.5, rel=1e-6)


def test_modal_numbers_are_parameters_like_others() -> None:
    softer = robot().with_values({"body_1.bending_rz_2.stiffness": 5.0, "body_1.mass": 2.0})
    assert softer.parameters["body_1.bending_rz_2.stiffness"].value == 5.0
    assert (
        softer.parameters["body_1.bending_rz_1.stiffness"].value
        == robot().parameters["body_1.bending_rz_1.stiffness"].value
    )


def test_file_with_its_modes_written_out_is_the_same_robot() -> None:
    first = robot()
    again = robot_from_data(first.spec.model_dump(), "again")
    assert again.model_hash == first.model_hash


def test_robots_without_bending_keep_their_fingerprint() -> None:
    assert "bending" not in load_robot("e12").spec.model_dump_json()


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"length": [1, 0.2, 0]}, "straight along one of its axes"),
        ({"mass": 0}, "give the mass of the beam"),
        ({"center_of_mass": [0.3, 0, 0]}, r"a uniform beam has it at \[0.5, 0.0, 0.0\]"),
        ({"inertia": {"zz": 0.1}}, "follows from mass and length"),
        ({"bending": {"rx": {"rigidity": 1}}}, "its own long axis"),
        ({"directions": {"rz": "rigid"}}, "does not move"),
        ({"bending": {"rz": {"rigidity": 1, "modes": 7}}}, "modes"),
        ({"bending": {"rz": {"rigidity": 0}}}, "must be positive"),
        ({"bending": {"rz": {"rigidity": {"value": 1, "unit": "Nm/rad"}}}}, "the unit here is 'N m2'"),
    ],
)
def test_what_is_no_uniform_beam_is_refused(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        robot(**changes)
