"""Kinematics of the tool: that of the robot file, or with known kinematic errors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca

from flexros.effects.kinds.tool_error import AbstractToolError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.effects import PlacedLaw
    from flexros.robot import Robot


@dataclass(frozen=True)
class ToolGeometry:
    """Kinematics of the tool.

    Attributes:
        robot: Robot with the true lengths; only its kinematics are used.
        offsets: Added to the arm coordinates before the kinematics [rad or m], length N.
    """

    robot: Robot
    offsets: tuple[float, ...]

    @classmethod
    def of(cls, robot: Robot, laws: Sequence[PlacedLaw] = ()) -> ToolGeometry:
        """Return the geometry of a robot with kinematic errors.

        Args:
            robot: The robot.
            laws: Laws on it; those that are not tool errors are skipped.
        """
        offsets, lengths = dict.fromkeys(robot.arm_names, 0.0), dict[str, float]()
        for law in laws:
            effect = law.effect
            if not isinstance(effect, AbstractToolError):
                continue
            for name, value in effect.offsets(robot, law.location, effect.parameter_values).items():
                offsets[name] += float(value)
            for name, value in effect.geometry(robot, law.location, effect.parameter_values).items():
                lengths[name] = lengths.get(name, robot.parameters[name].value) + float(value)
        return cls(robot.with_values(lengths, "errors of the kinematics"), tuple(offsets.values()))

    def output(self, name: str, q_a: ca.SX) -> ca.SX:
        """Evaluate an output; errors do not affect one that is not a pose, such as joint coordinates.

        Args:
            name: Name of the output.
            q_a: Arm coordinates [rad or m], SX (N, 1).

        Returns:
            Output [m or rad], SX (n_out, 1).

        Raises:
            InputError: The robot has no such output.
        """
        model = self.robot.model
        function = model.output(name)
        is_pose = bool(self.robot.spec.outputs[name].pose)
        value: ca.SX = function(self._with_offsets(q_a) if is_pose else q_a, model.parameter_values)
        return value

    def pose(self) -> ca.Function:
        """Return the tool pose [x y z qx qy qz qw] for arm coordinates, as a CasADi function."""
        q_a, model = ca.SX.sym("q_a", self.robot.n_arm), self.robot.model
        return ca.Function(
            "tool_pose", [q_a], [ca.densify(model.tool_pose(self._with_offsets(q_a), model.parameter_values))]
        )

    def _with_offsets(self, q_a: ca.SX) -> ca.SX:
        return q_a + ca.DM(self.offsets) if any(self.offsets) else q_a
