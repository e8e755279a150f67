"""Export of a robot as an MJCF for MuJoCo."""

from __future__ import annotations

from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np

from flexros.robot.exchange.body_inertia import ENTRIES, BodyInertia
from flexros.robot.exchange.link_inertia import LEAST, possible_tensor
from flexros.robot.exchange.mjcf.time_step import time_step
from flexros.robot.exchange.number_text import number, numbers_text
from flexros.robot.exchange.numbers import Export, NotHeld, Written
from flexros.robot.link_shape import link_shapes, tool_offset
from flexros.robot.quantity import unit_of
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.exchange.numbers import JointNumbers, RepairedNumbers
    from flexros.robot.specification import Body
    from flexros.robot.symbolic.chain import Joint

FRICTION_STEPS = 2
"""Time constant of the dry friction's constraint, in time steps [1]: the shortest that MuJoCo accepts."""

DELAY = "actuator delay with interp linear"
"""Place of a delay."""


def mjcf_export(robot: Robot, numbers: RepairedNumbers) -> Export:
    """Return a robot as an MJCF on the joint side of its gears.

    Bodies are `body_1`, `body_2`, ..., with frames parallel to the world at zero. Motors are the joints `motor_1`, ...;
    behind a flexible gear the joint `body_1.ry` follows, whose position is the deflection of the gear, arm minus motor.
    Elastic directions are joints with the names of the arm coordinates. The controls are the motor torques of the robot
    file, or the commanded positions of its servos: with values stated on the motor side the attribute `gear` is the
    gear ratio.

    Args:
        robot: The robot with the changes of its effects.
        numbers: Its numbers on the joint side.
    """
    return _Writer(robot, numbers).export()


def delay_attributes(delay: float, step: float) -> dict[str, str]:
    """Return the attributes of an actuator for a delay [s]: the buffer holds the controls of that time.

    Between two steps of the simulator the control of the delay is interpolated.
    """
    if delay <= 0:
        return {}
    return {"delay": number(delay), "nsample": str(int(np.ceil(delay / step - 1e-9))), "interp": "linear"}


