from __future__ import annotations

import numpy as np
import pytest

from flexros.analysis.cycles import Cycle, repetition, split_cycles


def circle(turns, samples_per_turn, rest=0):
    """Points of a circle passed `turns` times, with `rest` resting samples between."""
    once = np.linspace(0.0, 2 * np.pi, samples_per_turn + 1)
    smooth = once - np.sin(once)
    pieces = [smooth[:-1] if rest == 0 else np.append(smooth, np.full(rest - 1, smooth[-1])) for _ in range(turns)]
    angle = np.append(np.concatenate(pieces), 0.0) if rest == 0 else np.concatenate(pieces)
    return np.column_stack([np.cos(angle), np.zeros_like(angle), np.sin(angle)])


def run_of(points):
    return Cycle(np.arange(len(points)) * 1e-3, points, points)


def test_one_pass_is_one_cycle():
    assert repetition(circle(1, 500)) is None
    assert len(split_cycles(run_of(circle(1, 500)))) == 1


@pytest.mark.parametrize("turns", [2, 3, 10])
def test_passes_without_rest_are_counted(turns):
    cycles = split_cycles(run_of(circle(turns, 200)))
    assert len(cycles) == turns
    assert {len(cycle.time) for cycle in cycles} == {201}


def test_rest_between_passes_belongs_to_the_period_and_may_lack_at_the_end():
    points = circle(4, 200, rest=60)
    cycles = split_cycles(run_of(np.concatenate([np.repeat(points[:1], 30, axis=0), points])))
    assert len(cycles) == 4
    for cycle in cycles:
        assert cycle.arc_length()[-1] == pytest.approx(cycles[0].arc_length()[-1])


def test_a_pass_that_is_aborted_is_left_out():
    points = circle(3, 200)[:-80]
    assert len(split_cycles(run_of(points))) == 2


def test_passes_of_paths_that_differ_are_no_repetition():
    wide = circle(1, 2000) * 1.02 - np.array([0.02, 0.0, 0.0])
    assert repetition(np.concatenate([circle(1, 2000), wide[1:]])) is None


def test_going_there_and_back_is_one_cycle():
    way = np.concatenate([np.linspace(0, 1, 100), np.linspace(1, 0, 100)[1:]])
    line = np.concatenate([way, way[1:], way[1:]])
    points = np.column_stack([line, np.zeros_like(line), np.zeros_like(line)])
    cycles = split_cycles(run_of(points))
    assert len(cycles) == 3
    assert cycles[0].arc_length()[-1] == pytest.approx(2.0)


def test_a_path_at_rest_is_one_cycle():
    assert len(split_cycles(run_of(np.ones((50, 3))))) == 1
