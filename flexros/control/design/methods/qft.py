"""Quantitative feedback theory: bounds of all plants, and a loop shaped within them."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from flexros.control.design.closed_loop import largest_eigenvalues
from flexros.control.design.methods.base import AbstractDesignMethod, Design, DesignProblem, as_linear
from flexros.control.design.qft_bounds import Specifications, excess
from flexros.control.design.tunable import TunableStructure
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

_FREQUENCIES = 120
"""Frequencies at which the bounds are kept [1] (chosen)."""
_UNSTABLE, _OUTSIDE = 1e3, 1e2
"""Penalties of an unstable loop and of an exceeded bound, over the logarithm of the noise (chosen)."""
_KEPT = 1e-3
"""Excess up to which a bound counts as kept [1] (chosen)."""
_SLOWEST = 1.0 - 2e-4
"""Largest eigenvalue that counts as stable [1] (chosen)."""


class Qft(AbstractDesignMethod):
    """A loop within the bounds of all plants, with the least torque caused by encoder noise.

    For every plant |S| < sensitivity, |T| < complementary, and the compliance |P S| below min(1, w / integral) /
    stiffness, which asks for integral action. At each frequency these are quadratic inequalities in the gain of the
    controller, see `flexros.control.design.qft_bounds`. A PID with second-order sections is shaped by CMA-ES: loops
    outside a bound or unstable cost more than any other, then the rms torque per noise counts (Horowitz 1993; Chait and
    Yaniv 1993 for the bounds).
    """

    method: ClassVar[str] = "qft"

    sensitivity: float = Field(default=2.4, gt=1.0, description="largest sensitivity [1]")
    complementary: float = Field(default=2.2, gt=1.0, description="largest complementary sensitivity [1]")
    stiffness: float = Field(default=15.0, gt=0.0, description="least dynamic stiffness [Nm/rad or N/m]")
    integral: float = Field(default=6.0, gt=0.0, description="frequency below which the stiffness rises [rad/s]")
    sections: int = Field(default=1, ge=0, le=6, description="second-order sections in addition to the PID [1]")
    trials: int = Field(default=1500, ge=1, description="loops tried [1]")
    seed: int = Field(default=1, ge=0, description="seed of the search [1]")

    def design(self, problem: DesignProblem) -> Design:
        """Shape a loop; see `AbstractDesignMethod.design`."""
        if problem.robot.n_motors != 1:
            raise InputError(
                f"qft designs the loop of one motor, but robot {problem.robot.name} has {problem.robot.n_motors}; "
                "choose lqg or pole_placement",
                "model",
            )
        try:
            import cma  # here, because it loads slowly
        except ImportError as error:
            raise InputError("the package cma is missing: python3 -m pip install 'flexros[design]'") from error
        frequency = self.frequencies(problem)
        template = self.template(problem, frequency)
        limits = self.specifications(frequency)
        structure, T = TunableStructure(sections=self.sections), problem.sample_time

        def cost(point: FloatArray) -> float:
            if np.max(np.abs(point)) > 14.0:
                return 3e2 * _UNSTABLE
            system = structure.system(structure.values(point), T)
            radius = float(np.max(largest_eigenvalues(problem.sampled, as_linear(system))))
            if not radius < _SLOWEST:
                return _UNSTABLE * (1.0 + min(100.0 * (radius - _SLOWEST), 100.0))
            K = system.response(frequency, T)[:, 0, 0]
            outside = float(np.max(np.maximum(excess(template, K, limits), 0.0)))
            return (_OUTSIDE * outside if outside > 0.0 else 0.0) + _noise_gain(template, K, frequency)

        start = structure.vector(structure.start())
        found = cma.fmin2(cost, start, 0.3, {"maxfevals": self.trials, "seed": self.seed, "verbose": -9})[0]
        system = structure.system(structure.values(np.asarray(found)), T)
        K = system.response(frequency, T)[:, 0, 0]
        worst = excess(template, K, limits)
        if cost(np.asarray(found)) >= _UNSTABLE:
            raise InputError("qft: no stable loop was found; weaken the specifications or give more trials")
        figures = {
            "largest excess over a bound": float(np.exp(np.max(worst)) - 1.0),
            "frequency of it [Hz]": float(frequency[int(np.argmax(worst))]),
            "bounds kept": float(np.max(worst) < _KEPT),
        }
        return Design(system, T, None, figures)

    def frequencies(self, problem: DesignProblem) -> FloatArray:
        """Return the frequencies at which the bounds are kept [Hz], shape (F,)."""
        return np.asarray(np.geomspace(self.integral / 100.0, 0.45 / problem.sample_time, _FREQUENCIES))

    def template(self, problem: DesignProblem, frequency: FloatArray) -> ComplexArray:
        """Return the responses of all plants from torque to motor position, shape (Q, F)."""
        plants = problem.sampled
        z = np.exp(2j * np.pi * frequency * plants.sample_time)[:, None, None]
        n = plants.A.shape[-1]
        rows = []
        for A, B, C in zip(plants.A, plants.B, plants.C, strict=True):
            rows.append((C @ np.linalg.solve(z * np.eye(n) - A, np.broadcast_to(B, (len(z), n, 1))))[:, 0, 0])
        return np.array(rows)

    def specifications(self, frequency: FloatArray) -> Specifications:
        """Return the limits at the frequencies."""
        compliance = np.minimum(1.0, 2 * np.pi * frequency / self.integral) / self.stiffness
        return Specifications(self.sensitivity, self.complementary, compliance)


def _noise_gain(template: ComplexArray, controller: ComplexArray, frequency: FloatArray) -> float:
    """Return the logarithm of the rms torque per white encoder noise, worst plant."""
    gain = np.abs(controller / (1.0 + template * controller)) ** 2
    return float(0.5 * np.log(np.max(np.trapezoid(gain, frequency, axis=1) / frequency[-1])))
