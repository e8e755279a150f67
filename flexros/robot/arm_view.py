"""Positions of the bars of a robot, with true and with magnified deflection."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.robot.body_placement import body_placement
from flexros.robot.link_shape import LinkShape, link_shapes

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class ArmBars:
    """Ends of all bars in the base frame [m], each of shape (n_bars, 2, 3).

    Attributes:
        true: In the given state.
        magnified: With magnified deflection.
        stiff: At the motor positions, with stiff springs.
    """

    true: FloatArray
    magnified: FloatArray
    stiff: FloatArray


class ArmView:
    """Computes the bars of a robot.

    Args:
        robot: The robot.

    Attributes:
        radii: Radius of each bar [m].
    """

    def __init__(self, robot: Robot) -> None:
        self._chain = robot.chain
        shapes = link_shapes(robot.spec)
        self.radii = tuple(shape.radius for shape in shapes)
        q = ca.SX.sym("q", robot.n_arm)
        ends = [end for shape in shapes for end in _ends(robot, shape, q)]
        self._one = ca.Function("ends", [q], [ca.densify(ca.horzcat(*ends))])
        self._ends = self._one.map(3)

    def at(self, arm: FloatArray) -> FloatArray:
        """Compute the ends of all bars in the base frame [m], shape (n, n_bars, 2, 3).

        Args:
            arm: Arm coordinates [rad or m], shape (n, N).
        """
        ends = np.asarray(self._one(np.ascontiguousarray(arm.T)))
        return ends.T.reshape(len(arm), len(self.radii), 2, 3)

    def bars(self, state: FloatArray, magnification: float) -> ArmBars:
        """Compute the bars in a state.

        Args:
            state: State x = [q_a, q_m, rates], shape (2 n_coordinates,).
            magnification: Factor on the deflection.

        Returns:
            The bars; the deflection is the difference of the arm coordinates to those given by the motors alone.
        """
        true = state[: len(self._chain.joints)]
        stiff = self._chain.arm_from_gears(state[list(self._chain.motor_rows)])
        poses = np.stack([true, stiff + magnification * (true - stiff), stiff], axis=1)
        ends = np.asarray(self._ends(poses)).T.reshape(3, len(self.radii), 2, 3)
        return ArmBars(*ends)


def _ends(robot: Robot, shape: LinkShape, q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the ends of a bar in the base frame [m], SX (3, 1) each."""
    origin, rotation = body_placement(robot, shape.body, q)
    return origin + rotation @ ca.DM(shape.start), origin + rotation @ ca.DM(shape.end)
