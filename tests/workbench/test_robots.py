"""Linear models by the name of a robot, a file or a patch."""

from __future__ import annotations

import numpy as np
import pytest

import flexros
from flexros.errors import InputError
from flexros.workbench.given import reference_of


def test_name_and_robot_give_the_same_model() -> None:
    by_name = flexros.linear_model("e12", [0.0, 0.3, 0.0])
    by_robot = flexros.linear_model(flexros.load_robot("e12"), [0.0, 0.3, 0.0])
    assert np.array_equal(by_name.mass, by_robot.mass)


def test_unknown_robot_is_named() -> None:
    with pytest.raises(InputError, match="did you mean 'e12'"):
        flexros.linear_model("e13")


def test_robot_of_the_library_is_referred_to_by_its_name() -> None:
    assert reference_of(flexros.load_robot("e12")) == "e12"
