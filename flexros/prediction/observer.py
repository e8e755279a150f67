"""Gain of the predictor: a stationary Kalman filter around the robot at rest in a pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import expm, solve_discrete_are

from flexros.robot.linear.linearise import linear_model

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

ARM_SHARE = 0.3
"""Assumed torque noise on arm coordinates, relative to that on motors [1] (chosen)."""
DOUBLINGS = 40
"""Most doublings of the time over which noise is added up: 2^40 samples (chosen)."""
REFERENCE_STEP = 5e-4
"""Sample time for which the level of the torque noise is stated [s] (chosen)."""


@dataclass(frozen=True)
class ObserverGain:
    """Gain of the predictor and what it does to noise.

    Attributes:
        gain: K, shape (2 n, M) for the state [q, v] of n coordinates.
        spread: Standard deviation of the prediction errors without gap [rad or m], shape (M,).
        transition: Matrix of the error dynamics, e_x <- F (e_x) per sample, shape (2 n, 2 n).
        motion: Matrix of the motion over a sample without correction, shape (2 n, 2 n).
        taken: Covariance that tolerated torques add to the states per sample, shape (2 n, 2 n).
        error: Covariance of the corrected states without gap, shape (2 n, 2 n).
        readout: Matrix from states to motor positions, shape (M, 2 n).
        noise: Standard deviation of the measurement noise [rad or m], shape (M,).
        settling: Samples until an error of the start has decayed to a thousandth.
    """

    gain: FloatArray
    spread: FloatArray
    transition: FloatArray
    motion: FloatArray
    taken: FloatArray
    error: FloatArray
    readout: FloatArray
    noise: FloatArray
    settling: int

    def early(self, samples: int) -> FloatArray:
        """Return the standard deviation of the prediction errors behind a start that is known, without gap.

        Args:
            samples: Number of samples n.

        Returns:
            Standard deviations [rad or m], shape (n, M).
        """
        R, C = np.diag(self.noise**2), self.readout
        added = self.motion @ self.gain @ R @ self.gain.T @ self.motion.T + self.taken
        covariance, variances = np.zeros_like(self.error), np.empty((samples, len(R)))
        for k in range(samples):
            variances[k] = np.diag(C @ covariance @ C.T + R)
            covariance = self.transition @ covariance @ self.transition.T + added
        return np.sqrt(variances)

    def ahead(self, samples: int) -> FloatArray:
        """Return the standard deviation of the error of a prediction without gap, noise of the sample included.

        Args:
            samples: How far ahead it is made [samples].

        Returns:
            Standard deviations [rad or m], shape (M,).
        """
        covariance = self.error
        for _ in range(samples):
            covariance = self.motion @ covariance @ self.motion.T + self.taken
        result: FloatArray = np.sqrt(np.diag(self.readout @ covariance @ self.readout.T) + self.noise**2)
        return result


def observer_gain(
    robot: Robot,
    sample_time: float,
    level: float,
    noise: FloatArray,
    q_a: FloatArray | None = None,
    *,
    tolerated: FloatArray | None = None,
) -> ObserverGain:
    """Compute the gain of the stationary Kalman filter.

    The assumed process noise is white torque on every mass: on a motor of inertia J it has the standard deviation
    s = level sqrt(h / T) J sigma / T^2 with the noise sigma of its encoder and h = 0.5 ms, so that at T = h it moves
    the motor by `level` times that noise within one sample; on arm coordinates 0.3 times that.

    Args:
        robot: The robot.
        sample_time: Time T between two samples [s].
        level: Level of the torque noise [1]; the smaller, the finer the effects that show.
        noise: Standard deviation of the encoder noise [rad or m], shape (M,).
        q_a: Arm coordinates of the pose [rad or m], shape (N,); default: home.
        tolerated: White torque noise at the motors that counts as no gap [Nm or N], shape (M,); it replaces that of the
            level where it is larger, and is part of the spread. None for an exact model.

    Returns:
        Gain and error dynamics.
    """
    model = linear_model(robot, q_a)
    A, _, measurement, _ = model.matrices()
    F, C = expm(A * sample_time), measurement[: robot.n_motors]
    # all in units of the mean encoder noise, so that the equations stay within range
    unit = float(np.mean(noise))
    R = np.diag((np.asarray(noise, dtype=float) / unit) ** 2)
    allowed = np.zeros(len(model.mass))
    if tolerated is not None:
        allowed[list(robot.motor_rows)] = tolerated / unit
    level_of = level * _noise_of_kind(robot, noise) / unit
    torque = np.maximum(_torque_noise(model.mass, robot.n_arm, sample_time, level_of), allowed)
    G, taken = (_onto_states(model.mass, sample_time, size) for size in (torque, allowed))
    K = _kalman_gain(F, C, G, R)
    keep = np.eye(len(F)) - K @ C
    transition = F @ keep
    predicted = stationary_covariance(transition, F @ K @ R @ K.T @ F.T + taken @ taken.T)
    corrected = keep @ predicted @ keep.T + K @ R @ K.T
    return ObserverGain(
        gain=K,
        spread=unit * np.sqrt(np.diag(C @ predicted @ C.T + R)),
        transition=transition,
        motion=F,
        taken=unit**2 * taken @ taken.T,
        error=unit**2 * corrected,
        readout=C,
        noise=np.asarray(noise, dtype=float),
        settling=_settling(transition),
    )


def _noise_of_kind(robot: Robot, noise: FloatArray) -> FloatArray:
    """Return the mean noise of encoders that turn, or slide, as each coordinate does [rad or m], shape (n,)."""
    turns = np.zeros(robot.n_coordinates, dtype=bool)
    turns[: robot.n_arm] = [joint.rotary for joint in robot.joints]
    of_motors = np.array([motor.rotary for motor in robot.motors])
    turns[list(robot.motor_rows)] = of_motors
    means = {kind: float(np.mean(noise[of_motors == kind])) for kind in set(of_motors.tolist())}
    other = float(np.mean(noise))
    return np.array([means.get(kind, other) for kind in turns.tolist()])


def _torque_noise(mass: FloatArray, n_arm: int, sample_time: float, level: FloatArray) -> FloatArray:
    """Return the assumed torque noise on every coordinate, in units of the encoder noise, shape (n,)."""
    share = np.where(np.arange(len(mass)) < n_arm, ARM_SHARE, 1.0)
    torque: FloatArray = level * np.diag(mass) / sample_time**2 * share * np.sqrt(REFERENCE_STEP / sample_time)
    return torque


def _onto_states(mass: FloatArray, sample_time: float, torque: FloatArray) -> FloatArray:
    """Return the matrix by which torque noise of a sample, shape (n,), moves the states, shape (2 n, n)."""
    inverse = np.linalg.inv(mass) * sample_time
    return np.vstack([np.zeros(mass.shape), inverse * torque])


def _kalman_gain(F: FloatArray, C: FloatArray, G: FloatArray, R: FloatArray) -> FloatArray:
    """Solve for the stationary gain that corrects the state x of x <- F x + G w, y = C x + v, v of covariance R."""
    P = solve_discrete_are(F.T, C.T, G @ G.T, R)
    gain: FloatArray = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
    return gain


def _settling(transition: FloatArray) -> int:
    """Return the samples until the slowest motion has decayed to a thousandth."""
    slowest = float(np.abs(np.linalg.eigvals(transition)).max())
    return int(np.ceil(np.log(1e-3) / np.log(min(slowest, 1 - 1e-6))))


def stationary_covariance(transition: FloatArray, added: FloatArray) -> FloatArray:
    """Sum up noise in a stable system: S = F S F' + Q, by doubling of the time (Smith 1968).

    It stays accurate where positions and speeds differ by many orders of magnitude.

    Args:
        transition: Matrix F, shape (n, n).
        added: Covariance Q that every sample adds, shape (n, n).
    """
    covariance, power = added, transition
    for _ in range(DOUBLINGS):
        more = power @ covariance @ power.T
        covariance = covariance + more
        if np.all(np.abs(more) <= 1e-15 * np.abs(covariance)):
            break
        power = power @ power
    return covariance
