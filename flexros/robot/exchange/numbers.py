"""Numbers of a robot as other programs keep them: one record per joint and body, and what a format cannot hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.robot.exchange.body_inertia import BodyInertia

SAME = 1e-9
"""Relative difference up to which a number of a file is left as it is [1] (chosen, far above round-off)."""


@dataclass(frozen=True)
class JointNumbers:
    """Numbers of one motor on the joint side of its gear.

    Attributes:
        motor: Name of the motor, e.g. "motor_1".
        rotary: Rotary (True) or prismatic (False).
        gear_ratio: Turns of the rotor per turn of the joint [1].
        damping: Viscous friction [Nm s/rad or N s/m].
        friction: Level of dry friction [Nm or N].
        armature: Inertia of the rotor times the square of the gear ratio [kg m2 or kg].
        torque_limit: Largest absolute torque [Nm or N], None for no limit.
        torque_gain: Torque of the motor over the commanded one [1].
        delay: Delay of the commands [s].
        stiffness: Stiffness of its gear [Nm/rad or N/m], None for a rigid gear.
        servo_stiffness: Torque per position error of its position loop [Nm/rad or N/m], None without a servo.
        servo_damping: Torque per speed of that loop [Nm s/rad or N s/m], None without a servo.
        servo_lag: Time constant of a filter of its commands [s], 0 for none, None without a servo.
        zero: Measured position where the robot file has its zero [rad or m]: the encoder has another one.
    """

    motor: str
    rotary: bool
    gear_ratio: float
    damping: float
    friction: float
    armature: float
    torque_limit: float | None
    torque_gain: float
    delay: float
    stiffness: float | None
    servo_stiffness: float | None = None
    servo_damping: float | None = None
    servo_lag: float | None = None
    zero: float = 0.0


@dataclass(frozen=True)
class LoadNumbers:
    """A point mass on a body that the nominal robot does not have.

    Attributes:
        mass: Mass [kg].
        place: Its place from the joint of the body, along the axes of the base at zero pose [m].
    """

    mass: float
    place: tuple[float, float, float]

    @property
    def words(self) -> str:
        """The load in words."""
        place = ", ".join(f"{value:.4g}" for value in self.place)
        return f"{self.mass:.6g} kg at {place} m from its joint, along the axes of the base at zero pose"


REWRITTEN = "bodies of a base file keep their numbers; an export without a base file has these"
"""Why the numbers of a body are not in a file that is changed."""


@dataclass(frozen=True)
class BodyNumbers:
    """Numbers of one body that a diagnosis may correct.

    Attributes:
        body: Name of the body, e.g. "body_2".
        label: Its label in the robot file: its name in the file that it was imported from.
        mass_factor: Mass and inertia over those of the robot without effects [1].
        weight_error: Unmodelled share of its weight, without change of inertia [1].
        load: Point mass that moves its centre of mass, None for none; the factor is 1 then.
        rewritten: Mass and centre of mass that no factor and no load alone says, in words; the factors are 1 then.
        beside_load: What of these a load leaves, in words; empty without one.
        nominal: Its numbers in the robot without effects, in its own frame, where `rewritten`; else None.
        viscous_friction: Friction against its absolute rotation [Nm s/rad].
        inertia_factor: Inertia about the centre of mass, beyond that of `mass_factor`, with the mass kept [1].
    """

    body: str
    label: str
    mass_factor: float
    weight_error: float
    load: LoadNumbers | None = None
    rewritten: str = ""
    inertia_factor: float = 1.0
    beside_load: str = ""
    nominal: BodyInertia | None = None
    viscous_friction: float = 0.0

    @property
    def change(self) -> tuple[str, str]:
        """Name and size of what a diagnosis corrects, but for the weight."""
        if self.rewritten:
            return "numbers", self.rewritten
        if self.load is not None:
            return "load", self.load.words
        if not same(self.inertia_factor, 1.0):
            mass = "" if same(self.mass_factor, 1.0) else f", mass x {self.mass_factor:.6g}"
            return "inertia", f"x {self.mass_factor * self.inertia_factor:.6g}{mass}"
        return "payload", f"mass x {self.mass_factor:.6g}"

    def friction_not_held(self) -> list[NotHeld]:
        """List its friction against its absolute rotation, for formats that have friction of joints alone."""
        size = f"{self.viscous_friction:.6g} Nm s/rad"
        reason = "friction against the absolute rotation of a body has no place beside that of joints"
        return [NotHeld(self.body, "viscous friction", size, reason)] if self.viscous_friction else []


@dataclass(frozen=True)
class NotHeld:
    """A number that a format has no place for.

    Attributes:
        location: Motor, spring or body.
        name: The effect or quantity.
        size: Its values with units, for the reader.
        reason: Why it is not held, or where it belongs instead.
    """

    location: str
    name: str
    size: str
    reason: str


@dataclass(frozen=True)
class Written:
    """A number in a file of another program.

    Attributes:
        location: Motor, spring or body.
        quantity: The quantity, e.g. "viscous friction".
        place: Element and attribute of the file that hold it.
        before: Value before, in the unit; None where there was none.
        value: Value written, in the unit.
        unit: SI unit.
    """

    location: str
    quantity: str
    place: str
    before: float | None
    value: float
    unit: str


@dataclass(frozen=True)
class RepairedNumbers:
    """Numbers of a robot with its effects.

    Attributes:
        joints: Per motor, in order.
        bodies: Per body, in order.
        not_held: Effects that none of these numbers holds, or holds in part.
        gravity: Gravity in the frame of the base [m/s2], shape (3,), where that stands at a slant; None as in the robot
            file.
    """

    joints: tuple[JointNumbers, ...]
    bodies: tuple[BodyNumbers, ...]
    not_held: tuple[NotHeld, ...]
    gravity: tuple[float, float, float] | None = None


@dataclass(frozen=True)
class Export:
    """A robot in the format of another program.

    Attributes:
        text: Content of the file.
        written: Its numbers.
        not_held: What the format has no place for.
    """

    text: str
    written: tuple[Written, ...]
    not_held: tuple[NotHeld, ...]


def same(value: float, other: float) -> bool:
    """Return whether two numbers are equal up to `SAME`."""
    return abs(value - other) <= SAME * max(abs(value), abs(other))
