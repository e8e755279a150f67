"""A planar chain as test double of a robot, and a loop around it."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from flexros.compile import LoopFunctions, LoopInputs

SAMPLE_TIME = 5e-4
GAINS = np.array([300.0, 20.0, 40.0])
PARAMETERS = np.array([1.0, 2.0])
STATE = np.array([0.3, -0.5, 0.2, 0.31, -0.48, 0.1, -0.2, 0.3, 0.05, -0.1])


def chain_derivative() -> ca.Function:
    """Three links with gravity and springs, two motors behind the first two; p = [stiffness scale, payload]."""
    x, u, w, p = ca.SX.sym("x", 10), ca.SX.sym("u", 2), ca.SX.sym("w", 6), ca.SX.sym("p", 2)
    q, q_m, v, v_m = x[:3], x[3:5], x[5:8], x[8:]
    angle = ca.cumsum(q)
    tip = ca.vertcat(ca.sum1(0.5 * ca.sin(angle)), ca.sum1(0.5 * ca.cos(angle)))
    kinetic, potential = 0, 0
    for k, mass in enumerate((4.0, 3.0, p[1])):
        centre = ca.vertcat(ca.sum1(0.5 * ca.sin(angle[: k + 1])), ca.sum1(0.5 * ca.cos(angle[: k + 1])))
        speed = ca.jtimes(centre, q, v)
        kinetic += 0.5 * mass * ca.dot(speed, speed) + 0.05 * ca.sum1(v[: k + 1]) ** 2
        potential += 9.81 * mass * centre[1]
    mass_matrix = ca.hessian(kinetic, v)[0]
    force = ca.jtimes(ca.gradient(kinetic, v), q, v) - ca.gradient(kinetic, q) + ca.gradient(potential, q)
    twist = ca.vertcat(q_m - q[:2], -q[2])
    spring = p[0] * ca.vertcat(400.0, 300.0, 200.0) * twist + ca.vertcat(4.0, 3.0, 2.0) * ca.vertcat(v_m - v[:2], -v[2])
    tool = ca.jtimes(tip, q, w[:2], True)
    acceleration = ca.solve(mass_matrix, spring + tool - force)
    motor = (u - spring[:2]) / 0.3
    return ca.Function("derivative", [x, u, w, p], [ca.vertcat(v, v_m, acceleration, motor)])


def pd_controller() -> ca.Function:
    """u = kp e - kd dy/dt + ki sum(e) + feedforward, limited; c = [previous y, sum, started]."""
    c, r, y, g = ca.SX.sym("c", 5), ca.SX.sym("r", 6), ca.SX.sym("y", 2), ca.SX.sym("g", 3)
    before = ca.if_else(c[4] > 0.5, c[:2], y)
    total = c[2:4] + SAMPLE_TIME * (r[:2] - y)
    u = g[0] * (r[:2] - y) + g[1] * (r[2:4] - (y - before) / SAMPLE_TIME) + g[2] * total + r[4:]
    return ca.Function("controller", [c, r, y, g], [ca.fmax(-500, ca.fmin(500, u)), ca.vertcat(y, total, 1)])


def integrator() -> LoopFunctions:
    """dx/dt = u + first wrench component: shows when which command acts."""
    x, u, w, p = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("w", 6), ca.SX.sym("p", 0)
    c, r, y, g = ca.SX.sym("c", 0), ca.SX.sym("r"), ca.SX.sym("y"), ca.SX.sym("g", 0)
    return LoopFunctions(
        derivative=ca.Function("derivative", [x, u, w, p], [u + w[0]]),
        encoder=ca.Function("encoder", [x], [x]),
        tool_pose=ca.Function("tool_pose", [x, p], [ca.vertcat(x, 0, 0, 0, 0, 0, 1)]),
        controller=ca.Function("controller", [c, r, y, g], [r, c]),
    )


def unstable() -> LoopFunctions:
    """dx/dt = p x^3: reaches infinity in finite time."""
    x, u, w, p = ca.SX.sym("x"), ca.SX.sym("u"), ca.SX.sym("w", 6), ca.SX.sym("p")
    base = integrator()
    return replace(
        base,
        derivative=ca.Function("derivative", [x, u, w, p], [p * x**3]),
        tool_pose=ca.Function("tool_pose", [x, p], [ca.vertcat(x, 0, 0, 0, 0, 0, 1)]),
    )


def reference(samples: int) -> np.ndarray:
    t = np.arange(samples)[:, np.newaxis] * SAMPLE_TIME
    phase = 2 * np.pi * np.array([1.0, 1.7]) * t
    rate = 2 * np.pi * np.array([1.0, 1.7])
    return np.hstack([0.2 * np.sin(phase), 0.2 * rate * np.cos(phase), 3 * np.cos(phase)])


def rich_inputs(samples: int, seed: int = 0) -> LoopInputs:
    rng = np.random.default_rng(seed)
    return LoopInputs(
        reference=reference(samples),
        noise=rng.normal(size=(samples, 2)) * 1e-4,
        disturbance=rng.normal(size=(samples, 8)) * 2.0,
        parameters=PARAMETERS,
        gains=GAINS,
    )


@pytest.fixture(scope="session")
def chain() -> LoopFunctions:
    q_a, q, p = ca.SX.sym("q_a", 3), ca.SX.sym("q", 5), ca.SX.sym("p", 2)
    angle = ca.cumsum(q_a)
    half = ca.sum1(q_a) / 2
    pose = ca.vertcat(ca.sum1(0.5 * ca.sin(angle)), 0, ca.sum1(0.5 * ca.cos(angle)), 0, ca.sin(half), 0, ca.cos(half))
    return LoopFunctions(
        derivative=chain_derivative(),
        encoder=ca.Function("encoder", [q], [q[3:]]),
        tool_pose=ca.Function("tool_pose", [q_a, p], [pose]),
        controller=pd_controller(),
    )
