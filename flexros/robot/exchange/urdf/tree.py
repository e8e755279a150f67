"""Tree of a URDF: its joints, the chain from the base to the tip, and what the links of that chain carry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from flexros.errors import InputError, unknown_name
from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from flexros.arrays import FloatArray

MOVABLE = ("revolute", "continuous", "prismatic")

KINDS = (*MOVABLE, "fixed", "floating", "planar")
"""Types of joints of a URDF."""

NO_LIMIT = 1e6
"""Value of limits that a URDF requires and a robot file does not have [rad/s, m/s, m, Nm or N] (chosen)."""

FARTHEST_MASS = 10.0
"""Radius of gyration of a link from which its inertia is a placeholder, and not used [m] (chosen)."""


@dataclass(frozen=True)
class UrdfJoint:
    """A joint.

    Attributes:
        name: Its name.
        kind: "revolute", "continuous", "prismatic", "fixed", ...
        parent: Link that carries it.
        child: Link behind it.
        origin: Its position in the frame of the parent [m], shape (3,).
        rotation: Its frame in that of the parent, shape (3, 3).
        axis: Its axis in its own frame, shape (3,).
        effort: Limit of its torque or force [Nm or N]; 0 without one.
        velocity: Limit of its speed [rad/s or m/s]; 0 without one.
        damping: Viscous friction [Nm s/rad or N s/m].
        friction: Dry friction [Nm or N].
        mimics: Joint that it follows; empty for none.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray
    rotation: FloatArray
    axis: FloatArray
    effort: float
    velocity: float
    damping: float
    friction: float
    mimics: str = ""


@dataclass(frozen=True)
class Inertial:
    """Mass of a link, or of several that are fixed to each other.

    Attributes:
        mass: Mass [kg].
        center: Centre of mass in the frame of the link [m], shape (3,).
        inertia: Inertia about it, along the axes of the link [kg m2], shape (3, 3).
    """

    mass: float
    center: FloatArray
    inertia: FloatArray


@dataclass(frozen=True)
class UrdfTree:
    """Links and joints of a URDF.

    Attributes:
        source: Where it comes from, for messages.
        name: Name of the robot; empty without one.
        links: Elements of the links by their names.
        children: Joints by the link that carries them.
        joints: All joints by the link behind them.
        undeclared: Base link that joints name and the URDF does not declare; empty for none.
    """

    source: str
    name: str
    links: Mapping[str, ElementTree.Element]
    children: Mapping[str, Sequence[UrdfJoint]]
    joints: Mapping[str, UrdfJoint]
    undeclared: str = ""

    def chain(self, tip: str = "") -> list[UrdfJoint]:
        """Return the joints from the base to a link.

        Args:
            tip: Name of the last link; empty for the end of the only chain with joints that move.

        Raises:
            InputError: There is no such link, or none was given and several chains move.
        """
        return self._to(tip) if tip else self._only()

    def carried(self, joints: Sequence[UrdfJoint]) -> list[Inertial | None]:
        """Return what moves with the link behind each joint of a chain: the link, and what is beside the chain.

        Joints beside the chain, such as the fingers of a gripper, are at zero.

        Args:
            joints: The chain.

        Returns:
            Mass in the frame of each link; None for a link without one.
        """
        inside = {joint.name for joint in joints}
        return [self._carried(joint.child, inside) for joint in joints]

    def _carried(self, link: str, inside: set[str]) -> Inertial | None:
        parts: list[Inertial] = []
        for name, rotation, origin in self.fixed_to(link, inside):
            own = _inertial(self.links[name], f"{self.source}: link '{name}'")
            if own is not None:
                turned = rotation @ own.inertia @ rotation.T
                parts.append(Inertial(own.mass, origin + rotation @ own.center, turned))
        return _together(parts)

    def fixed_to(self, link: str, chain: Collection[str]) -> list[tuple[str, FloatArray, FloatArray]]:
        """Return a link and all behind it that are not behind a joint of a chain, joints beside the chain at zero.

        Args:
            link: Name of the link.
            chain: Names of the joints of the chain.

        Returns:
            Name, rotation of shape (3, 3) and origin of shape (3,) [m] of each link in the frame of the first.
        """
        found: list[tuple[str, FloatArray, FloatArray]] = []
        waiting: list[tuple[str, FloatArray, FloatArray]] = [(link, np.eye(3), np.zeros(3))]
        while waiting:  # no recursion: a chain may exceed Python's stack
            name, rotation, origin = waiting.pop()
            found.append((name, rotation, origin))
            waiting += [
                (joint.child, rotation @ joint.rotation, origin + rotation @ joint.origin)
                for joint in self.children.get(name, ())
                if joint.name not in chain
            ]
        return found

    def _to(self, tip: str) -> list[UrdfJoint]:
        if tip not in self.links:
            raise unknown_name("link", tip, self.links, self.source)
        chain: list[UrdfJoint] = []
        while tip in self.joints:
            chain.insert(0, self.joints[tip])
            tip = chain[0].parent
        return chain

    def _only(self) -> list[UrdfJoint]:
        bases = [name for name in self.links if name not in self.joints]
        chain: list[UrdfJoint] = []
        here = bases[0] if bases else ""
        while self.children.get(here):
            moving = [joint for joint in self.children[here] if self._movable_below(joint)]
            if len(moving) > 1:
                raise self._branches(here, moving)
            following = moving or (self.children[here] if len(self.children[here]) == 1 else [])
            if not following:
                break
            chain.append(following[0])
            here = following[0].child
        return chain

    def _branches(self, link: str, moving: Sequence[UrdfJoint]) -> InputError:
        names = ", ".join(joint.name for joint in moving)
        return InputError(
            f"{self.source}: link '{link}' carries the chains {names}, but a robot here is one serial chain; "
            f"give tip, the last link of the arm, e.g. '{self._likely_tip()}'; what it carries beyond is fixed to it",
            "tip",
        )

    def _likely_tip(self) -> str:
        """Return the link with most moving joints before it, or where fingers or the like begin on the way to it.

        These are chains behind a link, none of which has more moving joints than lie before that link.
        """
        last = max(self.links, key=self._moving_before)
        for joint in self._to(last):
            link, most = joint.parent, self._moving_before(last)
            fingers = [one for one in self.children[link] if self._movable_below(one)]
            if len(fingers) > 1 and 2 * self._moving_before(link) >= most:
                return link
        return last

    def _moving_before(self, link: str) -> int:
        return sum(joint.kind in MOVABLE for joint in self._to(link))

    def _movable_below(self, joint: UrdfJoint) -> bool:
        waiting = [joint]
        while waiting:
            here = waiting.pop()
            if here.kind in MOVABLE:
                return True
            waiting += self.children.get(here.child, ())
        return False


