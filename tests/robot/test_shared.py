from __future__ import annotations

import numpy as np

from flexros.robot import load_robot


def test_equal_files_share_one_robot_with_its_model() -> None:
    assert load_robot("two_mass") is load_robot("two_mass")
    changed = load_robot("two_mass").with_values({"motor_1.inertia": 0.3})
    assert changed is load_robot("two_mass").with_values({"motor_1.inertia": 0.3})


def test_robots_with_other_values_or_origins_are_apart() -> None:
    robot = load_robot("two_mass")
    changed, named = robot.with_values({"motor_1.inertia": 0.3}), robot.with_values({"motor_1.inertia": 0.3}, "a patch")
    assert len({id(robot.model), id(changed.model), id(named.model)}) == 3
    assert named.source == "a patch"
    np.testing.assert_array_equal(changed.model.motor_inertia([]), [[0.3]])
