"""Parameters of the nominal model that are known with a tolerance only."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import null_space

from flexros.errors import unknown_name
from flexros.robot.parameters import SERVO

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from flexros.arrays import BoolArray, FloatArray
    from flexros.gap.settings import DiagnosisSettings
    from flexros.robot import Robot

TORQUE = "torque"
"""Kind of the tolerance of recorded torques, one of the log and of no parameter: see `with_torque_tolerance`."""
KINDS: dict[str, tuple[str, ...]] = {
    "stiffness": (".stiffness",),
    "damping": (".damping", ".viscous_friction"),
    "inertia": (".inertia", ".mass", ".inertia.xx", ".inertia.yy", ".inertia.zz"),
    TORQUE: (),
}
"""Kinds of tolerances by the endings of the names of their robot parameters."""


FARTHEST, FARTHER = 5.0, 20.0
"""Largest tolerated deviation, in standard deviations of the tolerance, and where some ended there [1] (chosen)."""
UNINFORMED = 0.01
"""Information of a log in a direction of tolerated parameters, over that of the prior, up to which the direction is
left at its nominal value [1]: it would move by a hundredth of what the log alone asks for (chosen)."""


@dataclass(frozen=True)
class Tolerance:
    """Tolerated parameters, or the directions of them in which a log informs.

    What is fitted are numbers z of standard normal prior, one per direction: the parameters deviate by B z standard
    deviations, where the columns of B are orthonormal.

    Attributes:
        names: Names of robot parameters.
        deviations: Standard deviation of the logarithm of each [1].
        directions: The directions B, shape (n_names, n_free); None for one per parameter.
        farthest: Largest deviation along each of them [1].
    """

    names: tuple[str, ...] = ()
    deviations: tuple[float, ...] = ()
    directions: FloatArray | None = field(default=None, compare=False)
    farthest: float = FARTHEST

    @property
    def n_free(self) -> int:
        """Number of directions."""
        return len(self.names) if self.directions is None else int(self.directions.shape[1])

    def by_name(self, free: FloatArray) -> FloatArray:
        """Return the deviations of the parameters in standard deviations [1], shape (n_names,).

        Args:
            free: Deviations along the directions z, shape (n_free,).
        """
        return free if self.directions is None else self.directions @ free

    def largest(self, names: Sequence[str]) -> float:
        """Return the largest standard deviation of the logarithms of some parameters [1]; 0 where none is tolerated."""
        return max((d for name, d in zip(self.names, self.deviations, strict=True) if name in names), default=0.0)

    def along(self, deviations: FloatArray) -> FloatArray:
        """Return the deviations along the directions, nearest to some of the parameters, shape (n_free,).

        Args:
            deviations: Deviations of the parameters in standard deviations [1], shape (n_names,).
        """
        return deviations if self.directions is None else self.directions.T @ deviations

    def logarithms(self, free: FloatArray) -> FloatArray:
        """Return the logarithms of the factors on the parameters [1], shape (n_names,); argument as for `by_name`."""
        return np.array(self.deviations) * self.by_name(free)

    def fitted(self, covariance: FloatArray) -> FloatArray:
        """Return the standard deviations of the logarithms of the parameters along the directions, shape (n_names,).

        Args:
            covariance: Covariance of fitted deviations along the directions [1], shape (n_free, n_free).
        """
        parts = np.diag(covariance)
        if self.directions is not None:
            parts = np.einsum("ij,jk,ik->i", self.directions, covariance, self.directions)
        result: FloatArray = np.array(self.deviations) * np.sqrt(np.maximum(parts, 0.0))
        return result

    @property
    def left_out(self) -> FloatArray:
        """Directions in which no log informs, which are not fitted, shape (n_names, n_names - n_free)."""
        n = len(self.names)
        if self.directions is None:
            return np.empty((n, 0))
        return np.asarray(null_space(self.directions.T)) if self.n_free else np.eye(n)

    @property
    def uninformed(self) -> FloatArray:
        """Standard deviations of the logarithms in the directions in which no log informs [1], shape (n_names,)."""
        left = 0.0 if self.directions is None else 1.0 - np.sum(self.directions**2, axis=1)
        result: FloatArray = np.array(self.deviations) * np.sqrt(np.maximum(left, 0.0))
        return result

    def without(self, free: FloatArray, replaced: BoolArray) -> FloatArray:
        """Return deviations along the directions with some parameters at their nominal values, shape (n_free,).

        Args:
            free: Deviations along the directions, shape (n_free,).
            replaced: Whether a parameter is one of them, shape (n_names,).
        """
        return self.along(np.where(replaced, 0.0, self.by_name(free))) if np.any(replaced) else free

    def known(self, names: Collection[str]) -> Tolerance:
        """Return the same tolerance with some numbers at their nominal values, whose directions have no effect there.

        Args:
            names: Names of robot parameters.
        """
        if not any(name in names for name in self.names):
            return self
        pairs = zip(self.names, self.deviations, strict=True)
        return replace(self, deviations=tuple(0.0 if name in names else deviation for name, deviation in pairs))

    def informed(self, information: FloatArray) -> Tolerance:
        """Return the same tolerance along those directions alone in which a log informs.

        Args:
            information: Information of the log on the deviations of the parameters, over that of the prior [1], shape
                (n_names, n_names).
        """
        sizes, directions = np.linalg.eigh(information)
        return replace(self, directions=directions[:, sizes > UNINFORMED])


def with_torque_tolerance(settings: DiagnosisSettings, given: Mapping[str, float] | None) -> DiagnosisSettings:
    """Return the settings with a stated tolerance of the torques of imported logs.

    Args:
        settings: Settings of a diagnosis.
        given: Relative tolerances by kind [1]; the settings stay where that of torques is not among them.
    """
    if TORQUE not in (given or {}):
        return settings
    noise = settings.noise.model_copy(update={"signal_tolerance": (given or {})[TORQUE]})
    return settings.model_copy(update={"noise": noise})


def scaled_by_gravity(tolerance: Tolerance) -> Tolerance:
    """Return a tolerance without gravity and the gains of servos, for servos whose gains nobody knows.

    Gravity is known far better than the numbers of a robot. Where neither torques nor gains are known, it alone fixes
    their scale, and a deviation of it would stand for an error of all gains, frictions and rotors at once. The gains
    themselves are errors to be found.

    Args:
        tolerance: Tolerance of a model.
    """
    kept = [
        (name, deviation)
        for name, deviation in zip(tolerance.names, tolerance.deviations, strict=True)
        if not name.startswith("gravity.") and f".{SERVO}" not in name
    ]
    return Tolerance(tuple(name for name, _ in kept), tuple(deviation for _, deviation in kept))


def tolerance_of(robot: Robot, given: Mapping[str, float], prescribed: Sequence[int] = ()) -> Tolerance:
    """Collect the tolerances of a robot: of all parameters that are neither zero nor exact.

    Args:
        robot: The nominal robot; its file states a tolerance per parameter.
        given: Relative tolerances by kind (stiffness, damping, inertia) that replace those of the file [1]; that of
            torques is none of them.
        prescribed: Motors whose motion is prescribed: the endless inertia of the model there is no number of the robot.

    Raises:
        InputError: A kind is unknown.
    """
    for kind in given:
        if kind not in KINDS:
            raise unknown_name("kind of tolerance", kind, KINDS)
    tolerances: dict[str, float] = {}
    endless = {f"{robot.joint_names[motor]}.inertia" for motor in prescribed}
    for name, parameter in robot.parameters.items():
        if name in endless:
            continue
        if f".{SERVO}" in name and robot.commands == "torque":
            continue  # the servos have no part in it
        deviation = parameter.tolerance
        for kind, endings in KINDS.items():
            if kind in given and name.endswith(endings):
                deviation = given[kind]
        if deviation > 0 and parameter.value != 0:
            tolerances[name] = deviation
    return Tolerance(tuple(tolerances), tuple(tolerances.values()))
