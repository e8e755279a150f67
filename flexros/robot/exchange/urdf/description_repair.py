"""Numbers of a robot written into a URDF or SDF, which otherwise stays as it was."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from flexros.errors import InputError
from flexros.robot.body_placement import BodyPlacements
from flexros.robot.exchange.body_inertia import BodyInertia, point_mass
from flexros.robot.exchange.joint_names import motor_joints
from flexros.robot.exchange.link_inertia import LEAST
from flexros.robot.exchange.number_text import number
from flexros.robot.exchange.numbers import REWRITTEN, Export, NotHeld, Written, same
from flexros.robot.exchange.urdf.link_inertial import changes_of_link, link_axes, link_inertia, write_link_inertia
from flexros.robot.exchange.urdf.robot_import import turned_base
from flexros.robot.exchange.urdf.tree import NO_LIMIT, read_tree
from flexros.robot.exchange.xml_text import XmlElement, XmlText
from flexros.robot.quantity import unit_of
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.exchange.numbers import BodyNumbers, JointNumbers, LoadNumbers, RepairedNumbers

Description = Literal["urdf", "sdf"]

MOVABLE = ("revolute", "continuous", "prismatic")

NO_ARMATURE = "joints of {kind} have no rotor inertia; set it in the simulator, e.g. as armature"
NO_SPRING = "the deflection of a gear or link is no joint in {kind}"
NO_SERVO = "{kind} has no position loop: set its gains in the controller, e.g. of ros2_control"
WRONG_ZERO = (
    "it is in the encoder, not in the arm: correct the zero of the joint, or subtract it from measured positions"
)
NO_GRAVITY = "gravity of a {kind} is that of the world: turn the base, or set it in the simulator"
NO_COMMAND = "{kind} says nothing of commands: set it in the controller"


def repair_description(
    text: str,
    source: str,
    kind: Description,
    robot: Robot,
    numbers: RepairedNumbers,
    joints: Mapping[str, str],
    *,
    new: bool = False,
) -> Export:
    """Return a URDF or SDF with the numbers of a robot: only attributes or texts that differ are changed.

    Joints get damping, friction and effort, as absolute values; links are scaled by the factor by which effects change
    mass and inertia, or, in a URDF, get the difference that effects make to mass, centre and inertia.

    Args:
        text: The document.
        source: Its file, for error messages.
        kind: Its format.
        robot: The robot with the changes of its effects.
        numbers: Its numbers on the joint side.
        joints: Joint of the file by motor; default: as in `motor_joints`.
        new: Whether the text was made from the same robot: masses are right, and all numbers are listed.

    Raises:
        InputError: It is not of this format, or it is not clear which joint is meant.
    """
    document = XmlText(text, source)
    expected = {"urdf": "robot", "sdf": "sdf"}[kind]
    if document.root.tag != expected:
        raise InputError(
            f"{source} starts with <{document.root.tag}>, but a {kind.upper()} starts with <{expected}>", "base"
        )
    repair = _Repair(document, kind, numbers, new, robot)
    names = motor_joints(robot, list(repair.joints), joints, source)
    for joint in numbers.joints:
        repair.joint(joint, names[joint.motor])
    for body in numbers.bodies:
        repair.body(body)
    repair.springs(robot)
    repair.gravity()
    return Export(document.text(), tuple(repair.written), tuple(repair.not_held))


class _Repair:
    """The changes of one file."""

    def __init__(self, document: XmlText, kind: Description, numbers: RepairedNumbers, new: bool, robot: Robot) -> None:
        self.root, self.kind, self.new, self.source = document.root, kind, new, document.source
        self.robot, self.text = robot, document.text()
        self.written: list[Written] = []
        self.numbers, self.not_held = numbers, list(numbers.not_held)
        bodies = enumerate(robot.spec.bodies, 1)
        self.bodies = {name for k, body in bodies for name in (body.label, f"body_{k}")}
        every = [joint for joint in self.root.iter("joint") if self._end(joint, "child")]
        self.above = {self._end(joint, "child"): self._end(joint, "parent") for joint in every}
        movable = [joint for joint in every if joint.attributes.get("type") in MOVABLE]
        movable.sort(key=lambda joint: len(self._way(self._end(joint, "parent"))))  # in the order of the chain
        self.joints = {joint.attributes.get("name", ""): joint for joint in movable}

    def _end(self, joint: XmlElement, tag: str) -> str:
        """Return the link before (parent) or behind (child) a joint, empty for an element that is none."""
        end = joint.find(tag)
        return "" if end is None else (end.attributes.get("link", "") or end.content.strip())

    def _way(self, link: str) -> list[str]:
        """Return the links before a link, from it to the base."""
        way: list[str] = []
        while link in self.above and link not in way:
            way.append(link)
            link = self.above[link]
        return way

    def _carried(self, link: str) -> list[XmlElement]:
        """Return a link, and all behind it that are no body of their own, such as a tool that is fixed to it."""
        found = []
        for each in self.root.iter("link"):
            way = self._way(each.attributes.get("name", ""))
            before = way[: way.index(link)] if link in way else None
            if each.attributes.get("name") == link or (before is not None and not self.bodies.intersection(before)):
                found.append(each)
        return found

    def joint(self, joint: JointNumbers, name: str) -> None:
        """Write friction and torque limit of a motor, and list the rest."""
        element = self.joints[name]
        home: XmlElement | None = element
        if self.kind == "sdf":
            home = element.find("axis")
            if home is None:
                raise InputError(f"the joint {name} has no <axis>; correct the SDF")
        assert home is not None
        damping, torque = unit_of("damping", joint.rotary), unit_of("torque", joint.rotary)
        self._set(
            home,
            "dynamics",
            (
                Written(
                    joint.motor, "viscous friction", f"joint {name} dynamics damping", None, joint.damping, damping
                ),
                Written(joint.motor, "dry friction", f"joint {name} dynamics friction", None, joint.friction, torque),
            ),
        )
        if joint.torque_limit is not None:
            place = f"joint {name} limit effort"
            self._set(home, "limit", (Written(joint.motor, "torque limit", place, None, joint.torque_limit, torque),))
        inertia, stiffness = unit_of("inertia", joint.rotary), unit_of("stiffness", joint.rotary)
        self._lost(joint.motor, "rotor inertia", joint.armature, inertia, NO_ARMATURE)
        self._lost(joint.motor, "stiffness of the gear", joint.stiffness or 0.0, stiffness, NO_SPRING)
        self._lost(joint.motor, "delay", joint.delay, "s", NO_COMMAND)
        self._lost(joint.motor, "servo stiffness", joint.servo_stiffness or 0.0, stiffness, NO_SERVO)
        self._lost(joint.motor, "servo damping", joint.servo_damping or 0.0, damping, NO_SERVO)
        self._lost(joint.motor, "lag of the control", joint.servo_lag or 0.0, "s", NO_SERVO)
        self._lost(joint.motor, "torque gain", joint.torque_gain - 1, "relative", NO_COMMAND)
        self._lost(joint.motor, "zero of the encoder", joint.zero, unit_of("position", joint.rotary), WRONG_ZERO)

    def body(self, body: BodyNumbers) -> None:
        """Scale mass and inertia of a link."""
        self._lost(body.body, "weight", body.weight_error, "relative", "{kind} has one mass for weight and inertia")
        self.not_held += body.friction_not_held()
        if self.new:
            own = BodyInertia.of(self.robot.spec.bodies[int(body.body.removeprefix("body_")) - 1])
            place = f"link {body.body} inertial"
            self.written += own.written(body.body, f"{place} mass", place, f"{place} inertia")
            return
        if body.rewritten and self.kind == "sdf":
            self.not_held.append(NotHeld(body.body, "numbers", body.beside_load or body.rewritten, REWRITTEN))
            body = replace(body, rewritten="")
        unchanged = same(body.mass_factor, 1.0) and same(body.inertia_factor, 1.0) and body.load is None
        unchanged = unchanged and not body.rewritten
        if unchanged:
            return
        wanted = (body.label, body.body)
        link = next((each for each in self.root.iter("link") if each.attributes.get("name") in wanted), None)
        if link is None or self._mass_of(link) is None:
            reason = f"no link '{body.label or body.body}' with a mass was found"
            self.not_held.append(NotHeld(body.body, *body.change, reason))
            return
        if body.rewritten:
            self._numbers(link, body)
            return
        if body.load is not None:
            self._load(link, body.body, body.load)
            return
        carried = [each for each in self._carried(link.attributes["name"]) if (self._mass_of(each) or 0.0) > LEAST]
        if len(carried) > 1 and not same(body.inertia_factor, 1.0):
            names = ", ".join(each.attributes["name"] for each in carried)
            reason = f"it is that of several links as one ({names}); an export without a base file has it"
            self.not_held.append(NotHeld(body.body, *body.change, reason))
            return
        for each in carried:
            self._scale(each, body)

    def _mass_of(self, link: XmlElement) -> float | None:
        """Return the mass of a link [kg]; None where it states none."""
        mass = _mass_element(link)
        if mass is None:
            return None
        return self._float(mass.attributes.get("value") or mass.content, f"link {link.attributes['name']} mass")

    def _scale(self, link: XmlElement, body: BodyNumbers) -> None:
        """Scale mass and inertia of a link that has a mass."""
        inertial, mass, before = link.find("inertial"), _mass_element(link), self._mass_of(link)
        assert inertial is not None
        assert mass is not None
        assert before is not None
        place = f"link {link.attributes['name']} inertial"
        if not same(body.mass_factor, 1.0):
            self._write(mass, "value", body.mass_factor * before)
            self.written.append(Written(body.body, "mass", place, before, body.mass_factor * before, "kg"))
        inertia, factor = inertial.find("inertia"), body.mass_factor * body.inertia_factor
        for entry in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz") if inertia else ():
            assert inertia is not None
            own = inertia if self.kind == "urdf" else inertia.find(entry)
            if own is None or not (value := own.attributes.get(entry) or own.content):
                continue
            before = self._float(value, f"{place} {entry}")
            self._write(own, entry, factor * before)
            if before:
                self.written.append(Written(body.body, "inertia", f"{place} {entry}", before, factor * before, "kg m2"))

    def _load(self, link: XmlElement, body: str, load: LoadNumbers) -> None:
        """Add a point mass to a link of a URDF."""
        if self.kind == "sdf":
            reason = "the links of an SDF have frames of their own: add it there"
            self.not_held.append(NotHeld(body, "load", load.words, reason))
            return
        name = link.attributes["name"]
        own, turn = link_inertia(link, self.source), link_axes(self.root, name, self.source, self._turn(name, body))
        whole = own.plus(point_mass(load.mass, turn @ np.array(load.place)))
        write_link_inertia(link, whole)
        mass, *others = changes_of_link(body, name, own, whole)
        self.written += [replace(mass, quantity=f"load of {load.words}: mass"), *others]

    def _numbers(self, link: XmlElement, body: BodyNumbers) -> None:
        """Change mass, centre and inertia of a link of a URDF as those of its body; further links of it keep theirs."""
        name, nominal = link.attributes["name"], body.nominal
        assert nominal is not None
        spec = self.robot.spec.bodies[int(body.body.removeprefix("body_")) - 1]
        turn, joint = link_axes(self.root, name, self.source, self._turn(name, body.body)), np.zeros(3)
        own = link_inertia(link, self.source)
        whole = own.plus(BodyInertia.of(spec).moved(turn, joint)).plus(nominal.moved(turn, joint), -1)
        if whole.possible:
            write_link_inertia(link, whole)
            self.written += changes_of_link(body.body, name, own, whole)
            return
        reason = f"the link {name} cannot have them; an export without a base file has these"
        self.not_held.append(NotHeld(body.body, "numbers", body.beside_load or body.rewritten, reason))
        if body.load is not None:
            self._load(link, body.body, body.load)

    def _turn(self, link: str, body: str) -> FloatArray:
        """Return the rotation from the frame of a body to the base of the URDF, all joints at zero, shape (3, 3)."""
        _, at_zero = BodyPlacements(self.robot).at(np.zeros((1, self.robot.n_arm)))
        own = any(self.robot.joints[0].orientation)  # then its base is that of the URDF
        base = np.eye(3) if own else turned_base(read_tree(self.text, self.source).chain(link))
        return np.asarray(base.T @ at_zero[0, int(body.removeprefix("body_")) - 1])

    def springs(self, robot: Robot) -> None:
        """List stiffness and damper of elastic directions and of bending, and the damper of elastic gears."""
        squared = robot.motors[0].gear_ratio ** 2 if robot.spec.coordinates == "motor" else 1.0
        for joint in robot.joints:
            spring = joint.direction.spring
            if not isinstance(spring, Spring):
                continue
            damping, unit = squared * joint.direction.damper.value, unit_of("damping", joint.rotary)
            if joint.motor is not None:
                self._lost(f"motor_{joint.motor + 1}", "damper of the gear", damping, unit, NO_SPRING)
                continue
            self._lost(joint.name, "stiffness", squared * spring.at_zero, unit_of("stiffness", joint.rotary), NO_SPRING)
            self._lost(joint.name, "damper", damping, unit, NO_SPRING)

    def gravity(self) -> None:
        """List gravity where the base stands at a slant."""
        if self.numbers.gravity is not None:
            size = f"{', '.join(f'{value:.6g}' for value in self.numbers.gravity)} m/s2 in the frame of the base"
            self.not_held.append(NotHeld("base", "gravity", size, NO_GRAVITY.format(kind=self.kind.upper())))

    def _set(self, home: XmlElement, tag: str, wanted: tuple[Written, ...]) -> None:
        """Set values of an element `tag` inside another one; the key is the last word of the place."""
        element = home.find(tag)
        missing: dict[str, str] = {}
        for each in wanted:
            key = each.place.split()[-1]
            own = None if element is None else (element if self.kind == "urdf" else element.find(key))
            text = "" if own is None else (own.attributes.get(key, "") if self.kind == "urdf" else own.content)
            before = self._float(text, each.place) if text.strip() else None
            if same(each.value, before or 0.0):
                self.written += [each] if self.new else []
                continue
            if own is not None:
                self._write(own, key, each.value)
            elif element is not None:
                element.add_text(key, number(each.value))
            else:
                missing[key] = number(each.value)
            self.written.append(each if self.new else replace(each, before=before))
        if missing and self.kind == "urdf":
            if tag == "limit" and element is None:  # urdfdom refuses a limit without a velocity
                missing["velocity"] = number(NO_LIMIT)
            home.add(tag, missing)
        elif missing:
            home.add(tag, {}, missing)

    def _float(self, text: str, place: str) -> float:
        try:
            return float(text)
        except ValueError:
            raise InputError(
                f"{self.source}: {place} is '{text.strip()}', but must be a number; correct the file", "base"
            ) from None

    def _write(self, element: XmlElement, key: str, value: float) -> None:
        if self.kind == "urdf":
            element.set(key, number(value))
        else:
            element.set_text(number(value))

    def _lost(self, location: str, name: str, value: float, unit: str, reason: str) -> None:
        if np.abs(value) > 0:
            size = f"{value:.6g} {unit}"
            self.not_held.append(NotHeld(location, name, size, reason.format(kind=self.kind.upper())))


def _mass_element(link: XmlElement) -> XmlElement | None:
    inertial = link.find("inertial")
    return None if inertial is None else inertial.find("mass")
