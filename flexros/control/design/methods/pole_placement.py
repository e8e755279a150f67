"""Pole placement: state feedback and observer with chosen poles, and an estimated disturbance torque."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field
from scipy.signal import place_poles

from flexros.control.design.estimator import disturbance_plant, estimator_controller
from flexros.control.design.methods.base import AbstractDesignMethod, Design, DesignProblem
from flexros.errors import InputError

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray, FloatArray

_APART = 1e-3
"""Relative distance of poles that would coincide (chosen): placement needs them apart."""


class PolePlacement(AbstractDesignMethod):
    """Poles of regulator and observer are placed; vibrations keep their frequency and get a damping.

    The two slowest poles per motor (the rigid motion) get a bandwidth and a damping, the others keep their distance
    from the origin and get at least `mode_damping`. The observer has the same poles, faster by a factor, and one pole
    per motor for the disturbance torque, which is cancelled: the integral action. Past commands are known and need no
    poles of the observer; in the regulator the delay keeps its poles at the origin (Astrom and Wittenmark 1997,
    sections 4.4 and 4.5; Kautsky, Nichols and Van Dooren 1985 for the placement).
    """

    method: ClassVar[str] = "pole_placement"
    tunable: ClassVar[tuple[str, ...]] = (
        "bandwidth",
        "damping",
        "mode_damping",
        "observer_factor",
        "observer_damping",
        "integral",
        "stiffness_share",
    )

    bandwidth: float = Field(default=5.0, gt=0.0, description="of the rigid motion [rad/s]")
    damping: float = Field(default=1.1, gt=0.0, description="damping ratio of the rigid motion [1]")
    mode_damping: float = Field(default=0.11, ge=0.0, description="least damping ratio of the vibrations [1]")
    observer_factor: float = Field(default=6.0, gt=0.0, description="observer over regulator, rigid motion [1]")
    observer_damping: float = Field(default=1.4, ge=0.0, description="least damping ratio of vibrations in it [1]")
    integral: float = Field(default=30.0, gt=0.0, description="pole of the disturbance torque [rad/s]")
    stiffness_share: float = Field(
        default=0.14, ge=0.0, le=1.0, description="design model between softest (0) and stiffest (1) spring segment [1]"
    )

    def design(self, problem: DesignProblem) -> Design:
        """Place the poles; see `AbstractDesignMethod.design`."""
        plant, T = problem.sampled_at(self.stiffness_share), problem.sample_time
        continuous = problem.plant_at(self.stiffness_share).A[0]
        A, B, C = disturbance_plant(plant)
        n, motors = plant.B.shape[1:]
        own = len(continuous)
        regulator = self._poles(continuous, motors, 1.0, self.mode_damping)
        delayed = 0.02 * np.arange(n - own)
        feedback = _placed(plant.A[0], plant.B[0], np.concatenate([np.exp(regulator * T), delayed]))
        observed = [*range(own), *range(n, n + motors)]
        observer = np.concatenate(
            [
                self._poles(continuous, motors, self.observer_factor, self.observer_damping),
                -self.integral * (1.0 + _APART * np.arange(motors)),
            ]
        )
        part, seen = A[np.ix_(observed, observed)], C[:, observed]
        gain = np.zeros((n + motors, len(C)))
        gain[observed] = _placed(part.T, (seen @ part).T, np.exp(observer * T)).T
        whole = np.hstack([feedback, np.eye(motors)])
        return Design(estimator_controller(A, B, C, whole, gain), T, B, {})

    def _poles(self, A: FloatArray, motors: int, factor: float, least: float) -> ComplexArray:
        """Return the wanted poles of the motion without the delay [1/s]."""
        given = np.linalg.eigvals(A)
        given = given[np.argsort(np.abs(given), kind="stable")]
        turn = np.exp(1j * np.arccos(min(self.damping, 1.0)))
        poles: list[complex] = []
        for number in range(motors):
            size = factor * self.bandwidth * (1.0 + _APART * number)
            spread = (1.0 - _APART, 1.0 + _APART) if self.damping >= 1.0 else (1.0, 1.0)
            poles += [-size * spread[0] * np.conj(turn), -size * spread[1] * turn]
        for pole in given[2 * motors :]:
            if pole.imag < 0.0:
                continue
            size, ratio = abs(pole), max(-pole.real / abs(pole), least)
            if pole.imag == 0.0 or ratio >= 1.0:
                poles += [-size * (1.0 + _APART * len(poles))] * (1 if pole.imag == 0.0 else 0)
                if pole.imag > 0.0:
                    poles += [-size * (1.0 + _APART * len(poles)), -size * (1.0 - _APART * len(poles))]
                continue
            moved = size * (-ratio + 1j * np.sqrt(1.0 - ratio**2))
            poles += [moved, np.conj(moved)]
        return np.array(poles)


def _placed(A: FloatArray, B: FloatArray, poles: ComplexArray) -> FloatArray:
    """Return the gain K that gives A - B K the poles.

    Raises:
        InputError: The poles cannot be placed.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of convergence: the poles are checked below
            gain = place_poles(A, B, poles).gain_matrix
    except ValueError as error:
        raise InputError(f"pole_placement: the poles cannot be placed ({error}); change the choices") from error
    found = np.linalg.eigvals(A - B @ gain)
    missed = max(float(np.min(np.abs(found - pole))) for pole in poles)
    if missed > 1e-2:
        raise InputError(f"pole_placement: a pole is missed by {missed:.2g}; choose poles that lie further apart")
    return np.asarray(gain, dtype=float)
