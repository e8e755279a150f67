"""Symbolic kinematics of the chain: joint frames, tool pose, controlled outputs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import casadi as ca
import numpy as np

from flexros.robot.beam import gauss_points

if TYPE_CHECKING:
    from collections.abc import Callable

    from flexros.robot.specification import Output, RobotSpecification
    from flexros.robot.symbolic.chain import Chain, Joint

POINTS = 6
"""Mass points of a link that bends, beside two per mode (chosen: the inertia is exact to some 1e-9)."""

Value: TypeAlias = ca.SX | float
"""A parameter of the model: a number, or a symbol where it is free."""


@dataclass(frozen=True)
class BeamPoint:
    """A mass point of a link that bends.

    Attributes:
        share: Its share of the link's mass [1].
        place: Place of the straight link in the frame that carries it [m], SX (3, 1).
        modes: Index of a joint of a mode, and the displacement of the point per unit of its coordinate, SX (3, 1).
    """

    share: float
    place: ca.SX
    modes: tuple[tuple[int, ca.SX], ...]

    def at(self, q: ca.SX) -> ca.SX:
        """Return the place in the frame that carries the link [m], SX (3, 1), for arm coordinates q."""
        return self.place + self.moved(q)

    def moved(self, rates: ca.SX) -> ca.SX:
        """Return the displacement, or its rate, for arm coordinates or their rates, SX (3, 1)."""
        return sum((shape * rates[joint] for joint, shape in self.modes), start=ca.SX.zeros(3))


@dataclass(frozen=True)
class Mass:
    """A body fixed to a joint frame: mass [kg], centre of mass [m], inertia about it [kg m2], friction.

    The mass of a link that bends is that of its points; its centre and inertia are those of the straight link, the
    inertia without what the points have.
    """

    mass: Value
    center: ca.SX
    inertia: ca.SX
    viscous_friction: Value
    beam: tuple[BeamPoint, ...] = ()

    @property
    def rigid_mass(self) -> Value:
        """The mass of a rigid body [kg], zero for a link that bends."""
        return 0.0 if self.beam else self.mass


@dataclass(frozen=True)
class Frame:
    """The frame after one joint.

    Attributes:
        offset: Origin of the joint in the frame before [m], SX (3, 1).
        masses: Bodies fixed to this frame.
    """

    offset: ca.SX
    masses: tuple[Mass, ...]


@dataclass(frozen=True)
class Geometry:
    """Frames of a chain with values of their parameters.

    Attributes:
        frames: One frame per joint.
        tool: Tool point in the last frame [m], SX (3, 1).
        zeros: Added to the arm coordinates [rad or m], SX (N, 1); None where no direction states a zero.
    """

    frames: tuple[Frame, ...]
    tool: ca.SX
    zeros: ca.SX | None = None

    def placed(self, q: ca.SX) -> ca.SX:
        """Return the angles and displacements of the joints for arm coordinates q, SX (N, 1)."""
        return q if self.zeros is None else q[: self.zeros.shape[0]] + self.zeros


def build_geometry(specification: RobotSpecification, chain: Chain, value: Callable[[str], Value]) -> Geometry:
    """Assign bodies and lengths to the joint frames; a body without free direction is fixed to the joint before it.

    Args:
        specification: The robot file.
        chain: Its joints.
        value: Maps a parameter name to its number or symbol.
    """
    joint_of_body = {joint.body: index for index, joint in enumerate(chain.joints) if joint.mode is None}
    offsets: list[ca.SX] = []
    carried: list[list[Mass]] = [[] for _ in chain.joints]
    current = -1
    reach = ca.SX.zeros(3)
    for body_index in range(len(specification.bodies)):
        name = f"body_{body_index + 1}"
        modes = [i for i, joint in enumerate(chain.joints) if joint.body == body_index and joint.mode is not None]
        if body_index in joint_of_body:
            current = joint_of_body[body_index]
            count = sum(joint.body == body_index for joint in chain.joints) - len(modes)
            offsets += [reach] + [ca.SX.zeros(3)] * (count - 1)
            reach = ca.SX.zeros(3)
        length = _vector(name, "length", value)
        if current >= 0:
            center = reach + (length / 2 if modes else _vector(name, "center_of_mass", value))
            friction = value(f"{name}.viscous_friction")
            beam = _beam(chain, modes, reach, length)
            carried[current].append(Mass(value(f"{name}.mass"), center, _tensor(name, value), friction, beam))
        tip = reach + length
        tool = tip
        if body_index == len(specification.bodies) - 1 and specification.tool.position is not None:
            tool = reach + ca.SX(ca.DM(specification.tool.position.value))
        if modes:  # what follows is fixed to the bent tip
            offsets += [tip] + [ca.SX.zeros(3)] * (len(modes) - 1)
            current, tool, tip = modes[-1], tool - tip, ca.SX.zeros(3)
        reach = tip
    frames = tuple(Frame(offset, tuple(masses)) for offset, masses in zip(offsets, carried))
    return Geometry(frames, tool, _zeros(chain, value))


def _zeros(chain: Chain, value: Callable[[str], Value]) -> ca.SX | None:
    if all(joint.direction.zero is None for joint in chain.joints):
        return None
    return ca.vertcat(
        *[ca.SX(0 if joint.direction.zero is None else value(f"{joint.name}.zero")) for joint in chain.joints]
    )


def _beam(chain: Chain, modes: list[int], reach: ca.SX, length: ca.SX) -> tuple[BeamPoint, ...]:
    """Return the mass points of a link that bends, at the points of Gauss-Legendre quadrature; none for a rigid one."""
    if not modes:
        return ()
    positions, weights = gauss_points(POINTS + 2 * len(modes))
    bent = []
    for joint in modes:
        mode = chain.joints[joint].mode
        assert mode is not None
        bent.append((joint, unit_vector(mode.across), mode.at(positions).tolist()))
    return tuple(
        BeamPoint(share, reach + xi * length, tuple((joint, across * sizes[k]) for joint, across, sizes in bent))
        for k, (xi, share) in enumerate(zip(positions.tolist(), weights.tolist(), strict=True))
    )


def _vector(body: str, key: str, value: Callable[[str], Value]) -> ca.SX:
    return ca.vertcat(*[ca.SX(value(f"{body}.{key}.{axis}")) for axis in "xyz"])


def _tensor(body: str, value: Callable[[str], Value]) -> ca.SX:
    xx, yy, zz, xy, xz, yz = (ca.SX(value(f"{body}.inertia.{entry}")) for entry in ("xx", "yy", "zz", "xy", "xz", "yz"))
    return ca.vertcat(ca.horzcat(xx, xy, xz), ca.horzcat(xy, yy, yz), ca.horzcat(xz, yz, zz))


def joint_angle(joint: Joint, coordinate: ca.SX) -> ca.SX:
    """Return the angle of a rotary joint, or of the tip of a link by a mode [rad]."""
    return coordinate if joint.mode is None else joint.mode.tip_slope * coordinate


def joint_rotation(chain: Chain, index: int, angle: ca.SX) -> ca.SX:
    """Return the rotation from the frame of a joint to the frame before it, SX (3, 3); at zero its fixed turn.

    Args:
        chain: The chain.
        index: Index of the joint.
        angle: Arm coordinate of the joint [rad or m].

    Returns:
        Rotation matrix.
    """
    joint = chain.joints[index]
    turn = ca.SX(ca.sparsify(ca.DM(joint.turn)))
    if not joint.rotary and joint.mode is None:
        return turn
    angle = joint_angle(joint, angle)
    c, s = ca.cos(angle), ca.sin(angle)
    a, b = (joint.axis + 1) % 3, (joint.axis + 2) % 3
    rotation = ca.SX(3, 3)
    rotation[joint.axis, joint.axis] = 1
    rotation[a, a] = rotation[b, b] = c
    rotation[a, b], rotation[b, a] = -s, s
    return turn @ rotation if any(joint.orientation) else rotation


def joint_origin(chain: Chain, geometry: Geometry, index: int, coordinate: ca.SX) -> ca.SX:
    """Return the origin of a joint frame in the frame before it [m], SX (3, 1)."""
    joint = chain.joints[index]
    origin = geometry.frames[index].offset
    if joint.mode is not None:
        return origin + unit_vector(joint.mode.across) * (joint.mode.tip * coordinate)
    return origin if joint.rotary else origin + ca.DM(joint.turn[:, joint.axis]) * coordinate


def unit_vector(axis: int) -> ca.SX:
    """Return the unit vector of a coordinate axis, SX (3, 1)."""
    return ca.SX(ca.Sparsity.unit(3, axis), 1)


def forward(chain: Chain, geometry: Geometry, q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Compute the forward kinematics of the chain (Moberg 2007, eq. 3.1).

    Args:
        chain: The chain.
        geometry: Its geometry.
        q: Arm coordinates, SX (N, 1).

    Returns:
        Tool position in the base frame [m], SX (3, 1), and rotation from tool to base, SX (3, 3).
    """
    position, rotation = ca.SX.zeros(3), ca.SX.eye(3)
    q = geometry.placed(q)
    for index in range(len(chain.joints)):
        position = position + rotation @ joint_origin(chain, geometry, index, q[index])
        rotation = rotation @ joint_rotation(chain, index, q[index])
    return position + rotation @ geometry.tool, rotation


