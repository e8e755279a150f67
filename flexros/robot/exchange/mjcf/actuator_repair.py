"""Gains, limits and delays of actuators written into a user's own MJCF, and kept where a damping ratio makes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.errors import InputError
from flexros.robot.exchange.mjcf.actuators import actuators_of, joint_actuator
from flexros.robot.exchange.mjcf.export import DELAY, delay_attributes
from flexros.robot.exchange.number_text import number, numbers_text
from flexros.robot.exchange.numbers import NotHeld, Written, same
from flexros.robot.quantity import unit_of

if TYPE_CHECKING:
    from flexros.robot.exchange.mjcf.actuators import JointActuator
    from flexros.robot.exchange.numbers import JointNumbers
    from flexros.robot.exchange.xml_text import XmlElement


class ActuatorRepair:
    """The changes of the actuators of one file.

    Attributes:
        gain: Entries of gainprm that actuators shall have, shape (n, 3).
        bias: Those of biasprm, shape (n, 3).
        gear: First entries of gear, shape (n,).
    """

    def __init__(
        self, model: Any, root: XmlElement, source: str, written: list[Written], not_held: list[NotHeld]
    ) -> None:
        """Start from a file.

        Args:
            model: The compiled model of the file, mujoco.MjModel.
            root: Its outermost element.
            source: The file, for error messages.
            written: Where to list what was written.
            not_held: Where to list what has no place.
        """
        self.model, self.root, self.source, self.written, self.not_held = model, root, source, written, not_held
        self.gain = np.array(model.actuator_gainprm[:, :3])
        self.bias = np.array(model.actuator_biasprm[:, :3])
        self.gear = np.array(model.actuator_gear[:, 0])
        self._motors: dict[int, JointNumbers] = {}

    def actuator(self, joint: JointNumbers, name: str) -> None:
        """Write torque gain, torque limit and delay of a motor."""
        index = int(self.model.joint(name).id)
        found, torque = actuators_of(self.model, index), unit_of("torque", joint.rotary)
        before = joint_actuator(self.model, index)
        limit = None if before is None else before.torque_limit
        limited = joint.torque_limit is not None and (limit is None or not same(joint.torque_limit, limit))
        if before is None or not found:
            lost = {"torque gain": joint.torque_gain != 1, "torque limit": limited, "delay": joint.delay > 0}
            reason = f"no actuator drives the joint {name}"
            self.not_held += [NotHeld(joint.motor, key, "", reason) for key, value in lost.items() if value]
            return
        element = self._actuator_element(found[0], name)
        self._motors[found[0]] = joint
        if joint.servo_stiffness is not None:
            self._servo(element, found[0], joint, before)
        elif joint.torque_gain != 1:
            self._gain(element, found[0], joint)
        if limited and joint.torque_limit is not None:
            force = joint.torque_limit / abs(before.gear)
            element.set("forcerange", numbers_text((-force, force)))
            element.set("forcelimited", "true")
            self._note(joint.motor, "torque limit", f"{element.tag} forcerange", limit, joint.torque_limit, torque)
        if not same(joint.delay, before.delay):
            if not hasattr(self.model, "actuator_delay"):
                reason = "actuators have a delay from MuJoCo 3.5 on"
                self.not_held.append(NotHeld(joint.motor, "delay", f"{joint.delay:.6g} s", reason))
                return
            attributes = delay_attributes(joint.delay, float(self.model.opt.timestep)) or {"delay": "0"}
            for key, value in attributes.items():
                element.set(key, value)
            self._note(joint.motor, "delay", DELAY.replace("actuator", element.tag), before.delay, joint.delay, "s")

    def keep_damping(self, changed: Any) -> None:
        """Write the speed gains that a damping ratio, also of a class, makes anew from changed gains and inertias.

        Args:
            changed: The compiled model with all other changes.
        """
        for index in range(self.model.nu):
            bias = self.bias[index]
            if same(float(bias[2]), float(changed.actuator_biasprm[index, 2])):
                continue
            name = str(self.model.actuator(index).name)
            motor = self._motors.get(index)
            element = self._actuator_element(index, "" if motor is None else self._joint_of(index))
            if element.tag == "general":
                place = "biasprm"
                element.set(place, numbers_text(bias))
            else:
                place = "kv"
                element.remove("dampratio")
                element.set(place, number(-float(bias[2])))
            kv, old = (-float(each[index, 2]) for each in (self.bias, self.model.actuator_biasprm))
            unit = "" if motor is None else unit_of("damping", motor.rotary)
            scale = 1.0 if motor is None else float(self.gear[index]) ** 2
            location = name if motor is None else motor.motor
            self._note(location, "servo damping", f"{element.tag} {place} for dampratio", scale * old, scale * kv, unit)

    def check(self, model: Any) -> None:
        """Refuse a compiled model with other gains than those of the numbers.

        Raises:
            InputError: A gain differs.
        """
        rows = (
            ("gear", self.gear[:, None], model.actuator_gear[:, :1]),
            ("gainprm", self.gain, model.actuator_gainprm[:, :3]),
            ("biasprm", self.bias, model.actuator_biasprm[:, :3]),
        )
        for key, wanted, found in rows:
            wrong = np.flatnonzero(np.any(np.abs(found - wanted) > 1e-6 * np.abs(wanted), axis=1))
            if len(wrong):
                index = int(wrong[0])
                raise InputError(
                    f"{self.source}: {key} of actuator '{model.actuator(index).name}' was to be "
                    f"{numbers_text(wanted[index])}, but MuJoCo makes it {numbers_text(found[index])}; state its gains "
                    "on the actuator itself, as kp and kv"
                )

    def _joint_of(self, index: int) -> str:
        return str(self.model.joint(int(self.model.actuator_trnid[index, 0])).name)

    def _servo(self, element: XmlElement, index: int, joint: JointNumbers, before: JointActuator) -> None:
        """Write the gains of a position servo."""
        assert joint.servo_stiffness is not None
        assert joint.servo_damping is not None
        wanted = {"stiffness": joint.servo_stiffness, "damping": joint.servo_damping}
        own = {"stiffness": before.kp, "damping": before.kv}
        units = {kind: unit_of(kind, joint.rotary) for kind in wanted}
        keys = {"stiffness": "kp", "damping": "kv"}
        squared = before.gear**2
        if not before.follows or element.tag not in ("position", "general"):
            reason = f"the actuator <{element.tag}> of the file does not follow positions"
            self.not_held += [
                NotHeld(joint.motor, f"servo {kind}", f"{value:.6g} {units[kind]}", reason)
                for kind, value in wanted.items()
            ]
            return
        changed = [kind for kind in wanted if not same(wanted[kind], own[kind])]
        if element.tag == "general" and changed:
            stiff, damped = wanted["stiffness"] / squared, wanted["damping"] / squared
            element.set("gainprm", numbers_text([stiff, *self.model.actuator_gainprm[index, 1:3]]))
            element.set("biasprm", numbers_text([self.bias[index, 0], -stiff, -damped]))
        if changed:
            self.gain[index, 0] = wanted["stiffness"] / squared
            self.bias[index, 1:] = -wanted["stiffness"] / squared, -wanted["damping"] / squared
        if "damping" in changed:
            element.remove("dampratio")
        for kind in changed:
            if element.tag == "position":
                element.set(keys[kind], number(wanted[kind] / squared))
            place = f"{element.tag} {keys[kind] if element.tag == 'position' else 'biasprm'}"
            self._note(joint.motor, f"servo {kind}", place, own[kind], wanted[kind], units[kind])
        lag = joint.servo_lag or 0.0
        if not same(lag, before.time_constant) and (lag or changed or not same(joint.delay, before.delay)):
            # a robot file has no lag of the control, so what was found of the servo holds with that of the effects
            key = "timeconst" if element.tag == "position" else "dyntype"
            element.set(key, number(lag) if element.tag == "position" else "filterexact" if lag else "none")
            if lag and element.tag == "general":
                element.set("dynprm", number(lag))
            self._note(joint.motor, "lag of the control", f"{element.tag} {key}", before.time_constant, lag, "s")

    def _gain(self, element: XmlElement, index: int, joint: JointNumbers) -> None:
        """Scale the torque of an actuator; that of a servo by its gains, because its gear also scales the position."""
        gain, model = joint.torque_gain, self.model
        stiff, bias = float(model.actuator_gainprm[index, 0]), model.actuator_biasprm[index]
        if element.tag == "motor":
            gear = model.actuator_gear[index].copy()
            before, place = float(gear[0]), "gear"
            gear[0] *= gain
            self.gear[index] = gear[0]
            element.set("gear", numbers_text(gear if np.any(gear[1:]) else gear[:1]))
        elif element.tag in ("position", "velocity"):
            before, place = stiff, "kp" if element.tag == "position" else "kv"
            element.set(place, number(gain * stiff))
            if element.tag == "position" and bias[2]:
                element.remove("dampratio")
                element.set("kv", number(-gain * float(bias[2])))
        elif element.tag == "general":
            before, place = stiff, "gainprm"
            element.set("gainprm", numbers_text([gain * stiff, *model.actuator_gainprm[index, 1:3]]))
            if np.any(bias):
                element.set("biasprm", numbers_text(gain * bias[:3]))
        else:
            reason = f"the gain of an actuator <{element.tag}> has several numbers; correct it there"
            self.not_held.append(NotHeld(joint.motor, "torque gain", f"x {gain:.6g}", reason))
            return
        if element.tag != "motor":
            self.gain[index, 0] *= gain
            self.bias[index] *= gain
        self._note(joint.motor, "torque gain", f"{element.tag} {place}", before, before * gain, "1")

    def _note(self, location: str, quantity: str, place: str, before: float | None, value: float, unit: str) -> None:
        self.written.append(Written(location, quantity, place, before, value, unit))

    def _actuator_element(self, index: int, joint: str) -> XmlElement:
        name = str(self.model.actuator(index).name)
        parts = [child for child in self.root.children if child.tag == "actuator"]
        for element in (each for part in parts for each in part.children):
            own = element.attributes
            if (name and own.get("name") == name) or (
                not name and joint in (own.get("joint"), own.get("jointinparent"))
            ):
                return element
        raise InputError(
            f"{self.source}: the actuator '{name}' of joint {joint} is not in the file itself; give a file "
            "that holds it"
        )
