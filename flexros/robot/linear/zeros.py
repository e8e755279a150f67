"""Poles, zeros and zero dynamics of a linearised robot, and its minimum-phase property."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.robot.linear.linearise import LinearModel, linear_model

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from flexros.arrays import ComplexArray, FloatArray
    from flexros.robot.robot import Robot

RANK_TOLERANCE = 1e-9
"""Singular values below this share of the largest count as zero in the reduction."""

WELL_CONDITIONED = 1e4
"""Condition number up to which a generalised eigenvalue problem is solved as an ordinary one [1], chosen."""


@dataclass(frozen=True)
class ZeroDynamics:
    """Zero dynamics: the motion that remains with the controlled output held.

    Attributes:
        eigenvalues: Eigenvalues [1/s], shape (n,).
        unstable: Those with positive real part.
        solvable: Whether the gear torques can set all components of the output independently at the pose.
        output: Name of the output.
        pose: Arm coordinates, shape (N,).
    """

    eigenvalues: ComplexArray
    unstable: ComplexArray
    solvable: bool
    output: str
    pose: FloatArray

    @property
    def minimum_phase(self) -> bool:
        """Whether a causal, bounded inverse exists at this pose."""
        return self.solvable and self.unstable.size == 0


def poles(linear: LinearModel) -> ComplexArray:
    """Return the poles [1/s] of the linear model, shape (2 n,), by ascending magnitude."""
    A, _, _, _ = linear.matrices()
    return _sorted(np.linalg.eigvals(A))


def channel_zeros(linear: LinearModel, motor: int, measurement: int) -> ComplexArray:
    """Return the zeros [1/s] of one channel by ascending magnitude.

    Args:
        linear: The linear model.
        motor: Index of the motor torque.
        measurement: Index of the measurement: motor positions first, then components of the output.
    """
    A, B, C, D = linear.matrices()
    rows, columns = [measurement], [motor]
    return invariant_zeros(A, B[:, columns], C[rows], D[np.ix_(rows, columns)])


def transmission_zeros(linear: LinearModel) -> ComplexArray:
    """Return the zeros [1/s] of the square system from all motor torques to the controlled output, ascending."""
    A, B, C, D = linear.matrices()
    rows = slice(len(linear.encoder), None)
    return invariant_zeros(A, B, C[rows], D[rows])


def zero_dynamics(robot: Robot, q_a: ArrayLike | None = None, output: str | None = None) -> ZeroDynamics:
    """Compute the internal motion of the arm with the output held by gear torques (Moberg 2007, Paper B, section 3.2).

    Without inertial coupling they are the zeros from gear torques to the output of the arm alone. Gear dampers add
    zeros at -stiffness/damping to the transmission zeros, which are always stable. With inertial coupling the rotors'
    accelerations act on the arm, including its elastic directions, and cannot be eliminated: the zero dynamics are then
    the transmission zeros from motor torques to the output.

    Args:
        robot: The robot.
        q_a: Arm coordinates [rad or m], shape (N,); default: the home pose.
        output: Name of the output; default: the controlled one.

    Returns:
        Eigenvalues and verdict.

    Raises:
        InputError: Invalid pose, unknown output, or no equilibrium.
    """
    linear = linear_model(robot, q_a, output)
    if robot.spec.inertial_coupling:
        A, B, C, D = linear.matrices()
        C, D = C[len(linear.encoder) :], D[len(linear.encoder) :]
    else:
        A, B, C, D = _arm_alone(robot, linear)
    solvable = C.shape[0] == B.shape[1] and _invertible(A, B, C)
    eigenvalues = invariant_zeros(A, B, C, D) if solvable else np.zeros(0, dtype=complex)
    return ZeroDynamics(
        eigenvalues=eigenvalues,
        unstable=eigenvalues[eigenvalues.real > 1e-6 * (1.0 + np.abs(eigenvalues))],
        solvable=solvable,
        output=output or robot.controlled,
        pose=linear.state[: robot.n_arm],
    )


def _arm_alone(robot: Robot, linear: LinearModel) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return the first-order form of the arm alone from gear torques to the output."""
    N = robot.n_arm
    gear_torque = np.eye(N)[:, list(robot.gear_rows)]
    inverse = np.linalg.inv(linear.mass[:N, :N])
    A = np.block(
        [[np.zeros((N, N)), np.eye(N)], [-inverse @ linear.stiffness[:N, :N], -inverse @ linear.damping[:N, :N]]]
    )
    B = np.vstack([np.zeros_like(gear_torque), inverse @ gear_torque])
    C = np.hstack([linear.output[:, :N], np.zeros((len(linear.output), N))])
    return A, B, C, np.zeros((C.shape[0], B.shape[1]))