def _quaternion(chain: Chain, q: ca.SX) -> ca.SX:
    """Return the orientation as a quaternion [x, y, z, w], continuous in q as a product over the joints."""
    x, y, z, w = ca.SX(0), ca.SX(0), ca.SX(0), ca.SX(1)
    for index, joint in enumerate(chain.joints):
        if any(joint.orientation):
            a, b, c, d = (ca.SX(part) for part in _turn_quaternion(joint))
            x, y, z, w = (
                w * a + x * d + y * c - z * b,
                w * b - x * c + y * d + z * a,
                w * c + x * b - y * a + z * d,
                w * d - x * a - y * b - z * c,
            )
        if not joint.rotary and joint.mode is None:
            continue
        angle = joint_angle(joint, q[index])
        c, s = ca.cos(angle / 2), ca.sin(angle / 2)
        if joint.axis == 0:
            x, y, z, w = c * x + s * w, c * y + s * z, c * z - s * y, c * w - s * x
        elif joint.axis == 1:
            x, y, z, w = c * x - s * z, c * y + s * w, c * z + s * x, c * w - s * y
        else:
            x, y, z, w = c * x + s * y, c * y - s * x, c * z + s * w, c * w - s * z
    return ca.vertcat(x, y, z, w)


def _turn_quaternion(joint: Joint) -> tuple[float, float, float, float]:
    """Return the fixed turn of a joint as a quaternion x, y, z, w."""
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(angle / 2), np.sin(angle / 2)) for angle in joint.orientation)
    return (
        float(sr * cp * cy - cr * sp * sy),
        float(cr * sp * cy + sr * cp * sy),
        float(cr * cp * sy - sr * sp * cy),
        float(cr * cp * cy + sr * sp * sy),
    )