def read_tree(text: str, source: str) -> UrdfTree:
    """Read the tree of a URDF.

    A base link that joints name without its declaration, as `world` where a simulator knows it, is one without mass.

    Args:
        text: The URDF.
        source: Where it comes from: a file or a topic.

    Raises:
        InputError: Not a URDF, invalid numbers, or joints that do not form a tree.
    """
    root = _parse(text, source)
    links = {link.get("name", ""): link for link in root.findall("link")}
    undeclared = _undeclared_base(root, links)
    if undeclared:
        links[undeclared] = ElementTree.Element("link", name=undeclared)
    joints = [_joint(element, links, source) for element in root.findall("joint")]
    _refuse_loops(joints, source)
    children: dict[str, list[UrdfJoint]] = {}
    for joint in joints:
        children.setdefault(joint.parent, []).append(joint)
    by_child = {joint.child: joint for joint in joints}
    return UrdfTree(source, root.get("name", ""), links, children, by_child, undeclared)


def _undeclared_base(root: ElementTree.Element, links: Collection[str]) -> str:
    """Return the only undeclared link that joints name as a parent, if it carries all others; else an empty name."""
    parents, children = ({end.get("link", "") for end in root.findall(f"joint/{kind}")} for kind in ("parent", "child"))
    unknown = parents - children - set(links)
    return unknown.pop() if len(unknown) == 1 and set(links) <= children else ""


def _parse(text: str, file: str) -> ElementTree.Element:
    if "<!ENTITY" in text or "<!DOCTYPE" in text:
        raise InputError(f"{file} has a document type definition, which a URDF does not need; remove it")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 - entities are refused above
    except ElementTree.ParseError as error:
        raise InputError(f"{file} is not XML ({error}); give a URDF file (run xacro first)") from error
    if root.tag != "robot":
        raise InputError(f"{file} starts with <{root.tag}>, but a URDF starts with <robot>; give a URDF file")
    return root


def read_numbers(element: ElementTree.Element | None, key: str, default: str, count: int, place: str) -> FloatArray:
    """Read an attribute as finite numbers.

    Args:
        element: The element; None for the default.
        key: Name of the attribute.
        default: Its text where it is missing.
        count: How many numbers there are.
        place: Where it stands, for messages.

    Returns:
        The numbers, shape (count,).

    Raises:
        InputError: There are not as many numbers, or one is not finite.
    """
    text = default if element is None else element.get(key, default)
    try:
        numbers = np.array([float(part) for part in text.split()])
    except ValueError:
        numbers = np.zeros(0)
    if element is not None and (numbers.shape != (count,) or not np.all(np.isfinite(numbers))):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"{place}: {key} of <{element.tag}> is '{text}', but must be {wanted}; correct the URDF")
    return numbers


