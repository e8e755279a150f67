"""Numbers of joints and bodies of a robot with effects, on the joint side of the gears, for other programs."""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects.actuator_lag import ActuatorLag
from flexros.effects.delay import Delay
from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.effects.friction.coulomb_friction import CoulombFriction
from flexros.effects.friction.presliding_friction import PreslidingFriction
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.gravity_error import GravityError
from flexros.effects.inertia_error import InertiaError
from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.tool_load import ToolLoad, last_moved
from flexros.effects.servos.servo_command_lag import ServoCommandLag
from flexros.effects.torque_gain_error import TorqueGainError
from flexros.effects.torque_saturation import TorqueSaturation
from flexros.errors import InputError
from flexros.robot.exchange.body_inertia import ENTRIES, BodyInertia
from flexros.robot.exchange.numbers import SAME, BodyNumbers, JointNumbers, LoadNumbers, NotHeld, RepairedNumbers
from flexros.robot.parameters import INERTIA_COMPONENTS
from flexros.robot.quantity import unit_of
from flexros.robot.spring import Spring

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects.kinds.law import AbstractLaw
    from flexros.effects.patching.patched_robot import PatchedRobot
    from flexros.robot import Robot
    from flexros.robot.motors import RobotMotor
    from flexros.robot.specification import Body

ASYMMETRIC = "the two directions have one level; the mean is written"
DIFFERENCES = {
    "mass": ("mass", "kg"),
    **{axis: (f"centre {axis}", "m") for axis in "xyz"},
    **{entry: (f"inertia {entry}", "kg m2") for entry in INERTIA_COMPONENTS},
}
"""Names and units of the numbers of a `BodyDifference`."""

NO_LAW = "no joint parameter represents it: add it as a force, or keep it in FlexROS"


def repaired_numbers(patched: PatchedRobot, *, turned: Collection[str] = ()) -> RepairedNumbers:
    """Return the numbers of joints and bodies of a robot with its effects.

    Values stated on the motor side of a gear with ratio n (key `coordinates`) are converted: torques times n, friction
    coefficients, stiffness and inertia times n^2.

    Args:
        patched: Robot with effects, as loaded.
        turned: Motors and arm coordinates that count the other way round than the joints of the file for which the
            numbers are: zeros of encoders and effects that are not held are stated as those count.

    Raises:
        InputError: The file states values on the motor side, which cannot be converted.
    """
    model = patched.model
    differences: dict[str, list[BodyDifference]] = {}
    for one in patched.placed:
        if isinstance(one.effect, BodyDifference):
            differences.setdefault(one.location, []).append(one.effect)
    loads = [one.effect for one in patched.placed if isinstance(one.effect, ToolLoad) and one.effect.mass > 0]
    carrier = last_moved(model.robot) if len(loads) == 1 else ""
    inertias: dict[str, float] = {}
    for one in patched.placed:
        if isinstance(one.effect, InertiaError):
            inertias[one.location] = inertias.get(one.location, 1.0) * (1 + one.effect.relative)
    scale = joint_side(model.robot)
    joints = [_Joint(model.robot, motor, scale) for motor in model.robot.motors]
    weights: dict[str, float] = {}
    not_held = _of_robot(model.robot, scale)
    sliding = {motor.name for motor in model.robot.motors if not motor.rotary}
    sliding |= {joint.name for joint in model.robot.joints if not joint.rotary}
    for law in model.laws:
        if law.effect.neutral:
            continue
        if isinstance(law.effect, GravityError):
            weights[law.location] = weights.get(law.location, 0.0) + law.effect.relative
            held = law.effect.moment == 0
            reason = "the weight is written, the mass moment is not: move the centre of mass"
        else:
            held, reason = False, NO_LAW
            for joint in (each for each in joints if law.location == each.motor.name):
                held, reason = joint.take(law.effect)
        if not held:
            effect = law.effect.turned_round() if law.location in turned else law.effect
            size = _size(effect, law.location not in sliding)
            not_held.append(NotHeld(law.location, law.name.partition("@")[0], size, reason))
    return RepairedNumbers(
        tuple(joint.numbers(turned=joint.motor.name in turned) for joint in joints),
        tuple(
            replace(
                _of_body(
                    name := f"body_{k}",
                    body,
                    nominal,
                    weights.get(name, 0.0),
                    inertias.get(name, 1.0),
                    differences=differences.get(name, ()),
                    load=loads[0] if name == carrier else None,
                ),
                viscous_friction=body.viscous_friction.value / scale**2,
            )
            for k, (body, nominal) in enumerate(zip(model.robot.spec.bodies, patched.base.spec.bodies), start=1)
        ),
        tuple(not_held),
        gravity=None if (gravity := model.robot.spec.gravity.value) == patched.base.spec.gravity.value else gravity,
    )


