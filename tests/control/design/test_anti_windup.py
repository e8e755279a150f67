"""The anti-windup gain against the cases that are known in closed form."""

from __future__ import annotations

import numpy as np

from flexros.control.design.anti_windup import anti_windup_gain
from flexros.control.design.fixed_structure import biquad_system, pid_system

T = 5e-4


def test_minimum_phase_controller_gets_the_conditioning_of_hanus() -> None:
    system = pid_system(24.0, 100.0, 2.35, 2.6e-3, T).then(biquad_system(60.0, 0.4, 90.0, 0.7, T))
    found = anti_windup_gain(system.A, system.B, system.C, system.D)
    np.testing.assert_allclose(found, system.B / system.D, rtol=1e-3, atol=1e-6 * np.max(np.abs(system.B)))


def test_integrator_with_a_zero_outside_the_unit_circle_gets_a_stable_observer() -> None:
    A, B, C, D = np.array([[1.0]]), np.array([[1.0]]), np.array([[1.0]]), np.array([[-0.2]])
    found = anti_windup_gain(A, B, C, D)
    assert abs(A - B / D * C) > 1
    assert abs(A - found * C) < 1


def test_controller_without_direct_gain() -> None:
    A, B, C, D = np.array([[1.0, 0.1], [0.0, 0.9]]), np.array([[0.0], [1.0]]), np.array([[1.0, 0.0]]), np.zeros((1, 1))
    found = anti_windup_gain(A, B, C, D)
    assert np.max(np.abs(np.linalg.eigvals(A - found @ C))) < 1


def test_gain_alone_has_no_state() -> None:
    assert anti_windup_gain(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1))).shape == (0, 1)
