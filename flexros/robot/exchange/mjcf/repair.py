"""Numbers of a robot written into a user's own MJCF, which otherwise stays as it was."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.config.text_file import read_text
from flexros.errors import InputError
from flexros.input_limits import LARGEST_URDF
from flexros.robot.exchange.body_inertia import ENTRIES, BodyInertia, point_mass
from flexros.robot.exchange.joint_names import tagged
from flexros.robot.exchange.mjcf.actuator_repair import ActuatorRepair
from flexros.robot.exchange.mjcf.actuators import actuators_of, added
from flexros.robot.exchange.mjcf.body_inertia import inertia_of, write_inertia
from flexros.robot.exchange.mjcf.mujoco_model import compile_text, mujoco_package
from flexros.robot.exchange.number_text import number, numbers_text
from flexros.robot.exchange.numbers import REWRITTEN, SAME, Export, NotHeld, Written, same
from flexros.robot.exchange.xml_text import XmlElement, XmlText
from flexros.robot.quantity import unit_of
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.robot.exchange.mjcf.arm import ArmJoint, MjcfArm
    from flexros.robot.exchange.mjcf.base_file import MjcfBase
    from flexros.robot.exchange.numbers import BodyNumbers, JointNumbers, RepairedNumbers
    from flexros.robot.symbolic.chain import Joint


def repair_mjcf(base: MjcfBase, robot: Robot, numbers: RepairedNumbers) -> Export:
    """Return a user's MJCF with the numbers of a robot: only attributes that differ are changed.

    Joints get damping, frictionloss and armature, actuators gain, limit and delay, as absolute values; bodies are
    scaled by the factor by which effects change mass and inertia.

    Args:
        base: The MJCF.
        robot: The robot with the changes of its effects.
        numbers: Its numbers on the joint side, as the joints of the MJCF count.

    Raises:
        InputError: A number cannot be written into the file.
    """
    source, arm, names = str(base.path), base.arm, base.names
    text, folder = XmlText(read_text(base.path, "MJCF", LARGEST_URDF), source), base.path.resolve().parent
    repair = _Repair(base.model, text, source, robot, numbers)
    for joint in numbers.joints:
        repair.joint(joint, names[joint.motor])
        repair.zero(joint, names[joint.motor])
        repair.actuators.actuator(joint, names[joint.motor])
    repair.springs()
    repair.gravity(arm)
    for body in numbers.bodies:
        repair.body(body, arm, names)
    repair.actuators.keep_damping(compile_text(text.text(), folder, source))
    changed = text.text()
    repair.check(compile_text(changed, folder, source))
    return Export(changed, tuple(repair.written), tuple(repair.not_held))


class _Repair:
    """The changes of one file."""

    def __init__(self, model: Any, text: XmlText, source: str, robot: Robot, numbers: RepairedNumbers) -> None:
        self.model, self.root, self.source, self.robot, self.numbers = model, text.root, source, robot, numbers
        self.written: list[Written] = []
        self.not_held = list(numbers.not_held)
        self.expected: list[tuple[str, int, float]] = []
        self.actuators = ActuatorRepair(model, text.root, source, self.written, self.not_held)

    def joint(self, joint: JointNumbers, name: str) -> None:
        """Write viscous friction, dry friction and rotor inertia of a motor."""
        element = self._element("joint", name)
        if "springdamper" in element.attributes:
            raise InputError(
                f"{self.source}: joint {name} has the attribute springdamper, which overrides its damping; replace it "
                "by stiffness and damping"
            )
        index = int(self.model.joint(name).id)
        dof, actuators = int(self.model.jnt_dofadr[index]), actuators_of(self.model, index)
        rows = (
            ("viscous friction", "damping", joint.damping, self.model.dof_damping[dof], "damping"),
            ("dry friction", "frictionloss", joint.friction, self.model.dof_frictionloss[dof], "torque"),
            ("rotor inertia", "armature", joint.armature, self.model.dof_armature[dof], "inertia"),
        )
        for quantity, attribute, wanted, own, kind in rows:
            of_actuators = 0.0 if attribute == "frictionloss" else added(self.model, actuators, f"actuator_{attribute}")
            before = float(own) + of_actuators
            if same(wanted, before):
                continue
            unit = unit_of(kind, joint.rotary)
            if wanted < of_actuators:
                reason = f"the actuators of {name} alone add {of_actuators:.6g} {unit}; lower their {attribute}"
                self.not_held.append(NotHeld(joint.motor, quantity, f"{wanted:.6g} {unit}", reason))
                continue
            further = getattr(self.model, f"dof_{attribute}poly", np.zeros((self.model.nv, 0)))[dof]
            values = [wanted - of_actuators, *(further if np.any(further) else ())]
            element.set(attribute, numbers_text(values))
            self.expected.append((f"dof_{attribute}", dof, values[0]))
            self._note(joint.motor, quantity, f"joint {name} {attribute}", before, wanted, unit)

    def zero(self, joint: JointNumbers, name: str) -> None:
        """Write another zero of the encoder: the position of the joint where the bodies are as the file draws them.

        The rest of a spring in the joint stays where it is in the arm.
        """
        if joint.zero == 0:
            return
        element, index = self._element("joint", name), int(self.model.joint(name).id)
        address = int(self.model.jnt_qposadr[index])
        angle = 1.0 if self.radian or not joint.rotary else float(np.degrees(1.0))
        unit = unit_of("position", joint.rotary)
        places = [("zero of the encoder", "ref", "qpos0")]
        if self.model.jnt_stiffness[index]:
            places.append(("rest of its spring", "springref", "qpos_spring"))
        for quantity, attribute, array in places:
            before = float(getattr(self.model, array)[address])
            element.set(attribute, number(angle * (before + joint.zero)))
            self.expected.append((array, address, before + joint.zero))
            self._note(joint.motor, quantity, f"joint {name} {attribute}", before, before + joint.zero, unit)

    @property
    def radian(self) -> bool:
        """Whether angles of the file are in radians; MuJoCo's default is degrees."""
        compilers = [child for child in self.root.children if child.tag == "compiler"]
        return any(each.attributes.get("angle") == "radian" for each in compilers)

    def springs(self) -> None:
        """Write stiffness and damper of elastic directions and gears where the file has joints for them."""
        squared = self.robot.motors[0].gear_ratio ** 2 if self.robot.spec.coordinates == "motor" else 1.0
        known = {str(self.model.joint(j).name) for j in range(self.model.njnt)}
        for joint in self.robot.joints:
            spring = joint.direction.spring
            if not isinstance(spring, Spring):
                continue
            units = unit_of("stiffness", joint.rotary), unit_of("damping", joint.rotary)
            wanted = squared * spring.at_zero, squared * joint.direction.damper.value
            name = tagged(self.robot, joint.name) or joint.name
            if name not in known:
                size = f"{wanted[0]:.6g} {units[0]}, damper {wanted[1]:.6g} {units[1]}"
                reason = "the file has no joint for this deflection; an export without a base file has one"
                self.not_held.append(NotHeld(joint.name, "stiffness", size, reason))
                continue
            element, index = self._element("joint", name), int(self.model.joint(name).id)
            own = float(self.model.jnt_stiffness[index]), float(self.model.dof_damping[self.model.jnt_dofadr[index]])
            for key, value, before, unit in zip(("stiffness", "damping"), wanted, own, units):
                if not same(value, before):
                    element.set(key, number(value))
                    self._note(joint.name, key, f"joint {name} {key}", before, value, unit)

    def gravity(self, arm: MjcfArm) -> None:
        """Write gravity where the base stands at a slant: the world of the file is turned about the arm."""
        if self.numbers.gravity is None:
            return
        wanted = arm.frame.T @ np.array(self.numbers.gravity)
        options = [child for child in self.root.children if child.tag == "option"]
        stated = [option for option in options if "gravity" in option.attributes] or options
        if stated:
            stated[-1].set("gravity", numbers_text(wanted))
        else:
            self.root.add("option", {"gravity": numbers_text(wanted)})
        for axis, before, value in zip("xyz", np.array(self.model.opt.gravity).tolist(), wanted.tolist(), strict=True):
            self._note("base", f"gravity {axis}", "option gravity", before, value, "m/s2")

    def body(self, body: BodyNumbers, arm: MjcfArm, names: Mapping[str, str]) -> None:
        """Scale mass and inertia, and the weight, of the bodies that a joint carries."""
        self.not_held += body.friction_not_held()
        changed = body.load is not None or body.rewritten or not same(body.inertia_factor, 1.0)
        if changed:
            self._numbers(body, arm, names)
        scaled = not changed and not same(body.mass_factor, 1.0)
        if not scaled and body.weight_error == 0:
            return
        joint = next((each for each in self.robot.joints[::-1] if f"body_{each.body + 1}" == body.body), None)
        carrier = None if joint is None else self._carrier(joint, arm, names)
        carried = () if carrier is None else carrier.bodies
        if not carried:
            size = f"mass x {body.mass_factor:.6g}, weight {body.weight_error:+.6g}"
            reason = "it is not clear which bodies of the file are meant"
            self.not_held.append(NotHeld(body.body, "payload", size, reason))
        for index in carried:
            label, mass = str(self.model.body(index).name), float(self.model.body_mass[index])
            if mass == 0:
                continue
            element = self._element("body", label)
            if scaled:
                self._scale(element, index, body.mass_factor)
                self.expected.append(("body_mass", index, mass * body.mass_factor))
                self._note(body.body, "mass", f"body {label} inertial", mass, mass * body.mass_factor, "kg")
                own = inertia_of(self.model, index).inertia
                self._inertia(body.body, label, own, body.mass_factor * own)
            if body.weight_error:
                before = float(self.model.body_gravcomp[index])
                if not same(before, -body.weight_error):
                    element.set("gravcomp", number(-body.weight_error))
                    self._note(body.body, "weight", f"body {label} gravcomp", before, -body.weight_error, "1")

    def _carrier(self, joint: Joint, arm: MjcfArm, names: Mapping[str, str]) -> ArmJoint | None:
        """Return the joint of the file that carries a body: that of the deflection, of an elastic gear."""
        joints = {each.name: each for each in arm.joints}
        own = joints.get(tagged(self.robot, joint.name) or joint.name)
        motor = None if joint.motor is None else joints.get(names[f"motor_{joint.motor + 1}"])
        return own if own is not None and own.bodies else motor

    def _carriers(self, arm: MjcfArm, names: Mapping[str, str]) -> dict[int, ArmJoint]:
        """Return the joint of the file that carries each body, by its index; none where the axes are others."""
        found, frame = {}, np.eye(3)
        for joint in (each for each in self.robot.joints if each.mode is None):
            frame = frame @ joint.turn
            carrier = self._carrier(joint, arm, names)
            if carrier is None or carrier.axis != joint.axis or not np.allclose(carrier.frame, frame, atol=1e-6):
                return {}
            found[joint.body] = carrier
        return found

    def _numbers(self, body: BodyNumbers, arm: MjcfArm, names: Mapping[str, str]) -> None:
        """Write mass, centre and inertia of a body with a load, or with other numbers."""
        carrier = self._carriers(arm, names).get(int(body.body.removeprefix("body_")) - 1)
        if carrier is None:
            self._list_numbers(
                body, "no joint of the file has the axes of this body; an export without a base file has it"
            )
            return
        index = int(self.model.jnt_bodyid[carrier.index])
        own, wanted = inertia_of(self.model, index), self._wanted(body, arm, carrier)
        if not wanted.possible:
            self._list_numbers(body, REWRITTEN)
            return
        label = str(self.model.body(index).name)
        write_inertia(wanted, self._element("body", label))
        self.expected.append(("body_mass", index, wanted.mass))
        self._inertia(body.body, label, own.inertia, wanted.inertia)
        if not same(body.inertia_factor, 1.0) and same(wanted.mass, own.mass):
            return
        what = "mass" if body.load is None else f"mass with a load of {body.load.mass:.6g} kg"
        self._note(body.body, what, f"body {label} inertial", own.mass, wanted.mass, "kg")
        for axis, before, value in zip("xyz", own.center.tolist(), wanted.center.tolist()):
            self._note(body.body, f"centre of mass {axis}", f"body {label} inertial pos", before, value, "m")

    def _inertia(self, body: str, label: str, own: FloatArray, wanted: FloatArray) -> None:
        """List the entries of an inertia [kg m2], shape (3, 3), that were changed."""
        for entry, at in ENTRIES.items():
            if not np.isclose(own[at], wanted[at], rtol=SAME, atol=SAME * np.abs(wanted).max()):
                place = f"body {label} inertial {entry}"
                self._note(body, "inertia", place, float(own[at]), float(wanted[at]), "kg m2")

    def _list_numbers(self, body: BodyNumbers, reason: str) -> None:
        self.not_held.append(NotHeld(body.body, *body.change, reason))

    def _wanted(self, body: BodyNumbers, arm: MjcfArm, carrier: ArmJoint) -> BodyInertia:
        """Return the numbers, in its frame, of the body of a joint that carries a body of the robot.

        Further bodies that the joint carries keep theirs.
        """
        index, data = int(self.model.jnt_bodyid[carrier.index]), mujoco_package().MjData(self.model)
        mujoco_package().mj_kinematics(self.model, data)
        axes, origin = data.xmat[index].reshape(3, 3).T, data.xpos[index]
        turn = axes @ arm.frame.T @ carrier.frame
        anchor = axes @ (arm.frame.T @ carrier.anchor - origin)
        if body.load is not None and not body.rewritten:
            place = anchor + turn @ np.array(body.load.place)
            return inertia_of(self.model, index).plus(point_mass(body.load.mass, place))
        spec = self.robot.spec.bodies[int(body.body.removeprefix("body_")) - 1]
        wanted = BodyInertia.of(spec).moved(turn, anchor)
        for other in (each for each in carrier.bodies if each != index):
            relative, offset = axes @ data.xmat[other].reshape(3, 3), axes @ (data.xpos[other] - origin)
            wanted = wanted.plus(inertia_of(self.model, other).moved(relative, offset), -1)
        return wanted

    def check(self, model: Any) -> None:
        """Refuse a result in which something else of the file overrides the numbers that were written."""
        for array, index, wanted in self.expected:
            found = float(getattr(model, array)[index])
            if abs(found - wanted) > 1e-6 * abs(wanted):
                owner = model.body(index) if array == "body_mass" else self._joint_of(array, index)
                raise InputError(
                    f"{self.source}: {array.rpartition('_')[2]} of {owner.name} was set to {wanted:.6g}, but MuJoCo "
                    f"makes it {found:.6g}: another setting overrides it, such as inertiafromgeom or settotalmass of "
                    "<compiler>, or a <flag> that disables it; remove that setting"
                )
        self.actuators.check(model)

    def _joint_of(self, array: str, index: int) -> Any:
        """Return the joint of an entry of an array over positions or degrees of freedom."""
        if array.startswith("qpos"):
            return self.model.joint(int(np.flatnonzero(self.model.jnt_qposadr == index)[0]))
        return self.model.joint(int(self.model.dof_jntid[index]))

    def _scale(self, element: XmlElement, index: int, factor: float) -> None:
        mass = number(factor * float(self.model.body_mass[index]))
        inertial = element.find("inertial")
        if inertial is None:
            attributes = {
                "pos": numbers_text(self.model.body_ipos[index]),
                "quat": numbers_text(self.model.body_iquat[index]),
                "mass": mass,
                "diaginertia": numbers_text(factor * self.model.body_inertia[index]),
            }
            element.add("inertial", attributes)
            return
        inertial.set("mass", mass)
        for key in ("diaginertia", "fullinertia"):
            if key in inertial.attributes:
                values = np.array(inertial.attributes[key].split(), dtype=float)
                inertial.set(key, numbers_text(factor * values))

    def _note(self, location: str, quantity: str, place: str, before: float | None, value: float, unit: str) -> None:
        self.written.append(Written(location, quantity, place, before, value, unit))

    def _element(self, tag: str, name: str) -> XmlElement:
        """Return a named element of the world's bodies."""
        worlds = [child for child in self.root.children if child.tag == "worldbody"]
        for element in (each for world in worlds for each in world.iter(tag)):
            if element.attributes.get("name") == name:
                return element
        raise InputError(
            f"{self.source}: the {tag} '{name}' is not in the file itself (it is included, replicated or has "
            "no name); give a file that holds it, with a name"
        )
