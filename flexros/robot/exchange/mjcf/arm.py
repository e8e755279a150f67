"""One serial arm of a compiled MJCF: its joints, and the mass that each carries, in a frame along the joint axes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.robot.exchange.mjcf.mujoco_model import mujoco_package
from flexros.robot.exchange.slanted_axis import ALIGNED, turn_to
from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from flexros.arrays import FloatArray


@dataclass(frozen=True, eq=False)
class ArmJoint:
    """A joint of the arm with the bodies that it carries up to the next joint.

    Attributes:
        index: Index of the joint in the model.
        name: Its name, empty for none.
        body: Name of the body that it belongs to, empty for none.
        rotary: Hinge (True) or slide (False).
        axis: Index of the coordinate axis of its frame, 0 to 2.
        sign: -1 where the joint's axis points against the coordinate axis, else 1.
        anchor: Its anchor [m], shape (3,).
        mass: Mass that it carries [kg].
        center: Centre of this mass [m], shape (3,).
        inertia: Inertia about the centre [kg m2], shape (3, 3).
        bodies: Indices of the bodies that it carries.
        turn: Rotation from its frame to that of the joint before, of an axis that is slanted there, shape (3, 3).
        frame: Rotation from its frame to that of the arm, shape (3, 3).
    """

    index: int
    name: str
    body: str
    rotary: bool
    axis: int
    sign: int
    anchor: FloatArray
    mass: float
    center: FloatArray
    inertia: FloatArray
    bodies: tuple[int, ...]
    turn: FloatArray
    frame: FloatArray


@dataclass(frozen=True, eq=False)
class MjcfArm:
    """An arm at the reference configuration of the model, all vectors in a frame along the joint axes.

    Attributes:
        joints: Its joints from base to end.
        frame: Axes of the frame in the world of the model, one per row, shape (3, 3).
        gravity: Gravity [m/s2], shape (3,).
        end: Position of the end body [m], shape (3,).
        frozen: Names of further joints on the arm, held at their reference: fingers, for instance.
        weightless: Whether the attribute gravcomp balances the whole weight of all its bodies; gravity is zero then.
    """

    joints: tuple[ArmJoint, ...]
    frame: FloatArray
    gravity: FloatArray
    end: FloatArray
    frozen: tuple[str, ...]
    weightless: bool


def find_arm(model: Any, source: str, end: str = "") -> MjcfArm:
    """Find a serial arm of hinges and slides in a compiled model.

    Args:
        model: The compiled model, mujoco.MjModel.
        source: The file, for error messages.
        end: Name of the body at the end of the arm; default: the only one that can be meant.

    Raises:
        InputError: No arm, several without a name, a free or ball joint, or a closed chain.
    """
    mujoco = mujoco_package()
    last = _end_body(model, source, end)
    path = _path(model, last)
    owner = _owners(model, path)
    indices = [j for body in path for j in _joints_of(model, body)]
    _refuse_joints(model, indices, source)
    _refuse_loops(model, indices, owner, source)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    frame = _frame(np.array([data.xaxis[j] for j in indices]))
    joints: list[ArmJoint] = []
    own = np.eye(3)
    for k, j in enumerate(indices):
        joints.append(_arm_joint(model, data, frame, own, j, np.flatnonzero(owner == k).tolist()))
        own = joints[-1].frame
    off = int(model.opt.disableflags) & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    gravity = np.zeros(3) if off else frame @ np.array(model.opt.gravity)
    carried = [body for joint in joints for body in joint.bodies]
    heavy = [body for body in carried if model.body_mass[body] > 0]
    weightless = bool(heavy and np.any(gravity) and np.all(model.body_gravcomp[heavy] == 1))
    frozen = [j for body in carried for j in _joints_of(model, body) if j not in indices]
    return MjcfArm(
        tuple(joints),
        frame,
        np.zeros(3) if weightless else gravity,
        frame @ data.xpos[last],
        tuple(_joint_name(model, j) for j in frozen),
        weightless,
    )


def _joints_of(model: Any, body: int) -> list[int]:
    start = int(model.body_jntadr[body])
    return list(range(start, start + int(model.body_jntnum[body])))


def _joint_name(model: Any, joint: int) -> str:
    return str(model.joint(joint).name) or f"joint {joint} without a name"


def _path(model: Any, body: int) -> list[int]:
    path = []
    while body:
        path.append(body)
        body = int(model.body_parentid[body])
    return path[::-1]


def _end_body(model: Any, source: str, end: str) -> int:
    """Return the index of the end body."""
    names = {str(model.body(b).name): b for b in range(1, model.nbody)}
    if end:
        if end not in names:
            error = unknown_name("body", end, names, source)
            error.argument = "end"
            raise error
        return names[end]
    moving = [b for b in range(1, model.nbody) if model.body_jntnum[b]]
    if not moving:
        raise InputError(f"{source}: no joint was found; give the MJCF of a robot arm")
    inner = {b for each in moving for b in _path(model, each)[:-1]}
    tips = [b for b in moving if b not in inner]
    if len(tips) > 1:
        listed = ", ".join(str(model.body(b).name) or f"body {b}" for b in tips)
        raise InputError(
            f"{source} has several chains, which end at the bodies {listed}, but a robot here is one serial chain; "
            f"name the body at the end of the arm{_where_they_part(model, tips)}",
            "end",
        )
    return tips[0]


def _where_they_part(model: Any, tips: list[int]) -> str:
    """Propose the last body that all chains share, as of an arm with a gripper; nothing for legs of a loose body."""
    shared = [bodies[0] for bodies in zip(*(_path(model, tip) for tip in tips), strict=False) if len(set(bodies)) == 1]
    free = int(mujoco_package().mjtJoint.mjJNT_FREE)
    hinges = [j for j in range(model.njnt) if int(model.jnt_bodyid[j]) in shared and int(model.jnt_type[j]) != free]
    return f", perhaps '{model.body(shared[-1]).name}', where they part" if hinges else ""


def _owners(model: Any, path: list[int]) -> FloatArray:
    """Return for each body the number of the joint of the path that carries it; -1 for bodies beside the arm."""
    owner = np.full(model.nbody, -1)
    count = 0
    known = {}
    for body in path:
        count += int(model.body_jntnum[body])
        known[body] = count - 1
    for body in range(1, model.nbody):  # parents come before their children
        owner[body] = known.get(body, owner[int(model.body_parentid[body])])
    return owner


def _refuse_joints(model: Any, indices: list[int], source: str) -> None:
    kinds = mujoco_package().mjtJoint
    words = {int(kinds.mjJNT_FREE): "a free joint", int(kinds.mjJNT_BALL): "a ball joint"}
    if not indices:
        raise InputError(f"{source}: no joint leads to this body; name the body at the end of the arm", "end")
    for j in indices:
        kind = int(model.jnt_type[j])
        if kind in words:
            raise InputError(
                f"{source}: {_joint_name(model, j)} on body '{model.body(int(model.jnt_bodyid[j])).name}' is "
                f"{words[kind]}, but a robot here has a fixed base and hinge or slide joints; remove it from the chain"
            )


def _refuse_loops(model: Any, indices: list[int], owner: FloatArray, source: str) -> None:
    """Refuse active equality constraints that move the arm."""
    kinds = mujoco_package().mjtEq
    for e in range(model.neq):
        if not model.eq_active0[e]:
            continue
        ends = [int(model.eq_obj1id[e]), int(model.eq_obj2id[e])]
        if int(model.eq_type[e]) == int(kinds.mjEQ_JOINT):
            binds = any(end in indices for end in ends)
        elif int(model.eq_type[e]) in (int(kinds.mjEQ_CONNECT), int(kinds.mjEQ_WELD)):
            if int(model.eq_objtype[e]) == int(mujoco_package().mjtObj.mjOBJ_SITE):
                ends = [int(model.site_bodyid[end]) for end in ends]
            held = {int(owner[end]) if end >= 0 else -1 for end in ends}
            binds = len(held) > 1
        else:
            binds = False
        if binds:
            name = str(model.equality(e).name) or f"number {e}"
            raise InputError(
                f"{source}: the equality constraint {name} closes a chain or couples joints of the arm, but a robot "
                "here is one open chain; remove it, or set its attribute active to false"
            )


def _frame(axes: FloatArray) -> FloatArray:
    """Return a frame along whose axes most joints move: that of the world if it is one for all."""
    if np.all(np.abs(axes).max(axis=1) > 1 - ALIGNED):
        return np.eye(3)
    first = axes[0]
    others = [axis for axis in axes if abs(axis @ first) < ALIGNED]
    second = others[0] if others else np.eye(3)[int(np.argmin(np.abs(first)))]
    second = second - (second @ first) * first
    second = second / np.linalg.norm(second)
    found: FloatArray = np.array([first, second, np.cross(first, second)])
    frames = [np.eye(3), found]
    return max(frames, key=lambda frame: np.count_nonzero(np.abs(frame @ axes.T).max(axis=0) > 1 - ALIGNED))


def _arm_joint(model: Any, data: Any, frame: FloatArray, before: FloatArray, index: int, bodies: list[int]) -> ArmJoint:
    """Return a joint of an arm; the frame of the joint before it, shape (3, 3), is in that of the arm."""
    axis = before.T @ frame @ data.xaxis[index]
    along, turn = turn_to(axis)
    masses = model.body_mass[bodies]
    mass = float(masses.sum())
    anchor = frame @ data.xanchor[index]
    centers = (frame @ data.xipos[bodies].T).T
    center = masses @ centers / mass if mass > 0 else anchor
    inertia = np.zeros((3, 3))
    for body, m, c in zip(bodies, masses, centers):
        rotation = frame @ data.ximat[body].reshape(3, 3)
        inertia += rotation @ np.diag(model.body_inertia[body]) @ rotation.T + point_inertia(m, c - center)
    return ArmJoint(
        index=index,
        name=str(model.joint(index).name),
        body=str(model.body(int(model.jnt_bodyid[index])).name),
        rotary=int(model.jnt_type[index]) == int(mujoco_package().mjtJoint.mjJNT_HINGE),
        axis=along,
        sign=1 if axis[along] > 0 else -1,
        anchor=anchor,
        mass=mass,
        center=center,
        inertia=inertia,
        bodies=tuple(bodies),
        turn=turn,
        frame=before @ turn,
    )