def _of_body(
    name: str,
    body: Body,
    nominal: Body,
    weight_error: float,
    inertia_factor: float,
    *,
    differences: Sequence[BodyDifference],
    load: ToolLoad | None,
) -> BodyNumbers:
    """Return the numbers of a body; a further mass that moves its centre of mass is a load on it.

    Args:
        name: Its name.
        body: The body with all effects.
        nominal: The body of the robot file.
        weight_error: Unmodelled share of its weight [1].
        inertia_factor: Inertia over that without inertia errors [1].
        differences: Its numbers that an effect says.
        load: Load of the patch on it; None for none.
    """
    mass, own = body.mass.value, nominal.mass.value
    moment = mass * np.array(body.center_of_mass.value) - own * np.array(nominal.center_of_mass.value)
    moved = np.abs(moment - (mass - own) * np.array(nominal.center_of_mass.value)).max() > SAME * abs(mass)
    if differences or (moved and (mass <= own or inertia_factor != 1)):
        place = ", ".join(f"{value:.4g}" for value in body.center_of_mass.value)
        inertia = BodyInertia.of(body).inertia
        entries = ", ".join(f"{entry} {inertia[at]:.6g}" for entry, at in ENTRIES.items() if inertia[at])
        words = f"mass {mass:.6g} kg, centre {place} m, inertia {entries} kg m2"
        point = None if load is None else LoadNumbers(load.mass, (load.x, load.y, load.z))
        beside = _beside_load(differences, inertia_factor) if load is not None else ""
        before = BodyInertia.of(nominal)
        return BodyNumbers(name, body.label, 1.0, weight_error, point, words, beside_load=beside, nominal=before)
    if moved:
        x, y, z = (moment / (mass - own)).tolist()
        return BodyNumbers(name, body.label, 1.0, weight_error, LoadNumbers(mass - own, (x, y, z)))
    inertia = body.inertia.matrix() / inertia_factor
    factor = _ratio(mass, own, inertia, nominal.inertia.matrix())
    return BodyNumbers(name, body.label, factor, weight_error, inertia_factor=inertia_factor)


def _beside_load(differences: Sequence[BodyDifference], inertia_factor: float) -> str:
    """Return what changes a body beside its load, in words."""
    found = [] if inertia_factor == 1 else [f"inertia x {inertia_factor:.6g}"]
    for one in differences:
        for key, value in ((key, value) for key, value in one.model_dump().items() if value):
            name, unit = DIFFERENCES[key]
            found.append(f"{name} {value:+.6g} {unit}")
    return ", ".join(found)


def joint_side(robot: Robot) -> float:
    """Return the factor from coordinates of the robot file to those of its joints: 1, or the inverse gear ratio.

    Raises:
        InputError: The file states values on the motor side of several gears, or with masses and gravity.
    """
    if robot.spec.coordinates == "arm":
        return 1.0
    ratios = {motor.gear_ratio for motor in robot.motors}
    masses = any(body.mass.value for body in robot.spec.bodies)
    if len(ratios) > 1 or masses or not all(joint.rotary for joint in robot.joints):
        raise InputError(
            f"robot {robot.name} states values on the motor side of its gears (key coordinates: motor) with "
            f"{'masses' if masses else 'several gear ratios or translations'}, which cannot be converted to joints; "
            "state them on the arm side"
        )
    return 1 / ratios.pop()


