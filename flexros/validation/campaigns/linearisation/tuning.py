"""Tuning of the laws: equal bandwidth, or least tool deflection at equal robustness."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from flexros.analysis.control_loops import rest_signals
from flexros.control.base import control_law
from flexros.control.design.closed_loop import closed_loops
from flexros.control.design.margins import loop_response
from flexros.control.design.plants import linear_plants, sampled_plants
from flexros.control.linear_controller import LinearController, connected
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.control.design.plants import SampledPlants
    from flexros.robot import Robot
    from flexros.validation.campaigns.linearisation.laws import Axis, Law

SENSITIVITY, DELAY = 2.0, 1e-3
"""Largest sensitivity at any motor in any pose, with this delay of the loop [1, s]: what equal robustness means here
(chosen; it implies a gain margin of 2 and a phase margin of 29 degrees)."""
BANDWIDTHS = tuple(float(w) for w in np.geomspace(6.0, 240.0, 22))
"""Bandwidths that are tried [rad/s], about 19 % apart."""


@dataclass(frozen=True)
class Tuning:
    """A law with its numbers, and the linear loop that it makes.

    Attributes:
        bandwidth: Bandwidth w [rad/s].
        second: Second number of the law.
        sensitivity: Largest sensitivity at a motor over poses, with the delay of the tuning [1]; infinite if unstable.
        compliance: Rms of the tool under white force of 1 N and torques of 1 Nm at the motors, per sample, worst pose
            [um]; infinite if unstable.
        torque_noise: Rms of the torque that the noise of the encoders causes, largest motor and pose [Nm].
        gain_margin: Smallest factor above 1 on the gain of one motor's loop that makes it unstable [1].
        delay_margin: Smallest further delay that makes it unstable [s].
    """

    bandwidth: float
    second: float
    sensitivity: float
    compliance: float
    torque_noise: float
    gain_margin: float
    delay_margin: float

    def as_dict(self) -> dict[str, float | None]:
        """Return the figures for JSON; None where infinite."""
        return {key: value if np.isfinite(value) else None for key, value in asdict(self).items()}


class LinearLoops:
    """Linear sampled loops of a law about rest in the poses of the tuning.

    Args:
        law: The law.
        robot: The nominal robot with its encoders.
        axes: Its axes.
        poses: Arm coordinates [rad], each of length N.
        sample_time: Time between two samples [s].
    """

    def __init__(
        self, law: Law, robot: Robot, axes: tuple[Axis, ...], poses: tuple[tuple[float, ...], ...], sample_time: float
    ) -> None:
        self.law, self.robot, self.axes, self.poses, self.sample_time = law, robot, axes, poses, sample_time
        self._slopes: dict[float, tuple[ca.Function, ca.Function]] = {}

    @cached_property
    def plants(self) -> tuple[SampledPlants, ...]:
        """The sampled robot in every pose, with the delay of the tuning."""
        further = PlantModel(self.robot, sensors=self.robot.further_sensors).further if self.law.links else None
        return tuple(
            sampled_plants(
                linear_plants(self.robot, pose=np.array(pose), further=further), self.sample_time, delay=DELAY
            )
            for pose in self.poses
        )

    def tuning(self, bandwidth: float, second: float) -> Tuning:
        """Evaluate the loop of a bandwidth and a second number."""
        worst = Tuning(bandwidth, second, 0.0, 0.0, 0.0, np.inf, np.inf)
        for pose, plants in zip(self.poses, self.plants, strict=True):
            controller = connected(self._controller(bandwidth, second, pose))
            loop = closed_loops(plants, controller)[0]
            if not np.max(np.abs(np.linalg.eigvals(loop))) < 1.0 - 1e-9:
                return Tuning(bandwidth, second, np.inf, np.inf, np.inf, 0.0, 0.0)
            sensitivity, gain, delay = _margins(plants, controller)
            compliance, noise = _rms(plants, controller, loop, self._measurement_noise())
            worst = Tuning(
                bandwidth,
                second,
                max(worst.sensitivity, sensitivity),
                max(worst.compliance, compliance),
                max(worst.torque_noise, noise),
                min(worst.gain_margin, gain),
                min(worst.delay_margin, delay),
            )
        return worst

    def settings(self, bandwidth: float, second: float) -> dict[str, Any]:
        """Return the settings of the controller."""
        return self.law.settings(self.axes, bandwidth, second)

    def _measurement_noise(self) -> FloatArray:
        """Return the rms of all measurements, shape (n_measured,)."""
        noise = self.robot.spec.sensors.encoder_noise.value
        return np.full(self.plants[0].C.shape[1], noise)

    def _controller(self, bandwidth: float, second: float, pose: tuple[float, ...]) -> LinearController:
        """Linearise the law about rest in a pose, with its reference there."""
        law = control_law(self.settings(bandwidth, second))
        context = law.context(self.robot, self.sample_time)
        gains = law.gains(context)
        step, slopes = self._functions(bandwidth, second)
        r, y = rest_signals(context, np.array(pose))
        started = step(law.initial_state(context), r, y, gains)[1]
        from_c, from_y, of_c, of_y = (np.asarray(part, dtype=float) for part in slopes(started, r, y, gains))
        m, size = len(of_c), len(r)
        return LinearController(from_c, np.zeros((len(from_c), size)), from_y, of_c, np.zeros((m, size)), of_y)

    def _functions(self, bandwidth: float, second: float) -> tuple[ca.Function, ca.Function]:
        """Return update and slopes of the law; those of an observer with a design depend on the second number."""
        settings = self.settings(bandwidth, second)
        key = second if settings.get("observer", {}).get("kind") == "kalman" else 0.0
        if key not in self._slopes:
            law = control_law(settings)
            step = law.function(law.context(self.robot, self.sample_time))
            c, r, y, g = step.sx_in()
            u, after = step(c, r, y, g)
            parts = [ca.densify(ca.jacobian(out, part)) for out in (u, after) for part in (c, y)]
            self._slopes[key] = (step, ca.Function("slopes", [c, r, y, g], parts))
        return self._slopes[key]


def equally_robust(loops: LinearLoops, torque_noise: float) -> Tuning:
    """Find the numbers of least compliance among those whose sensitivity and torque noise are allowed.

    Args:
        loops: The loops of the law.
        torque_noise: Largest torque that the noise of the encoders may cause, rms [Nm].

    Returns:
        The best of all pairs that are tried; where none is allowed, the one of least sensitivity.
    """
    tried = [loops.tuning(w, second) for second in loops.law.second for w in BANDWIDTHS]
    allowed = [each for each in tried if each.sensitivity <= SENSITIVITY and each.torque_noise <= torque_noise]
    if not allowed:
        return min(tried, key=lambda each: each.sensitivity)
    return min(allowed, key=lambda each: each.compliance)


def _margins(plants: SampledPlants, controller: LinearController) -> tuple[float, float, float]:
    """Return largest sensitivity, gain margin and delay margin [s] over the motors."""
    frequency = np.geomspace(0.05, 0.4999 / plants.sample_time, 400)
    L = loop_response(plants, controller, frequency).loop[0]
    sensitivity = float(np.max(np.abs(1.0 / (1.0 + L))))
    gain, delay = np.inf, np.inf
    for loop in L.T:
        turns = np.flatnonzero((np.diff(np.sign(loop.imag)) != 0) & (loop.real[:-1] < 0.0) & (loop.real[:-1] > -1.0))
        gain = min(gain, float(np.min(-1.0 / loop.real[turns], initial=np.inf)))
        crossing = np.flatnonzero(np.diff(np.sign(np.abs(loop) - 1.0)) != 0)
        phase = np.mod(np.angle(loop[crossing]) + np.pi, 2 * np.pi)
        delay = min(delay, float(np.min(phase / (2 * np.pi * frequency[crossing]), initial=np.inf)))
    return sensitivity, gain, delay


def _rms(
    plants: SampledPlants, controller: LinearController, loop: FloatArray, noise: FloatArray
) -> tuple[float, float]:
    """Return rms of the tool under white disturbances [um], and of the torque under the noise of the encoders [Nm]."""
    n, motors = plants.A.shape[-1], plants.B.shape[-1]
    entry = np.zeros((len(loop), motors + 2))
    entry[:n, :motors], entry[:n, motors:] = plants.G[0][:, :motors], plants.G[0][:, [motors, motors + 2]]
    spread = _covariance(loop, entry @ entry.T)
    F = plants.F[0][[0, 2]]
    tool = float(np.sqrt(max(np.trace(F @ spread[:n, :n] @ F.T), 0.0)))
    measured = np.vstack([plants.B[0] @ controller.from_measured, controller.state_measured]) * noise
    spread = _covariance(loop, measured @ measured.T)
    gain = np.hstack([controller.from_measured @ plants.C[0], controller.from_state])
    direct = controller.from_measured * noise
    torque = np.diag(gain @ spread @ gain.T + direct @ direct.T)
    return 1e6 * tool, float(np.sqrt(np.max(torque)))


def _covariance(A: FloatArray, added: FloatArray) -> FloatArray:
    """Return P = A P A^T + added of a stable system, by doubling."""
    power, spread = A, added
    for _ in range(64):
        more = power @ spread @ power.T
        spread = spread + more
        if np.max(np.abs(more)) <= 1e-12 * np.max(np.abs(spread)):
            break
        power = power @ power
    return np.asarray(spread)
