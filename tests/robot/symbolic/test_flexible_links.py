"""Links with assumed modes against beam theory, a subdivided chain, and Lagrange's equations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from flexros.arrays import FloatArray
from flexros.robot import Robot, robot_from_data
from flexros.robot.beam import clamped_modes
from flexros.robot.linear.linearise import linear_model

MASS, LENGTH, RIGIDITY, HUB = 1.2, 1.0, 100.0, 0.01
UNIT = np.sqrt(RIGIDITY / MASS / LENGTH**3)
"""Frequency of root 1 [rad/s]."""


def beam(modes: int, load: tuple[float, float] | None = None, **bending: float) -> Robot:
    link: dict[str, Any] = {
        "mass": MASS,
        "length": [LENGTH, 0, 0],
        "directions": {"rz": {"spring": "rigid", "motor": {"inertia": HUB}}},
        "bending": {"rz": {"rigidity": RIGIDITY, "modes": modes, **bending}},
    }
    bodies = [link] if load is None else [link, {"mass": load[0], "inertia": {"zz": load[1]}}]
    return robot_from_data(
        {"name": "beam", "bodies": bodies, "outputs": {"tool": {"pose": ["y"]}}, "controlled": "tool"}, "test robot"
    )


def frequencies(robot: Robot, *, held: bool) -> FloatArray:
    """Return the frequencies without damping [rad/s], with the hub held or free; without the motion as a whole."""
    linear = linear_model(robot)
    rows = [row for row in range(len(linear.mass)) if not (held and row in robot.gear_rows)]
    squares = eigh(linear.stiffness[np.ix_(rows, rows)], linear.mass[np.ix_(rows, rows)], eigvals_only=True)
    return np.asarray(np.sqrt(squares if held else squares[1:]))


def test_first_three_frequencies_of_a_clamped_beam() -> None:
    found = np.sqrt(frequencies(beam(3), held=True) / UNIT)
    np.testing.assert_allclose(found, [1.8751040687, 4.6940911330, 7.8547574382], rtol=1e-8)


def test_first_three_frequencies_of_a_clamped_beam_with_load() -> None:
    mass, inertia = 0.6, 0.02
    found = np.sqrt(frequencies(beam(3, (mass, inertia), tip_mass=mass, tip_inertia=inertia), held=True) / UNIT)
    theory = [mode.root for mode in clamped_modes(3, mass / MASS, inertia / (MASS * LENGTH**2))]
    np.testing.assert_allclose(found, theory, rtol=1e-8)


def test_first_three_frequencies_with_a_free_hub() -> None:
    """Pinned with the hub's inertia at one end, free at the other: within 0.1 % with four assumed modes."""
    hub = HUB / (MASS * LENGTH**2)

    def determinant(b: float) -> float:
        C, S, c, s = np.cosh(b), np.sinh(b), np.cos(b), np.sin(b)
        rows = [[1, 0, 1, 0], [-1, hub * b**3, 1, hub * b**3], [-c / C, -s / C, 1, S / C], [s / C, -c / C, S / C, 1]]
        return float(np.linalg.det(np.array(rows)))

    grid = np.linspace(0.5, 13.0, 4000)
    signs = np.sign([determinant(b) for b in grid])
    theory = [brentq(determinant, grid[k], grid[k + 1]) ** 2 for k in np.flatnonzero(signs[1:] != signs[:-1])[:3]]
    found = frequencies(beam(4), held=False)[:3] / UNIT
    np.testing.assert_allclose(found, theory, rtol=1e-3)


@pytest.mark.slow
def test_subdivided_chain_converges_to_the_beam() -> None:
    def chain(pieces: int) -> Robot:
        lengths = [0.5, *[1.0] * (pieces - 1), 0.5]
        bodies = []
        for number, share in enumerate(lengths):
            length, mass = share * LENGTH / pieces, share * MASS / pieces
            hub = {"spring": "rigid", "motor": {"inertia": HUB}}
            spring = {"spring": RIGIDITY * pieces / LENGTH}
            bodies.append(
                {
                    "mass": mass,
                    "center_of_mass": [length / 2, 0, 0],
                    "inertia": {"zz": mass * length**2 / 12},
                    "length": [length, 0, 0],
                    "directions": {"rz": spring if number else hub},
                }
            )
        outputs = {"tool": {"pose": ["y"]}}
        return robot_from_data({"name": "chain", "bodies": bodies, "outputs": outputs, "controlled": "tool"}, "test")

    exact = frequencies(beam(6), held=False)[:3]
    errors = [np.abs(frequencies(chain(pieces), held=False)[:3] / exact - 1) for pieces in (10, 20)]
    assert errors[1].max() < 5e-3
    np.testing.assert_allclose(errors[0] / errors[1], 4.0, rtol=0.1)


