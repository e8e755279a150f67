"""Design of the monitor at a pose: gain of the twin, filter that tells the missing torque, floors of both.

The twin x^ is the nominal model, corrected by e = y - C x^ at every sample. Its error x~ follows, whatever the gain K,

    x~_k+1 = F x~_k + B d_k - F K e_k,    e_k = C x~_k + v_k,

with the torque d that the model misses and the noise v of the encoders. e is known, so that x~ and d can be estimated
from it by a second, linear Kalman filter, in which d walks at random. Its own prediction errors, the *sudden* part of
e, and d are what the monitor watches. Twin and filter together are one linear system driven by v, from which their
floors follow (Anderson and Moore 1979, chapters 4 and 5).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.prediction.observer import ARM_SHARE, kalman_gain, stationary_covariance, torque_noise

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.monitor.pose_model import LinearPose

LEVELS = tuple(10 ** (-5 + half / 2) for half in range(7))
"""White torque that the gain of the twin may allow for, as large as moves a motor by so many standard deviations of its
encoder within a sample of 0.5 ms (chosen)."""
SLIGHT = 1e-3
"""Level of the white torque of the filter in addition to the disturbance torque, as `LEVELS` (chosen)."""
BANDWIDTH = 10.0
"""Up to where the missing torque is told [Hz] (chosen)."""


@dataclass(frozen=True, eq=False)
class LinearFilter:
    """A linear filter, z <- A z + B e, with outputs C z + D e before the step.

    Attributes:
        A: Shape (s, s).
        B: Shape (s, inputs).
        C: Shape (outputs, s).
        D: Shape (outputs, inputs).
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray

    def lifted(self, samples: int) -> LinearFilter:
        """Give the filter that takes several samples at once.

        Args:
            samples: How many samples N are taken at once; inputs and outputs then have one sample after the other.
        """
        powers = [np.eye(len(self.A))]
        for _ in range(samples):
            powers.append(self.A @ powers[-1])
        none = np.zeros_like(self.D)
        response = [self.D, *(self.C @ power @ self.B for power in powers[: samples - 1])]
        rows = [[response[to - at] if to >= at else none for at in range(samples)] for to in range(samples)]
        inputs = np.hstack([power @ self.B for power in powers[samples - 1 :: -1]])
        outputs = np.vstack([self.C @ power for power in powers[:samples]])
        return LinearFilter(powers[samples], inputs, outputs, np.block(rows))


@dataclass(frozen=True, eq=False)
class Design:
    """What the monitor needs at a pose of a robot.

    Attributes:
        pose: The linear model there.
        gain: Gain K of the twin, shape (2 n, M).
        filter: From errors of the twin to their sudden part and the missing torques, 2 M outputs; its state is that of
            the error x~ and d.
        spread: Standard deviation of the sudden part by noise alone [rad or m], shape (M,).
        torque_spread: The same of the missing torque [Nm or N], shape (M,).
        settling: Time constant of the filter [samples].
    """

    pose: LinearPose
    gain: FloatArray
    filter: LinearFilter
    spread: FloatArray
    torque_spread: FloatArray
    settling: float


def design(pose: LinearPose, noise: FloatArray, sample_time: float, gain: FloatArray) -> Design:
    """Design the monitor at a pose.

    Args:
        pose: Linear model there.
        noise: Standard deviation of the encoders [rad or m], shape (M,).
        sample_time: Time between two samples [s].
        gain: Gain of the twin, from `twin_gain`, shape (2 n, M).

    Returns:
        The design.
    """
    found = _torque_filter(pose, noise, sample_time, gain)
    spread = np.sqrt(_variances(driven_by_noise(pose, gain, found), noise))
    M = len(noise)
    radius = float(np.abs(np.linalg.eigvals(found.A)).max())
    return Design(pose, gain, found, spread[:M], spread[M:], -1 / np.log(min(radius, 1 - 1e-6)))


def floors_elsewhere(found: Design, pose: LinearPose, noise: FloatArray) -> FloatArray:
    """Compute how noise shows in a robot that is not linear as the design takes it.

    Args:
        found: The design.
        pose: The robot as it is.
        noise: Standard deviation of the encoders [rad or m], shape (M,).

    Returns:
        Variances of sudden parts, then of missing torques, over those of the design [1], shape (2 M,).
    """
    system = driven_by_noise(pose, found.gain, found.filter)
    return np.asarray(_variances(system, noise) / np.concatenate([found.spread, found.torque_spread]) ** 2)


def twin_gain(pose: LinearPose, noise: FloatArray, sample_time: float) -> FloatArray:
    """Give the gain of the twin: each motor follows its own encoder, as a mass that white torque pushes.

    The arm is not corrected. It follows the motors through its springs and dampers, so that the twin is stable in every
    pose; a filter for the whole robot in one pose is not in others. Of several levels that one is taken whose slowest
    error decays fastest: a motor that is held too tightly lets its arm ring.

    Args:
        pose: Linear model in any pose.
        noise: Standard deviation of the encoders [rad or m], shape (M,).
        sample_time: Time T between two samples [s].

    Returns:
        Gain K, shape (2 n, M).
    """
    gains = [_motorwise(pose, noise, sample_time, level) for level in LEVELS]
    radii = [
        np.abs(np.linalg.eigvals(pose.transition @ (np.eye(len(gain)) - gain @ pose.readout))).max() for gain in gains
    ]
    return gains[int(np.argmin(radii))]


