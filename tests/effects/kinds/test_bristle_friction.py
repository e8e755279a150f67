"""Bristles: the implicit equation of a step is solved by the few Newton passes that it gets."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from flexros.arrays import FloatArray
from flexros.effects.kinds import bristle_friction
from flexros.effects.kinds.bristle_friction import Bristle, bristle_step

STEP, STEPS = 5e-4, 20_000


def torques(passes: int, monkeypatch: pytest.MonkeyPatch) -> FloatArray:
    """Friction of random steps over its level, from resting bristles that hold to fast sliding, soft and stiff."""
    monkeypatch.setattr(bristle_friction, "PASSES", passes)
    z, v, a, mobility, stiffness, damping = (ca.SX.sym(name) for name in "zvamsd")
    held = bristle_step(z, v, a, mobility, Bristle(ca.SX(1.0), stiffness, damping), ca.SX(STEP))
    step = ca.Function("step", [z, v, a, mobility, stiffness, damping], [held.deflection, held.torque])
    rng = np.random.default_rng(1)
    m = 10 ** rng.uniform(0, 4, STEPS)
    s0 = 10 ** rng.uniform(-2, 4, STEPS) / (m * STEP**2)
    s1 = 10 ** rng.uniform(-2, 1, STEPS) * np.sqrt(s0 / m)
    speeds = rng.standard_normal(STEPS) * m * STEP * 10 ** rng.uniform(-1, 2, STEPS)
    pushed = rng.standard_normal(STEPS) * m * 10 ** rng.uniform(-1, 1, STEPS)
    return np.asarray(step(rng.uniform(-1, 1, STEPS) / s0, speeds, pushed, m, s0, s1)[1]).ravel()


def test_few_passes_solve_the_equation_of_a_step_as_many_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton's method doubles the digits with each pass, which it does with the true slope of the equation alone."""
    exact = torques(20, monkeypatch)
    two, three, four = (np.abs(torques(passes, monkeypatch) - exact) for passes in (2, 3, 4))
    assert np.quantile(two, 0.9) < 1e-3
    assert np.quantile(three, 0.9) < 1e-7
    assert np.quantile(four, 0.99) < 1e-3
