"""Check for joints that were swapped between commands and positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray, IntArray
    from flexros.identify.frf.estimate.period_spectra import PeriodSpectra
    from flexros.identify.frf.frequency_response import FrequencyResponse
    from flexros.robot import Robot

PAIRING_MARGIN = 1.0
"""Least gain of the sum of relative gains by another pairing that is accepted (chosen)."""

MODEL_MARGIN = 1.5
"""Least ratio of the misfit to that of another order that is accepted (chosen)."""


def check_pairing(response: FrequencyResponse, label: str) -> None:
    """Reject commands that belong to the position of another joint, by the response alone.

    The matrix of relative gains G o G^-T does not depend on units. Its diagonal is at least 1 for every symmetric
    positive definite G, which the response to acceleration is where the robot is rigid (inverse inertia) and again
    above its resonances (inverse motor inertia); so the pairing with the largest sum is correct.

    Args:
        response: The response of one position.
        label: Name of the record, for messages.

    Raises:
        InputError: Another pairing fits clearly better; names the joints.
    """
    G = response.response
    if G.shape[1] != G.shape[2] or G.shape[1] < 2:
        return
    gain = np.median(np.real(G * np.swapaxes(np.linalg.pinv(G), 1, 2)), axis=0)
    best = _assignment(-gain)
    if np.sum(gain[best, np.arange(len(best))]) - np.trace(gain) < PAIRING_MARGIN:
        return
    column, row = next((j, int(i)) for j, i in enumerate(best) if i != j)
    raise InputError(
        f"{label}: swapped joints: the command of {response.input_names[column]} moves {response.output_names[row]}, "
        "not the joint of its name; correct the joint names of joint_commands or joint_states"
    )


def check_tracking(spectra: PeriodSpectra, names: tuple[str, ...], label: str) -> None:
    """Reject positions that follow the reference of another joint.

    Args:
        spectra: Spectra of whole periods at the excited lines.
        names: Names of the outputs, length n_y.
        label: Name of the record, for messages.

    Raises:
        InputError: Joints follow the reference of another joint; names them.
    """
    if spectra.reference is None or spectra.reference.shape[3] != len(names) or len(names) < 2:
        return
    Y, R = spectra.output.mean(axis=1), spectra.reference.mean(axis=1)
    power = np.sqrt(np.outer(np.sum(abs(Y) ** 2, axis=(0, 1)), np.sum(abs(R) ** 2, axis=(0, 1))))
    follows = abs(np.einsum("mfi,mfj->ij", Y, np.conj(R))) / np.maximum(power, 1e-300)
    best = _assignment(-follows)
    if np.sum(follows[best, np.arange(len(best))]) - np.trace(follows) < PAIRING_MARGIN:
        return
    column, row = next((j, int(i)) for j, i in enumerate(best) if i != j)
    raise InputError(
        f"{label}: swapped joints: {names[row]} follows the reference of {names[column]}, not its own; correct the "
        "joint names of joint_states and joint_commands, or those of joint_reference"
    )


def check_order(response: FrequencyResponse, robot: Robot, label: str) -> None:
    """Reject joints that fit the nominal robot clearly better in another order.

    Args:
        response: The response of one position.
        robot: The nominal robot.
        label: Name of the record, for messages.

    Raises:
        InputError: Another order of the joints fits better; names the joints.
    """
    if response.response.shape[1:] != (robot.n_motors, robot.n_motors) or robot.n_motors < 2:
        return
    model = nominal_response(response, robot)
    cost = _order_cost(response.as_quantity("acceleration").response, model)
    best = _search(cost)
    current, other = _total(cost, np.arange(robot.n_motors)), _total(cost, best)
    if current <= MODEL_MARGIN * other:
        return
    names = ", ".join(
        f"{response.output_names[i]} behaves like {response.output_names[j]}" for i, j in enumerate(best) if i != j
    )
    raise InputError(
        f"{label}: swapped joints: {names} of robot {robot.name} (misfit {current:.2g} against {other:.2g}); correct "
        "the joint names, or give the right robot"
    )


def nominal_response(response: FrequencyResponse, robot: Robot) -> ComplexArray:
    """Return the response of the nominal robot to accelerations at the measured position, in continuous time.

    Args:
        response: Measured response with frequencies and motor position.
        robot: The nominal robot.

    Returns:
        Response [rad/s^2/Nm], shape (F, M, M).
    """
    from flexros.robot.linear.positions import linearise_positions  # here, because it loads slowly

    linear = linearise_positions(robot, (), response.motor_position[None])
    mass, damping, stiffness, motor_rows = linear.mass[0], linear.damping[0], linear.stiffness[0], linear.motor_rows
    s = 2j * np.pi * response.frequency[:, None, None]
    drive = np.broadcast_to(np.eye(len(mass))[:, motor_rows], (len(s), len(mass), len(motor_rows)))
    return np.asarray(s**2 * np.linalg.solve(stiffness + s * damping + s**2 * mass, drive)[:, motor_rows])


def _order_cost(measured: ComplexArray, model: ComplexArray) -> FloatArray:
    """Return the mean squared logarithm of |G_ab| / |model_cd|, shape (M, M, M, M)."""
    level, nominal = (np.log(np.maximum(abs(part), 1e-300)) for part in (measured, model))
    difference = level[:, :, :, None, None] - nominal[:, None, None, :, :]
    return np.asarray(np.mean(np.minimum(difference**2, 9.0), axis=0))


def _total(cost: FloatArray, order: IntArray) -> float:
    """Return the misfit when joint a of the log is joint order[a] of the robot."""
    own = np.arange(len(order))
    return float(np.mean(cost[own[:, None], own[None, :], order[:, None], order[None, :]]))


def _search(cost: FloatArray) -> IntArray:
    """Find the order of the smallest misfit: from the diagonals, then by exchanging pairs while that improves it."""
    M = len(cost)
    own = np.arange(M)
    diagonal = cost[own[:, None], own[:, None], own[None, :], own[None, :]]
    candidates = []
    for start in (own, _assignment(diagonal.T)):
        order, improved = np.array(start), True
        while improved:
            improved = False
            for i in range(M):
                for j in range(i + 1, M):
                    other = order.copy()
                    other[[i, j]] = order[[j, i]]
                    if _total(cost, other) < _total(cost, order) - 1e-12:
                        order, improved = other, True
        candidates.append(order)
    return min(candidates, key=lambda order: _total(cost, order))


def _assignment(cost: FloatArray) -> IntArray:
    """Return for each column the row of the assignment with the smallest sum of costs."""
    from scipy.optimize import linear_sum_assignment  # here, because it loads slowly

    columns, rows = linear_sum_assignment(cost.T)
    return np.asarray(rows[np.argsort(columns)], dtype=np.int64)
