from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from flexros.analysis.cycles import Cycle
from flexros.analysis.path_performance import path_performance
from flexros.errors import InputError


def line(n=2001, length=0.5, duration=1.0):
    s = np.linspace(0.0, 1.0, n)
    return s * duration, np.column_stack([s * length, np.zeros(n), np.zeros(n)])


def shifted(offset, delay=0.0):
    time, commanded = line()
    attained = commanded - np.array([0.5 * delay, 0.0, 0.0]) + np.asarray(offset)
    return Cycle(time, commanded, attained)


def test_copies_shifted_by_known_amounts_give_their_mean_and_spread():
    heights = np.array([1.0, 2.0, 4.0, 5.0]) * 1e-4
    performance = path_performance([shifted((0.0, 0.0, height)) for height in heights])
    distance = np.abs(heights - heights.mean())
    assert performance.cycles == 4
    assert performance.position_accuracy == pytest.approx(heights.mean(), rel=1e-9)
    expected = distance.mean() + 3 * distance.std(ddof=1)
    assert performance.position_repeatability == pytest.approx(expected, rel=1e-9)


def test_a_delay_along_the_path_is_no_path_error():
    performance = path_performance([shifted((0.0, 0.0, 0.0), delay=0.01)])
    assert performance.position_accuracy == pytest.approx(0.0, abs=1e-12)


def three_legs(offsets, heights=(0.0, 0.0, 0.0)):
    """There, back and there again, with an attained offset for each leg."""
    x = np.concatenate([np.linspace(0, 1, 200), np.linspace(1, 0, 200)[1:], np.linspace(0, 1, 200)[1:]])
    leg = np.concatenate([np.full(200, 0), np.full(199, 1), np.full(199, 2)])
    commanded = np.column_stack([x, np.zeros_like(x), np.array(heights)[leg]])
    return Cycle(np.arange(len(x), dtype=np.float64), commanded, commanded + np.array(offsets)[leg])


def test_a_crossing_of_another_part_of_the_path_does_not_count():
    # The tool starts ahead, so the first planes are not crossed on the first leg, but they are on the third one.
    cycle = three_legs([(1e-2, 0, 0), (0, 0, 0), (0, 0, 0)], heights=(0.0, 0.2, 0.4))
    performance = path_performance([cycle])
    assert performance.points < 200
    assert performance.position_accuracy <= 1e-2


def test_a_line_passed_twice_is_cut_at_the_pass_that_is_meant():
    performance = path_performance([three_legs([(0, 0, 1e-3), (0, 0, 2e-3), (0, 0, 3e-3)])])
    middle = np.searchsorted(performance.position, [0.5, 1.5, 2.5])
    np.testing.assert_allclose(performance.accuracy_along[middle], [1e-3, 2e-3, 3e-3], rtol=1e-6)


def test_one_cycle_has_no_repeatability():
    performance = path_performance([shifted((0.0, 1e-4, 0.0))])
    assert performance.position_repeatability is None
    assert performance.position_accuracy == pytest.approx(1e-4)


def test_mean_speed_on_the_constant_part_gives_the_velocity_accuracy():
    time, commanded = line()
    slow = commanded.copy()
    slow[:, 0] *= 0.98
    velocity = path_performance([Cycle(time, commanded, slow)]).velocity
    assert velocity is not None
    assert velocity.commanded == pytest.approx(0.5)
    assert velocity.accuracy == pytest.approx(-0.02, rel=1e-6)


def test_a_path_without_constant_speed_has_no_velocity_accuracy():
    time, commanded = line()
    s = time
    commanded[:, 0] = 0.5 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    assert path_performance([Cycle(time, commanded, commanded)]).velocity is None


def test_turned_copies_give_orientation_accuracy_and_repeatability_about_each_axis():
    time, commanded = line(n=301)
    goal = Rotation.from_euler("z", np.linspace(0.2, 0.8, len(time))[:, None])
    cycles = []
    for turn in (1e-3, 3e-3):
        actual = Rotation.from_rotvec([0.0, turn, 0.0]) * goal
        cycles.append(Cycle(time, commanded, commanded, goal.as_quat(), actual.as_quat()))
    performance = path_performance(cycles)
    np.testing.assert_allclose(performance.orientation_accuracy, [0.0, 2e-3, 0.0], atol=1e-8)
    spread = 3 * np.std([1e-3, 3e-3], ddof=1)
    np.testing.assert_allclose(performance.orientation_repeatability, [0.0, spread, 0.0], atol=1e-8)


def test_cycles_of_different_paths_are_refused():
    time, commanded = line(length=0.8)
    with pytest.raises(InputError, match=r"commanded paths of 0.5 to 0.8 m .* passes of one moving path"):
        path_performance([shifted((0, 0, 0)), Cycle(time, commanded, commanded)])


def test_a_tool_that_does_not_follow_is_refused():
    time, commanded = line()
    with pytest.raises(InputError, match=r"tool_pose crosses no plane normal .* does not follow tool_reference"):
        path_performance([Cycle(time, commanded, commanded + np.array([10.0, 0.0, 0.0]))])
