from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.robot import load_robot
from flexros.robot.linear.linearise import linear_model
from flexros.robot.linear.zeros import poles
from flexros.view.page import new_server
from flexros.view.robot_page import modes


def test_modes_have_the_frequencies_of_the_poles() -> None:
    robot = load_robot("two_mass")
    home = np.array(robot.home)
    expected = sorted(abs(pole) / (2 * np.pi) for pole in poles(linear_model(robot, home)) if pole.imag > 1.0)
    assert [hz for hz, _ in modes(robot, home)] == pytest.approx(expected)


def test_missing_viewer_is_said_in_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("flexros.view.page.find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"flexros\[view\]"):
        new_server("title", "127.0.0.1", 0)