def spatial() -> Robot:
    """Links that bend in one and in two planes, rigid bodies between them, flexible and rigid gears, gravity."""
    motor = {"spring": "rigid", "motor": {"inertia": 0.1}}
    bodies: list[dict[str, Any]] = [
        {
            "mass": 2,
            "inertia": {"xx": 0.1, "yy": 0.12, "zz": 0.13},
            "center_of_mass": [0.01, 0.02, 0.1],
            "length": [0, 0, 0.3],
            "directions": {"rz": {"spring": 1e4, "motor": {"inertia": 1.0}}},
        },
        {
            "mass": 1.2,
            "length": [0, 0.8, 0],
            "inertia": {"yy": 0.002},
            "directions": {"rx": motor},
            "bending": {"rx": {"rigidity": 100, "modes": 2}, "rz": {"rigidity": 200, "modes": 1}},
        },
        {
            "mass": 0.5,
            "inertia": {"xx": 0.01, "yy": 0.01, "zz": 0.01},
            "center_of_mass": [0.1, 0, 0],
            "length": [0.2, 0, 0],
            "directions": {"rz": {"spring": 500}},
        },
        {
            "mass": 0.3,
            "length": [-0.6, 0, 0],
            "inertia": {"xx": 0.001},
            "directions": {"ry": motor},
            "bending": {"ry": {"rigidity": 30, "modes": 1}},
        },
        {"mass": 0.4, "inertia": {"xx": 0.003, "yy": 0.003, "zz": 0.003}},
    ]
    outputs = {"tool": {"pose": ["x", "y", "z"]}}
    data = {"name": "spatial", "gravity": [0.3, -1, -9.81], "bodies": bodies, "outputs": outputs, "controlled": "tool"}
    return robot_from_data(data, "test robot")


def test_motion_meets_the_equations_of_lagrange() -> None:
    robot = spatial()
    model, p, n = robot.model, robot.model.parameter_values, robot.n_coordinates
    rng = np.random.default_rng(0)
    q, v, wrench = 0.3 * rng.normal(size=n), rng.normal(size=n), np.array([3.0, -2.0, 5.0, 0.0, 0.0, 0.0])
    a = np.array(model.acceleration(q, v, np.zeros(3), wrench, p)).ravel()

    def mass(q: FloatArray) -> FloatArray:
        return np.array(model.mass_matrix(q, p), dtype=float)

    def lagrangian(q: FloatArray) -> float:
        kinetic, potential = model.energy(q, v, p)
        return float(kinetic) - float(potential)

    def tool(q: FloatArray) -> FloatArray:
        return robot.tool_pose(q[: robot.n_arm])[:3]

    h, basis = 1e-5, np.eye(n)
    change = (mass(q + h * v) @ (v + h * a) - mass(q - h * v) @ (v - h * a)) / (2 * h)
    gradient = np.array([(lagrangian(q + h * e) - lagrangian(q - h * e)) / (2 * h) for e in basis])
    reach = np.array([(tool(q + h * e) - tool(q - h * e)) / (2 * h) for e in basis])
    np.testing.assert_allclose(change - gradient, reach @ wrench[:3], atol=1e-6 * np.abs(change).max())


def test_mass_matrix_is_symmetric_and_positive() -> None:
    robot = spatial()
    q = 0.3 * np.random.default_rng(1).normal(size=robot.n_coordinates)
    M = np.array(robot.model.mass_matrix(q, robot.model.parameter_values), dtype=float)
    np.testing.assert_allclose(M, M.T, atol=1e-13)
    assert np.linalg.eigvalsh(M)[0] > 0


def test_cantilever_hangs_by_its_own_weight() -> None:
    """w = rho g l^4 / (8 E I) at the tip (within the truncation after three modes)."""
    data = beam(3).spec.model_dump()
    data["gravity"]["value"] = (0.0, -9.81, 0.0)
    robot = robot_from_data(data, "test robot")
    tip = robot.tool_pose(robot.equilibrium(robot.home)[: robot.n_arm])[1]
    assert tip == pytest.approx(-MASS * 9.81 * LENGTH**3 / (8 * RIGIDITY), rel=1e-3)