@dataclass
class _Joint:
    """Numbers of a motor in the coordinates of the robot file, to which laws are added."""

    robot: Robot
    motor: RobotMotor
    scale: float
    damping: float = field(init=False)
    friction: float = 0.0
    gain: float = 1.0
    limit: float = field(init=False)
    delay: float = field(init=False)
    lag: float = 0.0
    zero: float = 0.0

    def __post_init__(self) -> None:
        self.damping = self.motor.specification.viscous_friction.value
        self.limit = self.motor.torque_limit
        self.delay = self.robot.delay

    def take(self, effect: AbstractLaw) -> tuple[bool, str]:
        """Take up a law; return whether it is held as a whole, and else the reason."""
        takers: dict[type[AbstractLaw], Callable[..., tuple[bool, str]]] = {
            ViscousFriction: self._viscous,
            CoulombFriction: self._coulomb,
            PreslidingFriction: self._presliding,
            TorqueGainError: self._gain,
            TorqueSaturation: self._saturation,
            Delay: self._delay,
            ServoCommandLag: self._filter,
            EncoderOffset: self._zero,
        }
        if type(effect) in takers:
            return takers[type(effect)](effect)
        if isinstance(effect, ActuatorLag):
            return False, "a first-order lag: in MuJoCo an actuator `general` with dyntype filter and dynprm"
        return False, NO_LAW

    def numbers(self, *, turned: bool) -> JointNumbers:
        """Return the numbers on the joint side, for a joint that counts as the motor or the other way round."""
        squared = self.scale**2
        spring = self.motor.joint.direction.spring
        stiffness = spring.at_zero / squared if isinstance(spring, Spring) else None
        servo = self.motor.specification.servo
        return JointNumbers(
            motor=self.motor.name,
            rotary=self.motor.rotary,
            gear_ratio=self.motor.gear_ratio,
            damping=self.damping / squared,
            friction=self.friction / self.scale,
            armature=self.motor.inertia / squared,
            # the torque constant is part of the gains of a servo, and of the torque at which it is limited
            torque_limit=None
            if np.isinf(self.limit)
            else self.limit / self.scale * (1.0 if servo is None else self.gain),
            torque_gain=self.gain if servo is None else 1.0,
            delay=self.delay,
            stiffness=stiffness,
            servo_stiffness=None if servo is None else self.gain * servo.stiffness.value / squared,
            servo_damping=None if servo is None else self.gain * servo.damping.value / squared,
            servo_lag=None if servo is None else self.lag,
            zero=(-self.zero if turned else self.zero) * self.scale,
        )

    def _viscous(self, effect: ViscousFriction) -> tuple[bool, str]:
        self.damping += effect.coefficient
        return effect.asymmetry == 0, ASYMMETRIC

    def _coulomb(self, effect: CoulombFriction) -> tuple[bool, str]:
        self.friction += effect.level
        return effect.asymmetry == 0, ASYMMETRIC

    def _presliding(self, effect: PreslidingFriction) -> tuple[bool, str]:
        self.friction += effect.level
        return False, "its level is written as dry friction; bristle and hump are not"

    def _gain(self, effect: TorqueGainError) -> tuple[bool, str]:
        self.gain *= 1 + effect.relative
        return True, ""

    def _saturation(self, effect: TorqueSaturation) -> tuple[bool, str]:
        self.limit = min(self.limit, effect.limit)
        return True, ""

    def _filter(self, effect: ServoCommandLag) -> tuple[bool, str]:
        held, self.lag = self.lag == 0, self.lag + effect.time_constant
        return held, "two filters in series are written as one"

    def _zero(self, effect: EncoderOffset) -> tuple[bool, str]:
        self.zero += effect.offset
        return True, ""

    def _delay(self, effect: Delay) -> tuple[bool, str]:
        self.delay += effect.time
        return True, ""


def _of_robot(robot: Robot, scale: float) -> list[NotHeld]:
    """List what the robot file itself has beyond numbers of joints and bodies."""
    found = []
    for joint in robot.joints:
        spring = joint.direction.spring
        if isinstance(spring, Spring) and spring.stiffness is None:
            law = spring.piecewise_linear or spring.cubic
            assert law is not None
            size = ", ".join(f"{name} {value}" for name, value in law.model_dump(exclude_defaults=True).items())
            written = spring.at_zero / scale**2
            reason = f"its stiffness at zero deflection is written, on the joint side {written:.6g}"
            found.append(NotHeld(joint.name, "nonlinear spring", size, reason))
        zero = joint.direction.zero
        if zero is not None and zero.value:
            size = f"{zero.value:.6g} {unit_of('position', joint.rotary)}"
            reason = "the geometry is written without it: add it to the positions, or turn the origin of the joint"
            found.append(NotHeld(joint.name, "zero", size, reason))
    for motor in robot.motors:
        servo = motor.specification.servo
        if servo is not None and servo.feedforward.value:
            reason = "servos of other programs follow a speed of their own; command it there"
            found.append(NotHeld(motor.name, "servo feedforward", f"{servo.feedforward.value:.6g}", reason))
        if servo is not None and servo.integral.value:
            size = f"{servo.integral.value / scale**2:.6g} {unit_of('integral', motor.rotary)}"
            reason = "servos of other programs have no integral part; add it in the controller"
            found.append(NotHeld(motor.name, "servo integral", size, reason))
    for index, body in enumerate(robot.spec.bodies):
        for axis, bending in body.bending.items():
            size = f"{len(bending.listed())} modes, {bending.rigidity.value:.6g} N m2"
            found.append(NotHeld(f"body_{index + 1}", f"bending about {axis}", size, "the link is written as straight"))
    if robot.spec.inertial_coupling:
        found.append(
            NotHeld("all", "inertial_coupling", "rotors turn with the links", "an armature acts on its joint alone")
        )
    return found


def _size(effect: AbstractLaw, rotary: bool) -> str:
    """Write the parameters of a law that differ from their defaults, with the units of their descriptions."""
    fields = type(effect).model_fields
    words = []
    for name, value in effect.model_dump().items():
        if value == fields[name].default:
            continue
        stated = re.findall(r"\[([^\]]+)\]", fields[name].description or "")
        unit = stated[0].split(" or ")[0 if rotary else -1] if stated else ""
        number = f"{value:.6g}" if isinstance(value, float) else str(value)
        words.append(f"{name} {number} {'' if unit in ('1', '-') else unit}".strip())
    return ", ".join(words)


def _ratio(mass: float, nominal_mass: float, inertia: FloatArray, nominal: FloatArray) -> float:
    if nominal_mass > 0:
        return mass / nominal_mass
    total = float(np.trace(nominal))
    return float(np.trace(inertia)) / total if total > 0 else 1.0
