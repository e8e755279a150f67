"""Bounds of quantitative feedback theory against brute force."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.control.context import LoopContext
from flexros.control.design.margins import loop_margins
from flexros.control.design.methods.base import DesignProblem
from flexros.control.design.methods.qft import Qft
from flexros.control.design.qft_bounds import Specifications, excess
from flexros.control.linear_controller import linear_controller
from flexros.robot import load_robot
from tests.oracles.qft_bounds import forbidden_gains


def test_forbidden_gains_are_those_that_exceed_a_specification() -> None:
    rng = np.random.default_rng(1)
    template = rng.normal(size=(6, 3)) + 1j * rng.normal(size=(6, 3))
    limits = Specifications(2.0, 1.5, np.array([0.3, 0.8, 2.0]))
    phases, gains = np.linspace(-np.pi, np.pi, 25), np.geomspace(1e-2, 1e2, 400)
    for number in range(3):
        for phase, intervals in zip(phases, forbidden_gains(template[:, number], phases, limits, number), strict=True):
            one = Specifications(2.0, 1.5, limits.compliance[number : number + 1])
            worst = np.array([excess(template[:, [number]], np.array([k * np.exp(1j * phase)]), one)[0] for k in gains])
            inside = np.array([any(begin < k < end for begin, end in intervals) for k in gains])
            clear = np.abs(worst) > 1e-9
            assert np.array_equal(inside[clear], worst[clear] > 0.0)


def test_shaped_loop_keeps_its_bounds_for_every_plant() -> None:
    pytest.importorskip("cma")
    robot = load_robot("four_mass")
    problem = DesignProblem.of(robot)
    method = Qft(stiffness=12.0, trials=500)
    design = method.design(problem)
    assert design.figures["bounds kept"] == 1.0
    linear = linear_controller(design.law(), LoopContext(robot, robot.sample_time))
    for margins in loop_margins(problem.sampled, linear):
        assert margins.largest_eigenvalue < 1.0
        assert margins.sensitivity < 1.02 * method.sensitivity
        assert margins.complementary < 1.02 * method.complementary
