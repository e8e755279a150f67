"""Rotor inertias that a robot file leaves out: estimated from the log, since unknown is not wrong."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect, RobotWithEffects
from flexros.effects.rotor_inertia import RotorInertia
from flexros.gap.fit.torque_regression import regress_torque

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.gap.candidates.tolerance import Tolerance
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.record.record import Record

LEAST = 0.2
"""Inertia of a rotor, over that of the bodies it moves, from which the file lacks it [1] (chosen); less may be in that
of the bodies, as for a drive whose one mass is that of all its parts."""
UNCERTAIN = 0.5
"""Standard deviation of the logarithm of an estimated inertia: the prediction errors decide (chosen)."""


@dataclass(frozen=True)
class UnknownNumbers:
    """Numbers that the nominal model lacks, estimated from a log.

    Attributes:
        inertias: Inertia by motor, of those whose robot file gives none [kg m2 or kg].
    """

    inertias: Mapping[str, float] = field(default_factory=dict)

    def lacked_by(self, model: RobotWithEffects) -> UnknownNumbers:
        """Return those of the numbers that a model lacks."""
        parameters = model.robot.parameters
        return UnknownNumbers({k: v for k, v in self.inertias.items() if parameters[f"{k}.inertia"].value == 0})

    def given_to(self, model: RobotWithEffects) -> RobotWithEffects:
        """Return a model that lacks these numbers with them."""
        values = {f"{name}.inertia": value for name, value in self.inertias.items()}
        return RobotWithEffects(model.robot.with_values(values), model.laws) if values else model

    def tolerated(self, tolerance: Tolerance) -> Tolerance:
        """Return a tolerance in which these numbers are uncertain."""
        own = {f"{name}.inertia" for name in self.inertias}
        deviations = zip(tolerance.names, tolerance.deviations, strict=True)
        return replace(
            tolerance, deviations=tuple(UNCERTAIN if name in own else deviation for name, deviation in deviations)
        )

    def fitted(self, fit: CandidateFit) -> tuple[PlacedEffect, ...]:
        """Return the numbers of a fit as effects on the model that lacks them."""
        robot, tolerance = fit.predictor.robot, fit.predictor.tolerance
        factors = dict(zip(tolerance.names, np.exp(tolerance.logarithms(fit.deviations)), strict=True))
        return tuple(
            PlacedEffect(RotorInertia(added=float(factors[name] * robot.parameters[name].value)), motor)
            for motor in self.inertias
            if (name := f"{motor}.inertia") in factors
        )


def unknown_numbers(record: Record, model: RobotWithEffects, tolerance: Tolerance) -> UnknownNumbers:
    """Estimate the rotor inertias that a model lacks, from a log that this program has not simulated.

    Args:
        record: The log.
        model: The nominal model.
        tolerance: Parameters of the robot that may deviate.
    """
    robot = model.robot
    lacking = [name for name in robot.joint_names if robot.parameters[f"{name}.inertia"].value == 0]
    if record.simulated or record.command is not None or model.laws or not lacking:
        return UnknownNumbers()
    regression = regress_torque(record, robot, tolerance)
    if regression is None:
        return UnknownNumbers()
    found = dict(zip(robot.joint_names, regression.inertia.tolist(), strict=True))
    state = robot.equilibrium(motor_position=np.median(record.position, axis=0))
    masses = robot.model.mass_matrix(state[: robot.n_coordinates], robot.model.parameter_values)
    of_bodies = dict(zip(robot.joint_names, np.diag(np.asarray(masses, dtype=float))[list(robot.motor_rows)]))
    return UnknownNumbers({name: found[name] for name in lacking if found[name] > LEAST * of_bodies[name]})
