"""An elbow with elastic gears by equations of its own, in plain Python: friction that yields, ripple, and others."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from flexros.arrays import FloatArray

Pair = tuple[float, float]
GRAVITY = 9.81
UPPER, FOREARM_CENTER, UPPER_CENTER, REACH = 0.9, 0.35, 0.4, 0.8
"""Length of the upper arm, centres of mass, and length of the forearm [m]."""
STEP, SAMPLE_TIME = 1e-4, 2e-3
"""Integration step of the simulation and time between two samples of the log [s]."""
SETTLING = 1.5
"""Time under control before the log begins [s]."""
NOISE, ENCODER_STEP = 2e-6, 1.2e-6
"""Noise, rms, and step of the encoders [rad]."""
SLIDES = 1e-3
"""Speed over which rigid friction turns round [rad/s]."""
LIMITS = (3000.0, 2000.0)
"""Torque limits [Nm]."""
STIFF, DAMPED, SUMMED = (4e4, 1.5e4), (2500.0, 900.0), (2.4e5, 9e4)
"""Gains of the controller on positions [Nm/rad], speeds [Nm s/rad] and their sum [Nm/(rad s)]."""
HOME = (0.2, 0.3)
"""Pose around which the arm moves [rad]."""
FREQUENCIES = np.array([0.13, 0.31, 0.77, 1.9, 4.1, 7.3])
"""Frequencies of the reference, drawn within 10 % [Hz]."""
AMPLITUDES = np.array([0.25, 0.12, 0.05, 0.015, 0.004, 0.0015])
"""Their amplitudes, drawn within 30 % [rad]."""


@dataclass
class Numbers:
    """Numbers of the true arm, of joint 1 and 2; the defaults are those of the robot file.

    Attributes:
        mass: Masses of the bodies [kg].
        inertia: Their inertias about the centre of mass [kg m2].
        stiffness: Stiffness of the gears [Nm/rad].
        damping: Their damping [Nm s/rad].
        rotor: Rotor inertias at the joint [kg m2].
        viscous: Viscous friction [Nm s/rad].
        gain: Torque over command [1].
        bias: Constant torque [Nm].
        coulomb: Dry friction [Nm].
        hump: Further dry friction at standstill [Nm].
        hump_speed: Speed over which that falls [rad/s].
        bristles: Stiffness of the contacts, as in LuGre friction [Nm/rad]; zero for rigid ones.
        by_load: Dry friction over the torque of the gear [1].
        ripple: Amplitude of a torque that repeats with the angle of the joint [Nm].
        order: How often it does so per turn of the joint [1].
        hardening: Stiffness that a gear gains beyond its knee, over the stiffness [1].
        knee: Deflection of the knee [rad].
        gap: Half of the play of a gear [rad].
        late: Delay of the commands [s].
        load: Point mass at the end of the forearm [kg].
    """

    mass: list[float] = field(default_factory=lambda: [60.0, 45.0])
    inertia: list[float] = field(default_factory=lambda: [4.0, 3.0])
    stiffness: list[float] = field(default_factory=lambda: [2e5, 1e5])
    damping: list[float] = field(default_factory=lambda: [120.0, 60.0])
    rotor: list[float] = field(default_factory=lambda: [60.0, 25.0])
    viscous: list[float] = field(default_factory=lambda: [60.0, 30.0])
    gain: list[float] = field(default_factory=lambda: [1.0, 1.0])
    bias: list[float] = field(default_factory=lambda: [0.0, 0.0])
    coulomb: list[float] = field(default_factory=lambda: [0.0, 0.0])
    hump: list[float] = field(default_factory=lambda: [0.0, 0.0])
    hump_speed: list[float] = field(default_factory=lambda: [0.05, 0.05])
    bristles: list[float] = field(default_factory=lambda: [0.0, 0.0])
    by_load: list[float] = field(default_factory=lambda: [0.0, 0.0])
    ripple: list[float] = field(default_factory=lambda: [0.0, 0.0])
    order: list[float] = field(default_factory=lambda: [1.0, 1.0])
    hardening: list[float] = field(default_factory=lambda: [0.0, 0.0])
    knee: list[float] = field(default_factory=lambda: [2e-3, 1.5e-3])
    gap: list[float] = field(default_factory=lambda: [0.0, 0.0])
    late: float = 0.0
    load: float = 0.0


class Plant:
    """The true arm.

    Args:
        numbers: Its numbers.
    """

    def __init__(self, numbers: Numbers) -> None:
        self.numbers = numbers
        mass, load = numbers.mass[1], numbers.load
        self.forearm = mass + load
        self.center = (mass * FOREARM_CENTER + load * REACH) / self.forearm
        moved = mass * (self.center - FOREARM_CENTER) ** 2 + load * (REACH - self.center) ** 2
        self.forearm_inertia = numbers.inertia[1] + moved

    def slopes(self, state: list[float], command: Pair) -> list[float]:
        """Return the derivatives of motor and arm positions, of their speeds, and of the bristles."""
        one, motor_two, q1, q2, w1, w2, v1, v2, z1, z2 = state
        gears = (self._gear(0, one - q1, w1 - v1), self._gear(1, motor_two - q2, w2 - v2))
        rotors, bristles = [], []
        for k, (angle, speed, bent) in enumerate(((one, w1, z1), (motor_two, w2, z2))):
            dry, rate = self._friction(k, speed, bent, gears[k])
            of = self.numbers
            torque = of.gain[k] * command[k] + of.bias[k] + of.ripple[k] * math.sin(of.order[k] * angle)
            rotors.append((torque - dry - of.viscous[k] * speed - gears[k]) / of.rotor[k])
            bristles.append(rate)
        return [w1, w2, v1, v2, *rotors, *self._arm(q1, q2, v1, v2, gears), *bristles]

    def _gear(self, k: int, bent: float, rate: float) -> float:
        of = self.numbers
        if of.gap[k]:
            pressed = math.copysign(max(abs(bent) - of.gap[k], 0.0), bent)
            return of.stiffness[k] * pressed + (of.damping[k] * rate if pressed else 0.0)
        hard = abs(bent) - of.knee[k] * math.log1p(abs(bent) / of.knee[k])
        return of.stiffness[k] * (bent + of.hardening[k] * math.copysign(hard, bent)) + of.damping[k] * rate

    def _friction(self, k: int, speed: float, bent: float, gear: float) -> Pair:
        """Return dry friction and the rate at which its bristles bend."""
        of = self.numbers
        level = of.coulomb[k] + of.by_load[k] * abs(gear) + of.hump[k] * math.exp(-((speed / of.hump_speed[k]) ** 2))
        if of.bristles[k]:
            return of.bristles[k] * bent, speed - of.bristles[k] * abs(speed) / level * bent
        return math.tanh(speed / SLIDES) * level, 0.0

    def _arm(self, q1: float, q2: float, v1: float, v2: float, gears: Pair) -> Pair:
        of, m, c = self.numbers, self.forearm, self.center
        across, along = -UPPER * c * math.sin(q2), -UPPER * c * math.cos(q2)  # of the two bodies, and its slope
        second = self.forearm_inertia + m * c * c
        first = of.inertia[0] + of.mass[0] * UPPER_CENTER**2 + second + m * (UPPER**2 + 2 * across)
        both = second + m * across
        weight = -m * GRAVITY * c * math.cos(q1 + q2)
        weights = -(of.mass[0] * UPPER_CENTER + m * UPPER) * GRAVITY * math.sin(q1) + weight
        left = gears[0] - m * along * (2 * v1 * v2 + v2 * v2) - weights
        right = gears[1] + m * along * v1 * v1 - weight
        determinant = first * second - both * both
        return (second * left - both * right) / determinant, (first * right - both * left) / determinant

    def step(self, state: list[float], command: Pair) -> list[float]:
        """Take a Runge-Kutta step."""

        def ahead(rate: list[float], part: float) -> list[float]:
            return [x + part * STEP * dx for x, dx in zip(state, rate, strict=True)]

        a = self.slopes(state, command)
        b = self.slopes(ahead(a, 0.5), command)
        c = self.slopes(ahead(b, 0.5), command)
        d = self.slopes(ahead(c, 1.0), command)
        return ahead([(w + 2 * x + 2 * y + z) / 6 for w, x, y, z in zip(a, b, c, d, strict=True)], 1.0)


def recorded(numbers: Numbers, duration: float, seed: int) -> FloatArray:
    """Move the arm under a controller with integral action and the nominal weight; record it.

    Args:
        numbers: Numbers of the true arm.
        duration: Duration of the log [s].
        seed: Seed of reference and noise.

    Returns:
        Rows of time, measured positions and torque commands, shape (n, 5).
    """
    random = np.random.default_rng(seed)
    waves = [
        (
            AMPLITUDES * random.uniform(0.7, 1.3, 6),
            FREQUENCIES * random.uniform(0.9, 1.1, 6),
            random.uniform(0, 6.28, 6),
        )
        for _ in HOME
    ]
    plant, state = Plant(numbers), [*HOME, *HOME, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    within, late = round(SAMPLE_TIME / STEP), round(numbers.late / STEP)
    queue: list[Pair] = []
    rows, sums, before = [], [0.0, 0.0], np.array(HOME)
    for sample in range(round((SETTLING + duration) / SAMPLE_TIME)):
        time = sample * SAMPLE_TIME
        wanted = [_wave(time, *wave) for wave in waves]
        raw = np.array(state[:2]) + NOISE * random.standard_normal(2)
        measured = np.round(raw / ENCODER_STEP) * ENCODER_STEP
        forearm = GRAVITY * 45 * FOREARM_CENTER * math.cos(sum(HOME) + wanted[0][0] + wanted[1][0])
        upper = GRAVITY * (60 * UPPER_CENTER + 45 * UPPER) * math.sin(HOME[0] + wanted[0][0])
        weights, command = (-upper - forearm, -forearm), [0.0, 0.0]
        for k in range(2):
            error = HOME[k] + wanted[k][0] - measured[k]
            sums[k] += error * SAMPLE_TIME
            speed = (measured[k] - before[k]) / SAMPLE_TIME
            torque = weights[k] + STIFF[k] * error + DAMPED[k] * (wanted[k][1] - speed) + SUMMED[k] * sums[k]
            command[k] = float(np.clip(torque, -LIMITS[k], LIMITS[k]))
        before = measured
        rows.append((time, *measured, *command))
        for _ in range(within):
            queue = [*queue[-late:], (command[0], command[1])] if late else [(command[0], command[1])]
            state = plant.step(state, queue[0])
    return np.array(rows[round(SETTLING / SAMPLE_TIME) :])


def _wave(time: float, amplitudes: FloatArray, frequencies: FloatArray, phases: FloatArray) -> Pair:
    """Return a reference that grows from rest within a second, and its speed."""
    angles, grown, growing = 2 * np.pi * frequencies * time + phases, min(time, 1.0), float(time < 1)
    position = float(amplitudes @ np.sin(angles))
    return grown * position, grown * float(2 * np.pi * (amplitudes * frequencies) @ np.cos(angles)) + growing * position