def tool_pose(specification: RobotSpecification, chain: Chain, geometry: Geometry, q: ca.SX) -> ca.SX:
    """Compute the tool pose for messages and logs.

    Args:
        specification: The robot file.
        chain: Its chain.
        geometry: Its geometry.
        q: Arm coordinates, SX (N, 1).

    Returns:
        [x, y, z] in metres and quaternion [qx, qy, qz, qw], SX (7, 1).
    """
    linear = specification.tool.linear
    if linear is not None:
        names = [joint.name for joint in chain.joints]
        total = sum((weight * q[names.index(name)] for name, weight in linear.weights.items()), start=ca.SX(0))
        position = ca.SX.zeros(3)
        position["xyz".index(linear.component)] = total / linear.divisor
        return ca.vertcat(position, 0, 0, 0, 1)
    position, _ = forward(chain, geometry, q)
    return ca.vertcat(position, _quaternion(chain, geometry.placed(q)))


def output_value(
    specification: RobotSpecification, chain: Chain, geometry: Geometry, output: Output, q: ca.SX
) -> ca.SX:
    """Compute the controlled output Z = Gamma(q_a) (Moberg 2007, eq. 3.19).

    Args:
        specification: The robot file.
        chain: Its chain.
        geometry: Its geometry.
        output: Its components; rx, ry, rz are roll, pitch and yaw about the fixed axes.
        q: Arm coordinates, SX (N, 1).

    Returns:
        Output [m, rad], SX (n_out, 1).
    """
    if output.coordinates:
        names = [joint.name for joint in chain.joints]
        return ca.vertcat(*[q[names.index(name)] for name in output.coordinates])
    pose = tool_pose(specification, chain, geometry, q)
    _, R = forward(chain, geometry, q)
    components = {
        "x": pose[0],
        "y": pose[1],
        "z": pose[2],
        "rx": ca.atan2(R[2, 1], R[2, 2]),
        "ry": ca.atan2(-R[2, 0], ca.sqrt(R[0, 0] ** 2 + R[1, 0] ** 2)),
        "rz": ca.atan2(R[1, 0], R[0, 0]),
    }
    return ca.vertcat(*[components[name] for name in output.pose])
