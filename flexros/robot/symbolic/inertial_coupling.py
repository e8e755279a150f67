"""Inertial coupling of rotors and arm: the complete flexible joint model (Moberg 2007, eq. 3.12; Tomei 1991)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.robot.specification import RobotSpecification
    from flexros.robot.symbolic.chain import Chain
    from flexros.robot.symbolic.dynamics import Motion
    from flexros.robot.symbolic.kinematics import Value


def matrix(
    specification: RobotSpecification, chain: Chain, values: Mapping[str, Value], moving: Motion, v_a: ca.SX
) -> ca.SX:
    """Compute the coupled inertia S(q_a).

    The rotor of motor i rotates by gear ratio times its coordinate about the joint axis fixed in the body before; with
    its inertia J_m on the arm side this adds J_m / ratio * (axis . omega) * v_m to the kinetic energy.

    Args:
        specification: The robot file.
        chain: Its joints.
        values: Value or symbol of every parameter by name.
        moving: Joint frames in motion.
        v_a: Rates of the arm coordinates in `moving`, SX (N, 1).

    Returns:
        S [kg m2], SX (N, number of motor coordinates); strictly upper triangular over the geared directions.
    """
    S = ca.SX.zeros(len(chain.joints), chain.n_motor_coordinates)
    for index, joint in enumerate(chain.joints):
        if joint.motor is None or joint.motor_coordinate is None or index == 0 or not joint.rotary:
            continue
        ratio = chain.motor(joint.motor).gear_ratio.value if specification.coordinates == "arm" else 1.0
        speed = ca.dot(ca.DM(joint.turn[:, joint.axis]), moving.angular[index - 1])
        momentum = values[f"motor_{joint.motor + 1}.inertia"] / ratio * speed
        S[:, joint.motor_coordinate] = ca.jacobian(momentum, v_a).T
    return S


def velocity_force(S: ca.SX, q_a: ca.SX, v_a: ca.SX, v_m: ca.SX) -> ca.SX:
    """Derive the velocity terms c_1, c_2 of equation 3.12 from the coupled energy v_a^T S(q_a) v_m, by Lagrange.

    Args:
        S: Coupled inertia, SX (N, number of motor coordinates).
        q_a: Arm coordinates, SX (N, 1).
        v_a: Their rates.
        v_m: Rates of the motor coordinates.

    Returns:
        Generalised force on [q_a, q_m], on the left-hand side of the equations of motion.
    """
    momentum_arm, momentum_motor = S @ v_m, S.T @ v_a
    energy = ca.dot(v_a, momentum_arm)
    arm = ca.jtimes(momentum_arm, q_a, v_a) - ca.gradient(energy, q_a)
    return ca.vertcat(arm, ca.jtimes(momentum_motor, q_a, v_a))


def solve_symmetric(A: ca.SX, b: ca.SX) -> ca.SX:
    """Solve A x = b by an unrolled L D L^T factorisation without pivoting.

    Args:
        A: Symmetric positive definite matrix, SX (n, n).
        b: Right-hand side, SX (n, 1).

    Returns:
        Solution, SX (n, 1).
    """
    return SymmetricFactors.of(A).solve(b)


@dataclass(frozen=True)
class SymmetricFactors:
    """Unrolled factorisation L D L^T of a symmetric positive definite matrix, without pivoting.

    Attributes:
        lower: Rows of L left of its diagonal of ones.
        inverse_pivots: Reciprocals of D.
    """

    lower: list[list[ca.SX]]
    inverse_pivots: list[ca.SX]

    @classmethod
    def of(cls, A: ca.SX) -> SymmetricFactors:
        """Factorise a matrix, SX (n, n)."""
        n = A.shape[0]
        L: list[list[ca.SX]] = [[] for _ in range(n)]
        pivots: list[ca.SX] = []
        for j in range(n):
            scaled = [L[j][k] * pivots[k] for k in range(j)]
            pivots.append(A[j, j] - _product(L[j], scaled))
            for i in range(j + 1, n):
                L[i].append((A[i, j] - _product(L[i], scaled)) * (1 / pivots[j]))
        return cls(L, [1 / pivot for pivot in pivots])

    def solve(self, b: ca.SX) -> ca.SX:
        """Solve A x = b for each column of b, SX (n, m)."""
        return ca.horzcat(*[self._solve_one(column) for column in ca.horzsplit(b)])

    def _solve_one(self, b: ca.SX) -> ca.SX:
        L, n = self.lower, len(self.lower)
        y: list[ca.SX] = []
        for i in range(n):
            y.append(b[i] - _product(L[i], y))
        x: list[ca.SX] = []
        for i in reversed(range(n)):
            behind = [L[k][i] for k in reversed(range(i + 1, n))]
            x.append(y[i] * self.inverse_pivots[i] - _product(behind, x))
        return ca.vertcat(*reversed(x))


def _product(one: list[ca.SX], other: list[ca.SX]) -> ca.SX:
    return sum((a * b for a, b in zip(one, other)), start=ca.SX(0))
