"""Margins, sensitivity and steps of sampled loops, over all plants of a problem."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.control.design.closed_loop import closed_loops
from flexros.control.linear_controller import connected

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray
    from flexros.control.design.plants import SampledPlants
    from flexros.control.linear_controller import LinearController

_LOW, _POINTS = 1e-4, 3000
"""Lowest frequency over the sampling rate, and number of frequencies (chosen)."""
_BAND = 0.02
"""Band of the settling time of a step, over its size [1]."""
_STEP_SAMPLES = 20_000
"""Longest step response [samples] (chosen)."""


@dataclass(frozen=True)
class LoopMargins:
    """Margins of the loop at one motor, the other loops closed.

    Attributes:
        plant: Name of the plant.
        motor: Number of the motor, from 0.
        largest_eigenvalue: Largest absolute eigenvalue of the closed loop of all motors; stable below 1.
        gain_up: Smallest factor above 1 on the loop gain at which it is unstable [1], infinite for none.
        gain_down: Largest factor below 1 at which it is unstable [1], 0 for none.
        phase: Phase margin [rad], infinite without crossover.
        delay: Delay that makes it unstable [s], infinite without crossover.
        crossover_hz: Highest frequency at which the loop gain is 1 [Hz], 0 without.
        sensitivity: Largest absolute sensitivity |1 / (1 + L)| [1].
        complementary: Largest absolute complementary sensitivity |L / (1 + L)| [1].
        overshoot: Of the motor position after a step of its reference [1].
        settling: Time until it stays within 2 % [s]; infinite if it does not.
    """

    plant: str
    motor: int
    largest_eigenvalue: float
    gain_up: float
    gain_down: float
    phase: float
    delay: float
    crossover_hz: float
    sensitivity: float
    complementary: float
    overshoot: float
    settling: float

    def as_dict(self) -> dict[str, Any]:
        """Return the margins for JSON."""
        return {
            "plant": self.plant,
            "motor": f"motor_{self.motor + 1}",
            "stable": self.largest_eigenvalue < 1.0,
            "largest_eigenvalue": self.largest_eigenvalue,
            "gain_margin": self.gain_up,
            "lower_gain_margin": self.gain_down,
            "phase_margin_deg": float(np.degrees(self.phase)),
            "delay_margin": self.delay,
            "crossover_hz": self.crossover_hz,
            "sensitivity": self.sensitivity,
            "complementary_sensitivity": self.complementary,
            "overshoot": self.overshoot,
            "settling": self.settling,
        }


@dataclass(frozen=True, eq=False)
class LoopResponse:
    """Frequency responses of loops.

    Attributes:
        frequency: Frequencies [Hz], shape (F,).
        loop: Loop gain at each motor, the other loops closed, shape (Q, F, M).
        controller: From the measurements to the torques, sign of the error, shape (F, M, n_measured).
    """

    frequency: FloatArray
    loop: ComplexArray
    controller: ComplexArray


def frequency_grid(sample_time: float) -> FloatArray:
    """Return frequencies from far below any bandwidth to half the sampling rate [Hz]."""
    return np.asarray(np.geomspace(_LOW, 0.4999, _POINTS) / sample_time)


def loop_response(plants: SampledPlants, controller: LinearController, frequency: FloatArray) -> LoopResponse:
    """Return the loop gains at the plant input, by motor with the other loops closed.

    L_i = 1 / S_ii - 1 with S = (I + K P)^-1.

    Args:
        plants: Q sampled plants.
        controller: The controller.
        frequency: Frequencies below half the sampling rate [Hz], shape (F,).
    """
    z = np.exp(2j * np.pi * frequency * plants.sample_time)[:, None, None]
    m = len(controller.state_step)
    entry = np.broadcast_to(controller.state_measured, (len(z), *controller.state_measured.shape))
    memory = np.linalg.solve(z * np.eye(m) - controller.state_step, entry) if m else entry
    feedback = -(controller.from_state @ memory + controller.from_measured)
    n, motors = plants.A.shape[-1], plants.B.shape[-1]
    loops = []
    for A, B, C in zip(plants.A, plants.B, plants.C, strict=True):
        plant = C @ np.linalg.solve(z * np.eye(n) - A, np.broadcast_to(B, (len(z), n, motors)))
        sensitivity = np.linalg.inv(np.eye(motors) + feedback @ plant)
        loops.append(1.0 / np.diagonal(sensitivity, axis1=1, axis2=2) - 1.0)
    return LoopResponse(frequency, np.array(loops), np.asarray(feedback, dtype=complex))


def loop_margins(plants: SampledPlants, controller: LinearController) -> tuple[LoopMargins, ...]:
    """Return the margins of every plant and motor.

    Args:
        plants: Q sampled plants.
        controller: The controller; the reference of its motor positions gets the step.
    """
    controller = connected(controller)
    frequency = frequency_grid(plants.sample_time)
    response = loop_response(plants, controller, frequency)
    loops = closed_loops(plants, controller)
    radii = np.max(np.abs(np.linalg.eigvals(loops)), axis=-1)
    found = []
    for number, label in enumerate(plants.labels):
        for motor in range(plants.B.shape[-1]):
            L = response.loop[number, :, motor]
            up, down = _gain_margins(L)
            phase, delay, crossover = _phase_margin(L, frequency)
            stable = radii[number] < 1.0
            overshoot, settling = (
                _step(plants, controller, loops[number], number, motor) if stable else (np.inf, np.inf)
            )
            found.append(
                LoopMargins(
                    plant=label,
                    motor=motor,
                    largest_eigenvalue=float(radii[number]),
                    gain_up=up,
                    gain_down=down,
                    phase=phase,
                    delay=delay,
                    crossover_hz=crossover,
                    sensitivity=float(np.max(np.abs(1.0 / (1.0 + L)))),
                    complementary=float(np.max(np.abs(L / (1.0 + L)))),
                    overshoot=overshoot,
                    settling=settling,
                )
            )
    return tuple(found)


def step_response(
    plants: SampledPlants, controller: LinearController, number: int, motor: int, samples: int
) -> FloatArray:
    """Return the motor position after a unit step of its reference, shape (samples,).

    The reference of the link moves with it, rates and accelerations stay zero. Of a controller that ignores its
    reference the measurement steps, with the opposite sign.
    """
    controller = connected(controller)
    loop = closed_loops(plants, controller)[number]
    n = plants.A.shape[-1]
    moved = controller.position_columns(motor)
    direct, stored = controller.from_reference[:, moved].sum(axis=1), controller.state_reference[:, moved].sum(axis=1)
    if not np.any(direct) and not np.any(stored):
        direct, stored = -controller.from_measured[:, motor], -controller.state_measured[:, motor]
    entry = np.concatenate([plants.B[number] @ direct, stored])
    output = np.concatenate([plants.C[number][motor], np.zeros(len(loop) - n)])
    state, values = np.zeros(len(loop)), np.empty(samples)
    for sample in range(samples):
        values[sample] = output @ state
        state = loop @ state + entry
    return values


def _step(
    plants: SampledPlants, controller: LinearController, loop: FloatArray, number: int, motor: int
) -> tuple[float, float]:
    """Return overshoot and settling time; the length of the response follows the slowest eigenvalue."""
    radius = float(np.max(np.abs(np.linalg.eigvals(loop))))
    samples = int(min(max(np.log(1e-3) / np.log(min(radius, 1.0 - 1e-6)), 100.0), _STEP_SAMPLES))
    values = step_response(plants, controller, number, motor, samples)
    outside = np.flatnonzero(np.abs(values - 1.0) > _BAND)
    last = int(outside[-1]) + 1 if len(outside) else 0
    settling = last * plants.sample_time if last < samples else np.inf
    return float(max(np.max(values) - 1.0, 0.0)), float(settling)


def _gain_margins(L: ComplexArray) -> tuple[float, float]:
    """Return the smallest factor above 1 and the largest below 1 that put L on -1."""
    crossing = np.flatnonzero(np.diff(np.sign(L.imag)) != 0)
    share = L.imag[crossing] / (L.imag[crossing] - L.imag[crossing + 1])
    real = L.real[crossing] + share * (L.real[crossing + 1] - L.real[crossing])
    factors = -1.0 / real[real < 0.0]
    up, down = factors[factors > 1.0], factors[factors < 1.0]
    return float(np.min(up, initial=np.inf)), float(np.max(down, initial=0.0))


def _phase_margin(L: ComplexArray, frequency: FloatArray) -> tuple[float, float, float]:
    """Return the smallest phase margin [rad], delay margin [s] and the highest crossover [Hz]."""
    size = np.log(np.abs(L))
    crossing = np.flatnonzero(np.diff(np.sign(size)) != 0)
    if not len(crossing):
        return np.inf, np.inf, 0.0
    share = size[crossing] / (size[crossing] - size[crossing + 1])
    at = frequency[crossing] * (frequency[crossing + 1] / frequency[crossing]) ** share
    turned = np.angle(L[crossing + 1] / L[crossing])
    phase = np.mod(np.angle(L[crossing]) + share * turned + np.pi, 2 * np.pi)
    nearest = np.minimum(phase, 2 * np.pi - phase)
    return float(np.min(nearest)), float(np.min(phase / (2 * np.pi * at))), float(np.max(at))
