"""Kinematic errors move the measured tool, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.effects.kinematic_error import KinematicError
from flexros.robot import load_robot
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel
from tests.effects.effect_runs import laws_of

pytestmark = pytest.mark.slow

E12, SIX_AXIS = load_robot("e12"), load_robot("six_axis")


def pose(text: str, arm: list[float]) -> list[float]:
    plant = Plant(E12, E12.sample_time, np.array([*arm, *[0.0] * 7]), laws=laws_of(E12, text) if text else ())
    return list(plant.tool_pose())


def test_length_error_lengthens_the_body() -> None:
    longer = E12.with_values({"body_2.length.x": 1.003})
    arm = [0.2, -0.7, 0.01]
    assert pose("kinematic_error@body_2:length=3e-3", arm) == pytest.approx(list(longer.tool_pose(arm)), abs=1e-14)


def test_angle_error_turns_the_body_and_all_behind_it() -> None:
    turned = [0.2, -0.7 + 2e-3, 0.01]
    assert pose("kinematic_error@body_2:angle=2e-3", [0.2, -0.7, 0.01]) == pytest.approx(
        list(E12.tool_pose(turned)), abs=1e-14
    )


def test_errors_of_several_bodies_add_up() -> None:
    laws = laws_of(SIX_AXIS, "kinematic_error@body_3:length=1e-3,angle=1e-3", "kinematic_error@body_5:length=-2e-3")
    plant = Plant(SIX_AXIS, SIX_AXIS.sample_time, SIX_AXIS.equilibrium(SIX_AXIS.home), laws=laws)
    arm = plant.state[: SIX_AXIS.n_arm]
    arm[SIX_AXIS.arm_names.index("body_3.ry")] += 1e-3
    longer = SIX_AXIS.with_values({"body_3.length.z": 1.101, "body_5.length.x": 0.948})
    assert list(plant.tool_pose()) == pytest.approx(list(longer.tool_pose(arm)), abs=1e-12)


def test_motion_and_encoders_stay_as_they_are() -> None:
    plants = [
        Plant(E12, E12.sample_time, np.zeros(10), laws=laws)
        for laws in ((), laws_of(E12, "kinematic_error@body_1:length=0.01,angle=0.01"))
    ]
    for k in range(50):
        readings = [plant.measure() for plant in plants]
        assert np.array_equal(*readings)
        for plant in plants:
            plant.advance([100.0 * k, -50.0 * k])
    assert np.max(np.abs(plants[0].tool_pose() - plants[1].tool_pose())) > 1e-3


def test_neutral_values_switch_it_off_and_tools_without_geometry_have_none() -> None:
    assert PlantModel(E12, laws_of(E12, "kinematic_error@body_2:length=0")).laws == ()
    assert KinematicError().locations(load_robot("four_mass")) == ()
    assert KinematicError().locations(E12) == ("body_1", "body_2", "body_3")


@pytest.mark.parametrize(("location", "names"), [("body_1", {"length"}), ("body_2", {"length", "angle"})])
def test_the_angle_of_the_first_body_is_not_looked_for(location: str, names: set[str]) -> None:
    """A tracker that stands turned by this angle sees the same."""
    assert set(KinematicError().fitted(load_robot("elbow"), location)) == names
