"""H-infinity loop shaping: the most robust controller of a weighted plant."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field
from scipy.linalg import LinAlgError, solve_continuous_are

from flexros.control.design.continuous import ContinuousSystem, delayed_plant, tustin
from flexros.control.design.methods.base import AbstractDesignMethod, Design, DesignProblem
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


class LoopShaping(AbstractDesignMethod):
    """Robust stabilisation of normalised coprime factors of the shaped plant, G W.

    W = gain (s + corner) / s (s^2 + 2 dz wz s + wz^2) / (s^2 + 2 dp wp s + wp^2). The controller is W times the
    one that maximises the stability margin 1 / gamma of the shaped plant, where the least gamma =
    sqrt(1 + rho(X Z)) is known from two Riccati equations (Glover and McFarlane 1989; McFarlane and Glover 1992). The
    plant is continuous, delay and hold as Pade approximation; the result is discretised with the bilinear transform.
    The first values are stable in every segment of `four_mass`; a published weight for its stiff segment (gain 52.3,
    corner 10, zeros 51.9 and 0.060, poles 48.2 and 0.060) is not.
    """

    method: ClassVar[str] = "loop_shaping"
    tunable: ClassVar[tuple[str, ...]] = (
        "gain",
        "corner",
        "zero_frequency",
        "zero_damping",
        "pole_frequency",
        "pole_damping",
        "slack",
        "stiffness_share",
    )

    gain: float = Field(default=750.0, gt=0.0, description="gain of the weight at high frequency [Nm/rad or N/m]")
    corner: float = Field(default=8.0, gt=0.0, description="corner of the integral part [rad/s]")
    zero_frequency: float = Field(default=57.0, gt=0.0, description="wz [rad/s]")
    zero_damping: float = Field(default=0.073, gt=0.0, description="dz [1]")
    pole_frequency: float = Field(default=360.0, gt=0.0, description="wp [rad/s]")
    pole_damping: float = Field(default=0.48, gt=0.0, description="dp [1]")
    slack: float = Field(default=0.28, gt=0.0, description="gamma over the least one, less 1 [1]")
    stiffness_share: float = Field(
        default=0.4, ge=0.0, le=1.0, description="design model between softest (0) and stiffest (1) spring segment [1]"
    )

    def design(self, problem: DesignProblem) -> Design:
        """Design the controller; see `AbstractDesignMethod.design`."""
        plant = delayed_plant(problem, self.stiffness_share, "loop_shaping")
        weight = self.weight()
        central, least = robust_stabiliser(weight.then(plant), 1.0 + self.slack)
        system = tustin(central.then(weight), problem.sample_time)
        figures = {"gamma": (1.0 + self.slack) * least, "least gamma": least, "stability margin": 1.0 / least}
        return Design(system, problem.sample_time, None, figures)

    def weight(self) -> ContinuousSystem:
        """Return the weight W."""
        integral = ContinuousSystem.of_polynomials([self.gain, self.gain * self.corner], [1.0, 0.0])
        zero, pole = (
            [1.0, 2.0 * damping * frequency, frequency**2]
            for frequency, damping in (
                (self.zero_frequency, self.zero_damping),
                (self.pole_frequency, self.pole_damping),
            )
        )
        return integral.then(ContinuousSystem.of_polynomials(zero, pole))


def robust_stabiliser(shaped: ContinuousSystem, slack: float) -> tuple[ContinuousSystem, float]:
    """Return the controller of the error that stabilises normalised coprime factors, and the least gamma.

    Args:
        shaped: Strictly proper plant.
        slack: gamma over the least one, above 1 [1].

    Raises:
        InputError: The Riccati equations have no solution.
    """
    A, B, C = shaped.A, shaped.B, shaped.C
    try:
        X = solve_continuous_are(A, B, C.T @ C, np.eye(B.shape[1]))
        Z = solve_continuous_are(A.T, C.T, B @ B.T, np.eye(len(C)))
    except (LinAlgError, ValueError) as error:
        raise InputError(
            f"loop_shaping: the Riccati equations have no solution ({error}); change the weight"
        ) from error
    least = float(np.sqrt(1.0 + np.max(np.linalg.eigvals(X @ Z).real)))
    gamma = slack * least
    scale = np.linalg.inv(((1.0 - gamma**2) * np.eye(len(A)) + X @ Z).T)
    entry: FloatArray = gamma**2 * scale @ Z @ C.T
    # with positive feedback this is the controller from y; the error is -y
    own = A - B @ B.T @ X + entry @ C
    return ContinuousSystem(own, -entry, B.T @ X, np.zeros((B.shape[1], len(C)))), least
