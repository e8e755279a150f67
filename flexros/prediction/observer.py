"""Observer design: stationary Kalman filters for white torque on every mass and white noise of the encoders.

Diagnosis, monitor and the identification of one axis share the torque noise, the gain and the noise propagation.
"""

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
"""Most doublings of the time over which noise is summed: 2^40 samples (chosen)."""
REFERENCE_STEP = 5e-4
"""Sample time for which the level of torque noise is stated [s] (chosen); at others it has the same power density."""


@dataclass(frozen=True)
class ObserverGain:
    """Gain of an observer, and its propagation of noise.

    Attributes:
        gain: K, shape (2 n, M) for the state [q, v] of n coordinates.
        spread: Standard deviation of the prediction errors without gap [rad or m], shape (M,).
        transition: Matrix of the error dynamics, e_x <- F (e_x) per sample, shape (2 n, 2 n).
        motion: Matrix of the motion over a sample without correction, shape (2 n, 2 n).
        taken: Covariance that tolerated torques add to the states per sample, shape (2 n, 2 n).
        error: Covariance of the corrected states without gap, shape (2 n, 2 n).
        readout: Matrix from states to motor positions, shape (M, 2 n).
        noise: Standard deviation of the measurement noise [rad or m], shape (M,).
        settling: Samples until an initial error has decayed to a thousandth.
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
        """Return the standard deviation of the prediction errors after a known initial state, without gap.

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

    @property
    def spread_of_noise(self) -> FloatArray:
        """Standard deviation of the prediction errors by measurement noise alone [rad or m], shape (M,)."""
        R, C, carried = np.diag(self.noise**2), self.readout, self.motion @ self.gain
        covariance = stationary_covariance(self.transition, carried @ R @ carried.T)
        result: FloatArray = np.sqrt(np.diag(C @ covariance @ C.T + R))
        return result

    def ahead(self, samples: int) -> FloatArray:
        """Return the standard deviation of the prediction error several samples ahead, noise included, without gap.

        Args:
            samples: Prediction horizon [samples].

        Returns:
            Standard deviations [rad or m], shape (M,).
        """
        return np.sqrt(self.variance_ahead(samples, self.readout) + self.noise**2)

    def variance_ahead(self, samples: int, readout: FloatArray) -> FloatArray:
        """Return the variance of outputs predicted several samples ahead, without gap and without their noise.

        Args:
            samples: Prediction horizon [samples].
            readout: Matrix from states to outputs, shape (n_outputs, 2 n).
        """
        covariance = self.error
        for _ in range(samples):
            covariance = self.motion @ covariance @ self.motion.T + self.taken
        result: FloatArray = np.diag(readout @ covariance @ readout.T).copy()
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
        level: Level of the torque noise [1]; a smaller one makes weaker effects visible.
        noise: Standard deviation of the encoder noise [rad or m], shape (M,).
        q_a: Arm coordinates of the pose [rad or m], shape (N,); default: home.
        tolerated: White torque noise at the motors within tolerance [Nm or N], shape (M,); with what the springs pass
            on of it. It replaces that of the level where it is larger, and is part of the spread. None for an exact
            model.

    Returns:
        Gain and error dynamics.
    """
    model = linear_model(robot, q_a)
    A, _, measurement, _ = model.matrices()
    F, C = expm(A * sample_time), measurement[: robot.n_motors]
    # in units of the mean encoder noise, which keeps the Riccati equation well scaled
    unit = float(np.mean(noise))
    R = np.diag((np.asarray(noise, dtype=float) / unit) ** 2)
    allowed = np.zeros(len(model.mass)) if tolerated is None else passed_on(robot, model.mass, tolerated) / unit
    level_of = level * _noise_of_kind(robot, noise) / unit
    share = np.where(np.arange(len(model.mass)) < robot.n_arm, ARM_SHARE, 1.0)
    torque = np.maximum(torque_noise(np.diag(model.mass), level_of, sample_time, sample_time) * share, allowed)
    G, taken = (_onto_states(model.mass, sample_time, size) for size in (torque, allowed))
    K = kalman_gain(F, C, G @ G.T, R)
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


def passed_on(robot: Robot, mass: FloatArray, torque: FloatArray) -> FloatArray:
    """Return the white torque at all coordinates that goes with one at the motors [Nm or N], shape (n,).

    With locked springs q = G q_m, motor torques u accelerate the motors by (G' M G)^-1 u, and the springs carry
    M G (G' M G)^-1 u to the arm. A model whose motor torques are known within a tolerance knows the torques in its
    springs no better. Without the latter nothing would correct an undamped arm.

    Args:
        robot: The robot.
        mass: Mass matrix M, shape (n, n).
        torque: Standard deviation of the independent torques at the motors u [Nm or N], shape (M,).
    """
    motors = list(robot.motor_rows)
    locked = np.zeros((len(mass), robot.n_motors))
    locked[: robot.n_arm] = robot.arm_from_gears(np.eye(robot.n_motors)).T
    locked[motors, np.arange(robot.n_motors)] = 1.0
    share = mass @ locked @ np.linalg.inv(locked.T @ mass @ locked)
    result = np.sqrt(share**2 @ torque**2)
    result[motors] = torque
    return result


def _noise_of_kind(robot: Robot, noise: FloatArray) -> FloatArray:
    """Return for each coordinate the mean noise of the rotary or prismatic encoders [rad or m], shape (n,)."""
    turns = np.zeros(robot.n_coordinates, dtype=bool)
    turns[: robot.n_arm] = [joint.rotary for joint in robot.joints]
    of_motors = np.array([motor.rotary for motor in robot.motors])
    turns[list(robot.motor_rows)] = of_motors
    means = {kind: float(np.mean(noise[of_motors == kind])) for kind in set(of_motors.tolist())}
    other = float(np.mean(noise))
    return np.array([means.get(kind, other) for kind in turns.tolist()])


def torque_noise(
    mass: FloatArray | float, level: FloatArray | float, sample_time: float, step: float = REFERENCE_STEP
) -> FloatArray:
    """Return the white torque sqrt(h / T) level J / step^2 that moves a mass by `level` within a step; h = 0.5 ms.

    Args:
        mass: Masses or inertias J [kg or kg m2], shape (n,) or a number.
        level: Motion within a step [rad or m, or in units of the encoder noise], shape (n,) or a number.
        sample_time: Time T between two samples [s], over which the torque is held.
        step: Time of that motion [s].

    Returns:
        Standard deviations of the torque of a sample [Nm or N, or per unit of the level], shape (n,).
    """
    return np.asarray(level * mass / step**2 * np.sqrt(REFERENCE_STEP / sample_time), dtype=float)


def _onto_states(mass: FloatArray, sample_time: float, torque: FloatArray) -> FloatArray:
    """Return the matrix from the torque noise of a sample, shape (n,), to the states, shape (2 n, n)."""
    inverse = np.linalg.inv(mass) * sample_time
    return np.vstack([np.zeros(mass.shape), inverse * torque])


def kalman_gain(F: FloatArray, C: FloatArray, Q: FloatArray, R: FloatArray) -> FloatArray:
    """Compute the stationary gain K that corrects the predicted state, x <- x + K (y - C x).

    Where encoders are so good that the eigenvalues of the Riccati equation cannot be sorted, it is solved by doubling.

    Args:
        F: Transition matrix of a sample, shape (s, s).
        C: Matrix from states to outputs, shape (m, s).
        Q: Covariance of the noise added to the state per sample, shape (s, s).
        R: Covariance of the output noise, shape (m, m).

    Returns:
        Gain, shape (s, m).

    Raises:
        numpy.linalg.LinAlgError: The Riccati equation has no stabilising solution.
    """
    try:
        P = solve_discrete_are(F.T, C.T, Q, R)
    except (np.linalg.LinAlgError, ValueError):  # the latter where the reordering of a QZ decomposition fails
        P = _riccati_by_doubling(F, C, Q, R)
    gain: FloatArray = P @ C.T @ np.linalg.inv(C @ P @ C.T + R)
    return gain


def _riccati_by_doubling(F: FloatArray, C: FloatArray, Q: FloatArray, R: FloatArray) -> FloatArray:
    """Solve P = F P (I + C' R^-1 C P)^-1 F' + Q by structure-preserving doubling (Anderson 1978).

    Step k is the covariance of the error after 2^k samples that begin without one. Arguments as for `kalman_gain`.

    Raises:
        numpy.linalg.LinAlgError: It does not converge.
    """
    A, G, H = F.T, C.T @ np.linalg.solve(R, C), Q
    for _ in range(DOUBLINGS):
        with np.errstate(over="ignore", invalid="ignore"):
            inverse = np.linalg.inv(np.eye(len(F)) + G @ H)
            A, G, H, before = A @ inverse @ A, G + A @ inverse @ G @ A.T, H + A.T @ H @ inverse @ A, H
            G, H = (G + G.T) / 2, (H + H.T) / 2
        if not np.all(np.isfinite(H)):
            break
        if np.abs(H - before).max() <= 1e-12 * np.abs(H).max():
            return H
    raise np.linalg.LinAlgError("the Riccati equation does not converge")


def _settling(transition: FloatArray) -> int:
    """Return the samples until the slowest mode has decayed to a thousandth."""
    slowest = float(np.abs(np.linalg.eigvals(transition)).max())
    return int(np.ceil(np.log(1e-3) / np.log(min(slowest, 1 - 1e-6))))


def stationary_covariance(transition: FloatArray, added: FloatArray) -> FloatArray:
    """Solve S = F S F' + Q for the covariance of a stable system driven by noise, by doubling (Smith 1968).

    The method stays accurate where positions and speeds differ by many orders of magnitude.

    Args:
        transition: Matrix F, shape (n, n).
        added: Covariance Q added per sample, shape (n, n).
    """
    covariance, power = added, transition
    for _ in range(DOUBLINGS):
        more = power @ covariance @ power.T
        covariance = covariance + more
        if np.all(np.abs(more) <= 1e-15 * np.abs(covariance)):
            break
        power = power @ power
    return covariance