def driven_by_noise(pose: LinearPose, gain: FloatArray, found: LinearFilter) -> LinearFilter:
    """Give the system from the noise of the encoders to the outputs of the filter.

    Args:
        pose: Linear model.
        gain: Gain of the twin.
        found: Filter of the missing torque.
    """
    F, C, s = pose.transition, pose.readout, len(found.A)
    keep = F @ (np.eye(len(F)) - gain @ C)
    A = np.block([[keep, np.zeros((len(F), s))], [found.B @ C, found.A]])
    return LinearFilter(A, np.vstack([-F @ gain, found.B]), np.hstack([found.D @ C, found.C]), found.D)


def autocovariances(found: Design, pose: LinearPose, noise: FloatArray, lags: int) -> FloatArray:
    """Compute autocovariances of the outputs of the filter by noise alone, each over that at lag zero.

    Args:
        found: The design.
        pose: The robot as it is.
        noise: Standard deviation of the encoders [rad or m], shape (M,).
        lags: Number of lags, zero included.

    Returns:
        Those of the sudden parts of all motors, then of their missing torques, shape (lags, 2 M).
    """
    system = driven_by_noise(pose, found.gain, found.filter)
    power = np.diag((noise / float(np.mean(noise))) ** 2)
    P = stationary_covariance(system.A, system.B @ power @ system.B.T)
    result = np.empty((lags, len(system.C)))
    result[0] = np.diag(system.C @ P @ system.C.T + system.D @ power @ system.D.T)
    state = system.A @ P @ system.C.T + system.B @ power @ system.D.T
    for lag in range(1, lags):
        result[lag] = np.einsum("ij,ji->i", system.C, state)
        state = system.A @ state
    return np.asarray(result / result[0])


def _variances(system: LinearFilter, noise: FloatArray) -> FloatArray:
    """Give the variances of the outputs of a system that the noise of the encoders drives."""
    unit = float(np.mean(noise))
    power = np.diag((noise / unit) ** 2)
    P = stationary_covariance(system.A, system.B @ power @ system.B.T)
    return np.asarray(unit**2 * np.diag(system.C @ P @ system.C.T + system.D @ power @ system.D.T))


def _motorwise(pose: LinearPose, noise: FloatArray, sample_time: float, level: float) -> FloatArray:
    """Give the gain of every motor as a mass of its own, for a level of white torque."""
    n = len(pose.mass)
    gain = np.zeros((2 * n, len(noise)))
    step, seen = np.array([[1.0, sample_time], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    pushed = float(torque_noise(1.0, level, sample_time)) * sample_time
    one = kalman_gain(step, seen, np.diag([0.0, pushed**2]), np.eye(1))[:, 0]
    for motor, row in enumerate(pose.readout[:, :n]):
        direction = row / (row @ row)
        gain[:n, motor], gain[n:, motor] = one[0] * direction, one[1] * direction
    return gain


def _torque_filter(pose: LinearPose, noise: FloatArray, sample_time: float, gain: FloatArray) -> LinearFilter:
    """Solve for the filter of twin errors and missing torques, all in units of the mean encoder noise."""
    F, M, s = pose.transition, len(noise), len(pose.transition)
    n, unit = s // 2, float(np.mean(noise))
    push = pose.push @ pose.motor
    inertia = 1 / np.linalg.norm(push[n:] / sample_time, axis=0)
    # a triple integrator of white noise over white noise has its corner at (S_d / S_v)^(1/6)
    walk = inertia * (2 * np.pi * BANDWIDTH) ** 3 * noise * sample_time / unit
    share = np.full(n, ARM_SHARE)
    for motor, row in enumerate(pose.readout[:, :n]):
        share[int(np.argmax(np.abs(row)))] = noise[motor] / unit
    white = torque_noise(np.diag(pose.mass), SLIGHT * share, sample_time)
    pushed = pose.push[n:] * white
    Q = np.zeros((s + M, s + M))
    Q[n:s, n:s] = pushed @ pushed.T
    Q[s:, s:] = np.diag(walk**2)
    both = np.block([[F, push], [np.zeros((M, s)), np.eye(M)]])
    seen = np.hstack([pose.readout, np.zeros((M, M))])
    L = kalman_gain(both, seen, Q, np.diag((noise / unit) ** 2))
    keep = np.eye(s + M) - L @ seen
    known = np.vstack([F @ gain, np.zeros((M, M))])
    C = np.vstack([-seen, keep[s:]])
    return LinearFilter(both @ keep, both @ L - known, C, np.vstack([np.eye(M), L[s:]]))
