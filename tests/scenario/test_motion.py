from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.scenario.experiment import Experiment
from flexros.scenario.motion import fastest_moves
from flexros.scenario.scenario import Scenario, load_scenario
from flexros.trajectory.time_optimal.planner import TOLERANCE

FAST = {"type": "time_optimal", "points": 101}


def elbow(law: dict[str, Any] | None = None, **values: Any) -> Scenario:
    changes = {"trajectory.time_law": {**FAST, **(law or {})}, "trajectory.hold_after": 0.0}
    return load_scenario("elbow_moves").with_values({**changes, **values})


def largest_use(experiment: Experiment) -> float:
    return float(np.max(np.abs(experiment.reference.torque) / experiment.nominal.torque_limits))


def test_torques_of_the_feedforward_come_to_their_limit_and_not_beyond() -> None:
    experiment = Experiment.prepare(elbow())
    assert largest_use(experiment) == pytest.approx(1.0, abs=2 * TOLERANCE)


def test_share_of_the_torque_is_left_to_the_feedback() -> None:
    experiment = Experiment.prepare(elbow({"torque_share": 0.8}))
    assert largest_use(experiment) == pytest.approx(0.8, abs=2 * TOLERANCE)


def test_it_is_faster_than_the_same_path_with_the_time_law_of_the_scenario() -> None:
    slow = Experiment.prepare(load_scenario("elbow_moves"))
    assert Experiment.prepare(elbow()).trajectory.duration < 0.5 * slow.trajectory.duration


def test_speed_limit_holds_for_every_gear() -> None:
    experiment = Experiment.prepare(elbow({"speed_limit": [1.0, 1.5]}))
    speed = np.abs(experiment.trajectory.evaluate(experiment.reference.time, 1)[1]).max(axis=0)
    assert np.all(speed <= np.array([1.0, 1.5]) * (1.0 + TOLERANCE))
    assert speed[0] == pytest.approx(1.0, rel=1e-2)


def test_way_back_is_planned_by_itself() -> None:
    """Gravity and friction act otherwise; the time law mirrored would need more than the limit."""
    points = {"trajectory.path.points_from_start": [[0.6, 0.4]], "trajectory.return_to_start": True}
    experiment = Experiment.prepare(elbow(**points))
    there, back = experiment.trajectory.moves
    assert there.law.duration != pytest.approx(back.law.duration, rel=1e-6)
    np.testing.assert_allclose(experiment.trajectory.end, experiment.trajectory.start, atol=1e-12)
    assert largest_use(experiment) == pytest.approx(1.0, abs=2 * TOLERANCE)


@pytest.mark.slow
def test_repeated_circle_of_the_tool_with_limits_of_the_time_law() -> None:
    """One circle shakes the arm for the next: the limits hold for both."""
    law = {**FAST, "torque_limit": [2000, 1000], "smoothing": 0.2}
    changes = {"trajectory.time_law": law, "trajectory.repeat": 2}
    experiment = Experiment.prepare(load_scenario("circle_dae2").with_values(changes))
    largest = np.abs(experiment.reference.torque).max(axis=0)
    assert np.all(largest <= np.array([2000.0, 1000.0]) * (1.0 + 2 * TOLERANCE))
    assert np.max(largest / [2000.0, 1000.0]) > 0.97


def test_path_speed_is_the_speed_of_the_tool() -> None:
    law = {**FAST, "torque_limit": [2000, 1000], "path_speed": 0.15, "smoothing": 0.2}
    trajectory = Experiment.prepare(load_scenario("circle_dae2").with_values({"trajectory.time_law": law})).trajectory
    speed = np.linalg.norm(trajectory.evaluate(np.linspace(0.0, trajectory.duration, 500), 1)[1], axis=1)
    assert speed.max() == pytest.approx(0.15, rel=1e-3)


def test_smoothing_too_short_for_the_gears_is_lengthened() -> None:
    (move,) = fastest_moves(elbow({"points": 51, "smoothing": 0.01}))
    assert move.smoothing in (0.02, 0.04, 0.08)
    assert move.duration < 1.25 * move.least_duration
    assert move.excess <= TOLERANCE


def test_figures_of_the_moves() -> None:
    (move,) = fastest_moves(elbow())
    assert move.least_duration < move.duration < move.least_duration + 0.2
    assert sum(move.limiting().values()) == pytest.approx(1.0, abs=0.05)


def test_robot_without_limits_is_refused() -> None:
    with pytest.raises(InputError, match="neither torque nor speed limits"):
        fastest_moves(load_scenario("circle_dae"))


def test_scenario_without_a_path_is_refused() -> None:
    with pytest.raises(InputError, match="no trajectory"):
        fastest_moves(load_scenario("two_mass_step"))


def test_number_of_limits_is_that_of_the_motors() -> None:
    with pytest.raises(InputError, match="3 values"):
        fastest_moves(elbow({"torque_limit": [1000, 1000, 1000]}))