def _vector(element: ElementTree.Element | None, key: str, default: str, place: str) -> FloatArray:
    return read_numbers(element, key, default, 3, place)


def _scalar(element: ElementTree.Element | None, key: str, place: str) -> float:
    return float(read_numbers(element, key, "0", 1, place)[0])


def _rotation(origin: ElementTree.Element | None, place: str) -> FloatArray:
    """Return the rotation matrix of an <origin>, shape (3, 3); the unit matrix without one."""
    from scipy.spatial.transform import Rotation  # loads slowly, and every plant node would wait for it

    matrix: FloatArray = Rotation.from_euler("xyz", _vector(origin, "rpy", "0 0 0", place)).as_matrix()
    return matrix


def _joint(element: ElementTree.Element, links: Mapping[str, ElementTree.Element], file: str) -> UrdfJoint:
    place = f"{file}: joint '{element.get('name')}'"
    ends: dict[str, str] = {}
    for end in ("parent", "child"):
        found = element.find(end)
        if found is None:
            raise InputError(f"{place} lacks <{end}>; correct the URDF")
        ends[end] = found.get("link", "")
        if ends[end] not in links:
            raise InputError(
                f"{place} names the {end} link '{ends[end]}', but the links are {', '.join(links)}; correct the URDF"
            )
    origin, mimic = element.find("origin"), element.find("mimic")
    kind = element.get("type", "")
    if kind not in KINDS:
        raise InputError(f"{place} has the type '{kind}', allowed are {', '.join(KINDS)}; correct the URDF")
    return UrdfJoint(
        name=element.get("name", ""),
        kind=kind,
        parent=ends["parent"],
        child=ends["child"],
        origin=_vector(origin, "xyz", "0 0 0", place),
        rotation=_rotation(origin, place),
        axis=_vector(element.find("axis"), "xyz", "1 0 0", place),
        effort=_scalar(element.find("limit"), "effort", place),
        velocity=_scalar(element.find("limit"), "velocity", place),
        damping=_scalar(element.find("dynamics"), "damping", place),
        friction=_scalar(element.find("dynamics"), "friction", place),
        mimics="" if mimic is None else mimic.get("joint", "another one"),
    )


def _refuse_loops(joints: Sequence[UrdfJoint], file: str) -> None:
    """Refuse links with two parents and closed chains: the joints must form a tree."""
    above: dict[str, UrdfJoint] = {}
    for joint in joints:
        if joint.child in above:
            raise InputError(
                f"{file}: joints '{above[joint.child].name}' and '{joint.name}' both carry the link '{joint.child}', "
                "but each link of a URDF has one parent; remove one of them"
            )
        above[joint.child] = joint
    clear: set[str] = set()
    for start in above:
        here, way = start, set[str]()
        while here in above and here not in clear:
            if here in way:
                raise InputError(
                    f"{file}: joint '{above[here].name}' closes a circle of joints through the link '{here}', but a "
                    "URDF is a tree and a robot here one serial chain; remove a joint of the circle"
                )
            way.add(here)
            here = above[here].parent
        clear |= way


def _inertial(link: ElementTree.Element, place: str) -> Inertial | None:
    """Read the mass of a link, in its own frame; None without one."""
    element = link.find("inertial")
    if element is None:
        return None
    origin, tensor = element.find("origin"), element.find("inertia")
    keys = ("xx", "yy", "zz", "xy", "xz", "yz")
    xx, yy, zz, xy, xz, yz = (0.0 if tensor is None else _scalar(tensor, f"i{key}", place) for key in keys)
    J = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    turn = _rotation(origin, place)
    center, mass = _vector(origin, "xyz", "0 0 0", place), _scalar(element.find("mass"), "value", place)
    if mass > 0 and np.max(np.abs(J)) > FARTHEST_MASS**2 * mass:
        J = np.zeros((3, 3))  # a placeholder, as 1 kg m2 of a frame of 1 mg
    return Inertial(mass, center, turn @ J @ turn.T)


def _together(parts: Sequence[Inertial]) -> Inertial | None:
    """Join masses that are fixed to each other (parallel axis theorem); None without any."""
    if len(parts) <= 1:
        return parts[0] if parts else None
    mass = sum(part.mass for part in parts)
    if mass <= 0:
        return Inertial(mass, parts[0].center, np.sum([part.inertia for part in parts], axis=0))
    center: FloatArray = np.sum([part.mass * part.center for part in parts], axis=0) / mass
    inertia: FloatArray = np.zeros((3, 3))
    for part in parts:
        inertia += part.inertia + point_inertia(part.mass, part.center - center)
    return Inertial(mass, center, inertia)
