"""The periodic parts: lines, torque in the loop, bias, limits."""

from __future__ import annotations

import numpy as np

from flexros.identify.design.default_controller import default_controller
from flexros.identify.diagnosis_experiment.scales import scales_of
from flexros.identify.diagnosis_experiment.specification import DiagnosisSpecification
from flexros.identify.diagnosis_experiment.vibrations import Vibrations
from flexros.robot import load_robot


def maker(name: str) -> Vibrations:
    robot = load_robot(name)
    law = default_controller(robot, robot.sample_time)
    scales = scales_of(DiagnosisSpecification(), robot, robot.home)
    return Vibrations(robot, robot.home, law, robot.sample_time, scales)


def test_multisine_is_odd_with_empty_lines_for_detection() -> None:
    vibrations = maker("e12")
    made = vibrations.multisine(np.zeros(2), 4.5, 0.05, np.random.default_rng(1))
    period = 0.5 * 4.5 - 0.25
    lines = made.frequency * period
    np.testing.assert_allclose(lines, np.round(lines), atol=1e-9)
    assert np.all(np.round(lines) % 2 == 1)
    odd = np.arange(1, round(lines[-1]), 2)
    assert 0.15 * len(odd) < len(odd) - len(lines) < 0.35 * len(odd)


def test_multisine_of_a_short_time_still_repeats_once() -> None:
    made = maker("four_mass").multisine(np.zeros(1), 2.0, 0.05, np.random.default_rng(1))
    period = 0.5 * (made.duration - 2 * made.fade)
    t = np.linspace(made.fade, made.fade + period, 30)
    np.testing.assert_allclose(made.derivatives(t + period, 0), made.derivatives(t, 0), atol=1e-9)


def test_small_multisine_has_the_rms_torque_asked_for() -> None:
    """Rigid robot emps: torque = mass times acceleration plus viscous friction."""
    vibrations = maker("emps")
    made = vibrations.multisine(np.zeros(1), 8.0, 0.03, np.random.default_rng(1))
    motion = made.derivatives(np.arange(made.fade, made.duration - made.fade, 1e-3), 2)
    torque = 95.1089 * motion[2] + 203.5034 * motion[1]
    assert 0.8 < np.std(torque) / (0.03 * vibrations.scales.torque[0]) < 1.2


def test_large_multisine_is_kept_within_the_torque() -> None:
    vibrations = maker("emps")
    made = vibrations.multisine(np.zeros(1), 8.0, 1.0, np.random.default_rng(1))
    motion = made.derivatives(np.arange(made.fade, made.duration - made.fade, 1e-3), 2)
    peak = np.max(np.abs(95.1089 * motion[2] + 203.5034 * motion[1]))
    assert 0.6 < peak / vibrations.scales.torque[0] < 0.9


def test_bias_keeps_the_torque_on_one_side_for_most_of_the_time() -> None:
    vibrations = maker("emps")
    made = vibrations.multisine(np.zeros(1), 4.5, 0.03, np.random.default_rng(2), bias=0.4)
    acceleration = made.derivatives(np.arange(made.fade, made.fade + 1.5, 1e-3), 2)[2, :, 0]
    slow = np.convolve(acceleration, np.full(301, 1 / 301), "same")
    assert np.mean(np.sign(acceleration) == np.sign(slow)) > 0.85


def test_slow_reversals_have_a_frequency_of_their_own_per_motor() -> None:
    made = maker("six_axis").slow(np.zeros(6), 2.0, np.full(6, 1e-4), np.random.default_rng(1))
    assert len(set(made.frequency)) == 6
    assert np.count_nonzero(made.amplitude) == 6
