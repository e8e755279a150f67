"""Design of the monitor at a pose: gain of the observer model, filter of the disturbance torque, noise floors of both.

The observer model x^ is the nominal model, corrected by e = y - C x^ at every sample. For any gain K, its error x~ is

    x~_k+1 = F x~_k + B d_k - F K e_k,    e_k = C x~_k + v_k,

with the disturbance torque d and the noise v of the encoders. A second, linear Kalman filter, in which d is a random
walk, estimates x~ and d from e. The monitor evaluates d and the innovations of this filter. Observer model and filter
together are one linear system driven by v, from which their noise floors follow (Anderson and Moore 1979, chapters 4
and 5).
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
"""Levels of the white torque for the gain of the observer model: motion of a motor within 0.5 ms over the noise of its
encoder (chosen)."""
SLIGHT = 1e-3
"""Level of the white torque of the filter in addition to the disturbance torque, as `LEVELS` (chosen)."""
BANDWIDTH = 10.0
"""Bandwidth of the disturbance torque [Hz] (chosen)."""


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
        """Return the filter for several samples at once.

        Args:
            samples: Number of samples N; inputs and outputs are stacked sample after sample.
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
    """Observer gain, filter and noise floors at a pose of a robot.

    Attributes:
        pose: The linear model there.
        gain: Gain K of the observer model, shape (2 n, M).
        filter: From prediction errors of the observer model to innovations and disturbance torques, 2 M outputs; its
            state is that of the error x~ and d.
        spread: Standard deviation of the innovations by noise alone [rad or m], shape (M,).
        torque_spread: The same of the disturbance torque [Nm or N], shape (M,).
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
        gain: Gain of the observer model, from `motorwise_gain`, shape (2 n, M).

    Returns:
        The design.
    """
    torque_filter = _torque_filter(pose, noise, sample_time, gain)
    spread = np.sqrt(_variances(driven_by_noise(pose, gain, torque_filter), noise))
    M = len(noise)
    radius = float(np.abs(np.linalg.eigvals(torque_filter.A)).max())
    return Design(pose, gain, torque_filter, spread[:M], spread[M:], -1 / np.log(min(radius, 1 - 1e-6)))


def floor_ratios(found: Design, pose: LinearPose, noise: FloatArray) -> FloatArray:
    """Compute the noise floors of a robot whose linear model differs from that of the design.

    Args:
        found: The design.
        pose: Linear model of the robot.
        noise: Standard deviation of the encoders [rad or m], shape (M,).

    Returns:
        Variances of innovations, then of disturbance torques, over those of the design [1], shape (2 M,).
    """
    system = driven_by_noise(pose, found.gain, found.filter)
    return np.asarray(_variances(system, noise) / np.concatenate([found.spread, found.torque_spread]) ** 2)


def motorwise_gain(pose: LinearPose, noise: FloatArray, sample_time: float) -> FloatArray:
    """Compute the gain of the observer model: each motor follows its own encoder, as a mass driven by white torque.

    The arm is not corrected. It follows the motors through its springs and dampers, so that the observer is stable in
    every pose, unlike a filter for the whole robot in one pose. Of several levels the one whose slowest error decays
    fastest is used: a motor with too large a gain leaves its arm undamped.

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
    """Return the system from the noise of the encoders to the outputs of the filter.

    Args:
        pose: Linear model.
        gain: Gain of the observer model.
        found: Filter of the disturbance torque.
    """
    F, C, s = pose.transition, pose.readout, len(found.A)
    keep = F @ (np.eye(len(F)) - gain @ C)
    A = np.block([[keep, np.zeros((len(F), s))], [found.B @ C, found.A]])
    return LinearFilter(A, np.vstack([-F @ gain, found.B]), np.hstack([found.D @ C, found.C]), found.D)


def autocovariances(found: Design, pose: LinearPose, noise: FloatArray, lags: int) -> FloatArray:
    """Compute autocovariances of the outputs of the filter by noise alone, each over that at lag zero.

    Args:
        found: The design.
        pose: Linear model of the robot.
        noise: Standard deviation of the encoders [rad or m], shape (M,).
        lags: Number of lags, zero included.

    Returns:
        Those of the innovations of all motors, then of their disturbance torques, shape (lags, 2 M).
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
    """Return the variances of the outputs of a system driven by the noise of the encoders."""
    unit = float(np.mean(noise))
    power = np.diag((noise / unit) ** 2)
    P = stationary_covariance(system.A, system.B @ power @ system.B.T)
    return np.asarray(unit**2 * np.diag(system.C @ P @ system.C.T + system.D @ power @ system.D.T))


def _motorwise(pose: LinearPose, noise: FloatArray, sample_time: float, level: float) -> FloatArray:
    """Return the gain of every motor as a mass of its own, for a level of white torque."""
    n = len(pose.mass)
    gain = np.zeros((2 * n, len(noise)))
    step, seen = np.array([[1.0, sample_time], [0.0, 1.0]]), np.array([[1.0, 0.0]])
    pushed = float(torque_noise(1.0, level, sample_time)) * sample_time
    single = kalman_gain(step, seen, np.diag([0.0, pushed**2]), np.eye(1))[:, 0]
    for motor, row in enumerate(pose.readout[:, :n]):
        direction = row / (row @ row)
        gain[:n, motor], gain[n:, motor] = single[0] * direction, single[1] * direction
    return gain


def _torque_filter(pose: LinearPose, noise: FloatArray, sample_time: float, gain: FloatArray) -> LinearFilter:
    """Design the filter of observer errors and disturbance torques, in units of the mean encoder noise."""
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