class _Writer:
    """Elements of the file, and the list of what was written."""

    def __init__(self, robot: Robot, numbers: RepairedNumbers) -> None:
        self.robot, self.numbers = robot, numbers
        self.squared = 1.0
        if robot.spec.coordinates == "motor":
            self.squared = robot.motors[0].gear_ratio ** 2
        self.written: list[Written] = []
        self.not_held = list(numbers.not_held)
        self.root = ElementTree.Element("mujoco", model=robot.name)

    def export(self) -> Export:
        """Write all elements."""
        spec = self.robot.spec
        step, integrator = time_step(self.robot, self.numbers)
        ElementTree.SubElement(self.root, "compiler", angle="radian", autolimits="true")
        option = {"timestep": number(step), "gravity": numbers_text(spec.gravity.value), "integrator": integrator}
        ElementTree.SubElement(self.root, "option", option)
        self._note("all", "time step", f"option timestep with {integrator}", step, "s")
        for axis, value in zip("xyz", self.numbers.gravity or ()):
            self._note("base", f"gravity {axis}", "option gravity", value, "m/s2")
        place = ElementTree.SubElement(self.root, "worldbody")
        offset = np.zeros(3)
        for index, body in enumerate(spec.bodies):
            place = ElementTree.SubElement(place, "body", name=f"body_{index + 1}", pos=numbers_text(offset))
            if any(body.orientation):
                place.set("euler", numbers_text(body.orientation))
                self.root[0].set("eulerseq", "XYZ")  # about fixed axes, as in a URDF
            weight = self.numbers.bodies[index].weight_error
            if weight:
                place.set("gravcomp", number(-weight))
                self._note(f"body_{index + 1}", "weight", "body gravcomp", -weight, "1")
            self._inertial(place, index, body)
            for joint in self.robot.joints:
                if joint.body == index and joint.mode is None:
                    self._joints(place, joint, step)
                elif joint.body == index:
                    self._bending(joint)
            offset = np.array(body.length.value, dtype=float)
        self._shapes()
        if spec.tool.linear is None:
            ElementTree.SubElement(place, "site", name="tool", pos=numbers_text(tool_offset(spec)))
        self._absolute_friction()
        actuators = ElementTree.SubElement(self.root, "actuator")
        for motor in self.numbers.joints:
            self._actuator(actuators, motor, step)
        ElementTree.indent(self.root)
        text = f"{ElementTree.tostring(self.root, encoding='unicode')}\n"
        return Export(text, tuple(self.written), tuple(self.not_held))

    def _note(self, location: str, quantity: str, place: str, value: float, unit: str) -> None:
        self.written.append(Written(location, quantity, place, None, value, unit))

    def _inertial(self, element: Element, index: int, body: Body) -> None:
        tensor = self.squared * body.straight_inertia()
        mass = body.mass.value
        attributes = {
            "pos": numbers_text(body.center_of_mass.value),
            "mass": number(max(mass, LEAST)),
            "fullinertia": numbers_text(_entries(possible_tensor(self.robot, tensor))),
        }
        ElementTree.SubElement(element, "inertial", attributes)
        numbers, place = BodyInertia(mass, np.array(body.center_of_mass.value), tensor), "body/inertial"
        self.written += numbers.written(f"body_{index + 1}", f"{place} mass", f"{place} pos", f"{place} fullinertia")

    def _joints(self, element: Element, joint: Joint, step: float) -> None:
        if joint.motor is None:
            self._elastic(element, joint)
            return
        motor = self.numbers.joints[joint.motor]
        attributes = {
            "damping": number(motor.damping),
            "armature": number(motor.armature),
            "frictionloss": number(motor.friction),
        }
        if motor.friction:
            attributes["solreffriction"] = numbers_text((FRICTION_STEPS * step, 1.0))
        if motor.zero:
            attributes["ref"] = number(motor.zero)
            self._note(motor.motor, "zero of the encoder", "joint ref", motor.zero, unit_of("position", joint.rotary))
        self._joint(element, motor.motor, joint, attributes)
        unit = {kind: unit_of(kind, joint.rotary) for kind in ("damping", "inertia", "torque")}
        self._note(motor.motor, "viscous friction", "joint damping", motor.damping, unit["damping"])
        self._note(motor.motor, "dry friction", "joint frictionloss", motor.friction, unit["torque"])
        self._note(motor.motor, "rotor inertia", "joint armature", motor.armature, unit["inertia"])
        if joint.motor_coordinate is not None:
            self._elastic(element, joint)

    def _elastic(self, element: Element, joint: Joint) -> None:
        spring = joint.direction.spring
        assert isinstance(spring, Spring)
        stiffness, damping = spring.at_zero * self.squared, joint.direction.damper.value * self.squared
        self._joint(element, joint.name, joint, {"stiffness": number(stiffness), "damping": number(damping)})
        place = f"joint {joint.name}"
        self._note(joint.name, "stiffness", f"{place} stiffness", stiffness, unit_of("stiffness", joint.rotary))
        self._note(joint.name, "damper", f"{place} damping", damping, unit_of("damping", joint.rotary))

    def _bending(self, joint: Joint) -> None:
        """List stiffness and damper of a mode of a link that bends."""
        spring, reason = joint.direction.spring, "the link is written as straight"
        assert isinstance(spring, Spring)
        rows = ("stiffness", spring.at_zero, "stiffness"), ("damper", joint.direction.damper.value, "damping")
        for name, value, kind in rows:
            size = f"{self.squared * value:.6g} {unit_of(kind, joint.rotary)}"
            self.not_held.append(NotHeld(joint.name, name, size, reason))

    def _joint(self, element: Element, name: str, joint: Joint, attributes: dict[str, str]) -> None:
        kind = "hinge" if joint.rotary else "slide"
        axis = numbers_text(np.eye(3)[joint.axis])
        ElementTree.SubElement(element, "joint", {"name": name, "type": kind, "axis": axis, **attributes})

    def _actuator(self, element: Element, joint: JointNumbers, step: float) -> None:
        ratio = float(np.sqrt(self.squared))
        gear = ratio * joint.torque_gain
        attributes = {"name": joint.motor, "joint": joint.motor, "gear": number(gear)}
        servo = joint.servo_stiffness is not None
        if servo:
            attributes |= self._servo(joint)
        else:
            self._note(joint.motor, "torque per control", "actuator gear", gear, "1")
        if joint.torque_limit is not None:
            limit = joint.torque_limit / ratio
            place = "forcerange" if servo else "ctrlrange"
            attributes[place] = numbers_text((-limit, limit))
            torque = unit_of("torque", joint.rotary)
            self._note(joint.motor, "torque limit", f"actuator {place}", limit, torque)
        attributes |= delay_attributes(joint.delay, step)
        if joint.delay > 0:
            self._note(joint.motor, "delay", DELAY, joint.delay, "s")
        ElementTree.SubElement(element, "position" if servo else "motor", attributes)

    def _servo(self, joint: JointNumbers) -> dict[str, str]:
        """Return the gains of a servo, whose control is the position of the motor in the robot file."""
        attributes = {}
        for key, kind, value in (
            ("kp", "stiffness", joint.servo_stiffness or 0.0),
            ("kv", "damping", joint.servo_damping or 0.0),
        ):
            attributes[key] = number(value / self.squared)
            unit = unit_of(kind, joint.rotary)
            self._note(joint.motor, f"servo {kind}", f"actuator {key}", value / self.squared, unit)
        if joint.servo_lag:
            attributes["timeconst"] = number(joint.servo_lag)
            self._note(joint.motor, "lag of the control", "actuator timeconst", joint.servo_lag, "s")
        return attributes

    def _shapes(self) -> None:
        bodies = {element.get("name"): element for element in self.root.iter("body")}
        for shape in link_shapes(self.robot.spec):
            attributes = {
                "type": "capsule",
                "fromto": numbers_text((*shape.start, *shape.end)),
                "size": number(shape.radius),
                "contype": "0",
                "conaffinity": "0",
                "group": "1",
            }
            ElementTree.SubElement(bodies[f"body_{shape.body + 1}"], "geom", attributes)

    def _absolute_friction(self) -> None:
        """Write friction against the absolute rotation of bodies, as tendons over the joints before them."""
        rubbing = [k for k, body in enumerate(self.robot.spec.bodies) if body.viscous_friction.value]
        rotary = [joint for joint in self.robot.joints if joint.rotary]
        if len({joint.axis for joint in rotary}) > 1 or self.robot.chain.turned:
            self.not_held += [each for k in rubbing for each in self.numbers.bodies[k].friction_not_held()]
            return
        tendons = ElementTree.SubElement(self.root, "tendon") if rubbing else None
        for k in rubbing:
            assert tendons is not None
            damping = self.squared * self.robot.spec.bodies[k].viscous_friction.value
            name = f"body_{k + 1}.viscous_friction"
            tendon = ElementTree.SubElement(tendons, "fixed", name=name, damping=number(damping))
            for joint in (each for each in rotary if each.body <= k):
                names = [joint.name] if joint.motor is None else [f"motor_{joint.motor + 1}"]
                if joint.motor is not None and joint.motor_coordinate is not None:
                    names.append(joint.name)
                for each in names:
                    ElementTree.SubElement(tendon, "joint", joint=each, coef="1")
            self._note(f"body_{k + 1}", "viscous friction", "tendon/fixed damping", damping, "Nm s/rad")


def _entries(tensor: FloatArray) -> tuple[float, ...]:
    return tuple(float(tensor[at]) for at in ENTRIES.values())
