"""Stationary Kalman filter on the robot linearised at rest."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar

import casadi
import numpy as np
from pydantic import Field

from flexros.control.model.sampled_model import SampledModel, kalman_gain, sampled_model
from flexros.control.observers.base import AbstractObserver, Estimate

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


class Kalman(AbstractObserver):
    """Stationary Kalman filter of the deviation from the reference.

        x = z + L (y - y_r - C z),   z+ = A x + B (u - u_ffw),   estimate = reference + x

    The model is the robot linearised at rest in one pose and sampled, with the delay of the command; the measurements
    are those of the encoders at motors and links (links only where the robot has them). L weighs white torques at the
    motors and white wrenches at the tool against the noise of the robot file. Deviations are small where the
    feedforward is good, so the filter follows wide motions too.
    """

    kind: ClassVar[str] = "kalman"

    torque_noise: float = Field(gt=0.0, description="white torque at every motor, rms over a sample [Nm]")
    force_noise: float = Field(default=0.0, ge=0.0, description="white force along each axis of the tool, rms [N]")
    moment_noise: float = Field(default=0.0, ge=0.0, description="white moment about each axis of the tool, rms [Nm]")
    pose: tuple[float, ...] | None = Field(
        default=None, description="arm coordinates of the design [rad or m]; default: home of the robot"
    )

    def measurements(self, context: LoopContext) -> tuple[str, ...]:
        """Return the measurements that the filter uses."""
        has_links = context.measurements.sizes.get("link_position", 0) == context.n_motors
        return ("motor_position", "link_position") if has_links else ("motor_position",)

    def design(self, context: LoopContext) -> tuple[SampledModel, FloatArray, FloatArray]:
        """Return the sampled model, L, and the covariance of the estimate, shape (n, n)."""
        model = sampled_model(context, self.measurements(context), self.pose)
        rms = (*[self.torque_noise] * context.n_motors, *[self.force_noise] * 3, *[self.moment_noise] * 3)
        gain, covariance = _gain(model, rms)
        return model, gain, covariance

    def check(self, context: LoopContext) -> None:
        """Refuse a robot whose encoders are without noise."""
        self.design(context)

    def state_size(self, context: LoopContext) -> int:
        """Return the number of states, those of the sampled model."""
        return sampled_model(context, self.measurements(context), self.pose).size

    def gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return the factor on the gain of the filter."""
        del context
        return {"observer.gain": 1.0}

    def estimate(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[Estimate, Callable[[casadi.SX], casadi.SX]]:
        """Estimate the states at a sample; see `AbstractObserver.estimate`."""
        context = signals.context
        model, gain, _ = self.design(context)
        names = self.measurements(context)
        deviation = casadi.vertcat(*[signals.measured(name) - signals.reference(name) for name in names])
        innovation = deviation - casadi.mtimes(casadi.sparsify(casadi.DM(model.C)), state)
        x = state + gains["observer.gain"] * casadi.mtimes(casadi.DM(gain), innovation)
        n = context.robot.n_coordinates
        motors, links = (list(map(int, rows)) for rows in model.positions)
        speeds = ([row + n for row in motors], [row + n for row in links])
        found = Estimate(
            signals.reference("motor_position") + x[motors],
            signals.reference("motor_velocity") + x[speeds[0]],
            signals.reference("link_position") + x[links],
            signals.reference("link_velocity") + x[speeds[1]],
        )
        moved = casadi.mtimes(casadi.sparsify(casadi.DM(model.A)), x)
        feedforward, B = signals.reference("feedforward_torque"), casadi.sparsify(casadi.DM(model.B))
        return found, lambda command: moved + casadi.mtimes(B, command - feedforward)


@lru_cache(maxsize=8)
def _gain(model: SampledModel, rms: tuple[float, ...]) -> tuple[FloatArray, FloatArray]:
    """Return L and the covariance of the estimate, once per model and noise."""
    return kalman_gain(model.A, model.C, (model.G * np.square(rms)) @ model.G.T, model.noise)