def _invertible(A: FloatArray, B: FloatArray, C: FloatArray) -> bool:
    """Return whether the transfer matrix has full rank at a generic point."""
    s = (0.37 + 1.3j) * float(np.sqrt(np.max(np.abs(A))))
    response = C @ np.linalg.solve(s * np.eye(len(A)) - A, B)
    singular = np.linalg.svd(response, compute_uv=False)
    return bool(singular[-1] > 1e-9 * singular[0])


def invariant_zeros(A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray) -> ComplexArray:
    """Compute the invariant zeros of a linear system by orthogonal reduction (Emami-Naeini, Van Dooren 1982).

    The reduction removes infinite zeros before any eigenvalue is computed, so that zeros at infinity of high order
    (torque to tool has relative degree 3 or 4) do not appear as large false zeros.

    Args:
        A: Shape (n, n).
        B: Shape (n, m).
        C: Shape (p, n).
        D: Shape (p, m).

    Returns:
        Zeros [1/s] by ascending magnitude.
    """
    A, B, C, D, speed = _scaled(A, B, C, D)
    A, B, C, D = _reduce(A, B, C, D)
    A, C, B, D = _reduce(A.T, C.T, B.T, D.T)
    A, B, C, D = A.T, B.T, C.T, D.T
    n = len(A)
    if n == 0:
        return np.zeros(0, dtype=complex)
    if D.size == 0:
        return _sorted(speed * np.linalg.eigvals(A))
    _, _, Vh = np.linalg.svd(np.hstack([C, D]))
    W = Vh.T[:, -n:]
    values = _generalised_eigenvalues(np.hstack([A, B]) @ W, W[:n])
    return _sorted(speed * values[np.isfinite(values)])


def _generalised_eigenvalues(A: FloatArray, B: FloatArray) -> ComplexArray:
    """Return the s with det(A - s B) = 0, infinite ones among them, shape (n,)."""
    if np.linalg.cond(B) < WELL_CONDITIONED:
        return np.asarray(np.linalg.eigvals(np.linalg.solve(B, A)), dtype=complex)
    from scipy.linalg import eigvals  # loads slowly

    return np.asarray(eigvals(A, B))


def _scaled(
    A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, float]:
    """Scale time, states, inputs and outputs to blocks of order one, for robust rank decisions."""
    n = len(A) // 2
    speed = float(np.sqrt(np.max(np.abs(A)))) if A.size else 1.0
    weights = np.ones(len(A))
    weights[n:] = 1.0 / speed  # rates in units of speed
    A = A * weights[:, None] / weights[None, :] / speed
    B, C = B * weights[:, None], C / weights[None, :]
    inputs = np.maximum(np.linalg.norm(B, axis=0), 1e-300)
    outputs = np.maximum(np.linalg.norm(C, axis=1), 1e-300)
    return A, B / inputs, C / outputs[:, None], D / outputs[:, None] / inputs, speed


def _rank(singular_values: FloatArray, scale: float) -> int:
    return int(np.sum(singular_values > RANK_TOLERANCE * scale))


def _reduce(
    A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Remove states until D has full row rank."""
    m = D.shape[1]
    scale = max(float(np.linalg.norm(np.block([[A, B], [C, D]]), 2)), 1e-300) if A.size else 1.0
    while len(A) and len(D):
        U, singular, _ = np.linalg.svd(D)
        rank = _rank(singular, scale)
        C, D = U.T @ C, U.T @ D
        tilde = C[rank:]
        if len(tilde) == 0:
            break
        _, singular, Vh = np.linalg.svd(tilde)
        removed = _rank(singular, scale)
        C, D = C[:rank], D[:rank]
        if removed == 0:
            break
        V = np.roll(Vh.T, -removed, axis=1)  # kept directions first
        kept = len(A) - removed
        A, B, C = V.T @ A @ V, V.T @ B, C @ V
        C = np.vstack([C[:, :kept], A[kept:, :kept]])
        D = np.vstack([D, B[kept:]])
        A, B = A[:kept, :kept], B[:kept]
    return A, B.reshape(len(A), m), C, D


def _sorted(eigenvalues: ArrayLike) -> ComplexArray:
    values = np.asarray(eigenvalues, dtype=complex)
    order = np.lexsort((values.imag, values.real, np.round(np.abs(values), 9)))
    return values[order]
