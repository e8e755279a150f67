"""Forces on the arm in addition to those of the robot's model, by effects that depend on its motion alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.arm_law import AbstractArmLaw, ArmState

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import PlacedLaw
    from flexros.robot import Robot


def acts_at_once(law: PlacedLaw) -> bool:
    """Return whether a law is a force on the arm without states of its own."""
    return isinstance(law.effect, AbstractArmLaw) and not law.effect.n_states


def arm_forces(robot: Robot, laws: Sequence[PlacedLaw]) -> ArmForces | None:
    """Collect the laws without states; None if there are none."""
    own = tuple(law for law in laws if acts_at_once(law))
    return ArmForces(robot, own) if own else None


@dataclass(frozen=True, eq=False)
class ArmForces:
    """Forces of effects on the arm.

    Attributes:
        robot: The robot.
        laws: Laws on it without states.
    """

    robot: Robot
    laws: tuple[PlacedLaw, ...]

    def of(self, position: ca.SX, speed: ca.SX) -> ca.SX:
        """Evaluate the forces.

        Args:
            position: Arm coordinates [rad or m], SX (N, 1).
            speed: Their rates, SX (N, 1).

        Returns:
            Forces on the arm coordinates [Nm or N], SX (N, 1).
        """
        model, total = self.robot.model, ca.SX.zeros(self.robot.n_arm)
        for law in self.laws:
            assert isinstance(law.effect, AbstractArmLaw)
            arm = ArmState.of_arm(self.robot, law.location, position, speed, model, ca.SX(model.parameter_values))
            total += law.effect.force(arm, law.effect.parameter_values)[: self.robot.n_arm]
        return total
