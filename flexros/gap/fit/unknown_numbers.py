"""Numbers that a robot file leaves out, estimated from the log, since unknown is not wrong: rotors and the load."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ToolLoad, body_numbers, last_moved
from flexros.errors import InputError
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.balanced_torques import regress_balanced
from flexros.gap.fit.torque_delay import torque_delay
from flexros.gap.fit.torque_regression import Load, only_coulomb, regress_torque
from flexros.gap.settings import TorqueStartSettings
from flexros.prediction.integration_step import least_inertia, stops_too_fast, substeps
from flexros.robot.parameters import INERTIA_COMPONENTS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.least_squares import CandidateFit
    from flexros.gap.fit.torque_regression import TorqueRegression
    from flexros.record.record import Record
    from flexros.robot import Robot

    Regress = Callable[..., TorqueRegression | None]

STEPS = 16
"""Steps per sample that the friction of motors without rotors may need [1] (chosen). Some URDFs have the same large
damping at every joint, which only keeps a simulator calm; a light wrist without rotor would stop within 0.1 ms."""
PLACEHOLDER = 0.5
"""Share of such a friction that the torques of the log have at most, if it stands for none [1] (chosen)."""
UNCERTAIN = 0.5
"""Standard deviation of the logarithm of an estimated inertia: the prediction errors decide (chosen)."""
UNCERTAIN_LOAD = 0.1
"""The same for mass and centre of the body with an estimated load (chosen): the weight shows them well."""
_CENTER = ("x", "y", "z")


@dataclass(frozen=True)
class UnknownNumbers:
    """Numbers that the nominal model lacks, estimated from a log.

    Attributes:
        inertias: Inertia by motor, of those whose robot file gives none [kg m2 or kg].
        load: Load that the file leaves out; None for none.
        bare: Mass of the body that carries it, as in the file [kg].
        placeholders: Viscous friction in the file by motor, where it stands for none [Nm s/rad or N s/m].
        rough: Tolerance of masses, centres of mass and inertias of the bodies where they are off by more than that of
            the file allows for [1]; zero where they are not.
    """

    inertias: Mapping[str, float] = field(default_factory=dict)
    load: ToolLoad | None = None
    bare: float = 0.0
    placeholders: Mapping[str, float] = field(default_factory=dict)
    rough: float = 0.0

    @property
    def warnings(self) -> tuple[str, ...]:
        """What of the robot file was not used."""
        found = []
        if self.rough:
            found.append(
                "masses, centres of mass and inertias of the robot file are off by more than their tolerance: "
                f"{100 * self.rough:g} % are allowed for instead, so the gap is that of a model with better ones; a "
                "patch holds them (body_difference)"
            )
        return (*found, *self._placeholder_warnings)

    @property
    def _placeholder_warnings(self) -> tuple[str, ...]:
        if not self.placeholders:
            return ()
        names = ", ".join(f"{name} ({value:g})" for name, value in self.placeholders.items())
        return (
            f"the viscous friction of the robot file at {names} is that of a simulator: it would stop joints without "
            "rotors at once, and the torques do not show it; zero is used, so the gap is that of a model without it",
        )

    def lacked_by(self, model: RobotWithEffects) -> UnknownNumbers:
        """Return those of the numbers that a model lacks."""
        parameters = model.robot.parameters
        lacked = {k: v for k, v in self.inertias.items() if parameters[f"{k}.inertia"].value == 0}
        bare = self.load is not None and parameters[f"{last_moved(model.robot)}.mass"].value == self.bare
        repaired = {law.location for law in model.laws if isinstance(law.effect, ViscousFriction)}
        placeholders = {name: value for name, value in self.placeholders.items() if name not in repaired}
        return UnknownNumbers(lacked, self.load if bare else None, self.bare, placeholders)

    def given_to(self, model: RobotWithEffects) -> RobotWithEffects:
        """Return a model that lacks these numbers with them."""
        values = {f"{name}.inertia": value for name, value in self.inertias.items()}
        values |= {f"{name}.viscous_friction": 0.0 for name in self.placeholders}
        if self.load is not None:
            values |= self.load.values(model.robot, "tool")
        return replace(model, robot=model.robot.with_values(values)) if values else model

    def names(self, robot: Robot) -> frozenset[str]:
        """Return the names of the parameters that these numbers are or change.

        Args:
            robot: The robot.
        """
        own = {f"{name}.inertia" for name in self.inertias}
        bodies = {name for name in robot.parameters if self.rough and is_inertial(name)}
        return frozenset(own | set(self._of_load(robot)) | bodies)

    def tolerated(self, tolerance: Tolerance, robot: Robot) -> Tolerance:
        """Return a tolerance in which these numbers are uncertain.

        Args:
            tolerance: Tolerance of the model with these numbers.
            robot: The robot.
        """
        uncertain = dict.fromkeys((f"{name}.inertia" for name in self.inertias), UNCERTAIN)
        uncertain |= dict.fromkeys(self._of_load(robot), UNCERTAIN_LOAD)
        bodies = with_rough_bodies(tolerance, self.rough)
        pairs = zip(bodies.names, bodies.deviations, strict=True)
        return replace(bodies, deviations=tuple(uncertain.get(name, deviation) for name, deviation in pairs))

    def fitted(self, fit: CandidateFit) -> tuple[PlacedEffect, ...]:
        """Return the numbers of a fit as effects on the model that lacks them."""
        robot, tolerance = fit.predictor.robot, fit.predictor.tolerance
        factors = dict(zip(tolerance.names, np.exp(tolerance.logarithms(fit.deviations)), strict=True))
        rotors = tuple(
            PlacedEffect(RotorInertia(added=float(factors[name] * robot.parameters[name].value)), motor)
            for motor in self.inertias
            if (name := f"{motor}.inertia") in factors
        )
        friction = tuple(
            PlacedEffect(ViscousFriction(coefficient=-value), motor) for motor, value in self.placeholders.items()
        )
        load = () if self.load is None else (PlacedEffect(self._fitted_load(robot, factors), "tool"),)
        return (*rotors, *friction, *load, *(fitted_bodies(robot, factors) if self.rough else ()))

    def _of_load(self, robot: Robot) -> list[str]:
        if self.load is None:
            return []
        body = last_moved(robot)
        return [f"{body}.mass", *(f"{body}.center_of_mass.{axis}" for axis in _CENTER)]

    def _fitted_load(self, robot: Robot, factors: Mapping[str, float]) -> ToolLoad:
        """Return the load of a robot that has one, with mass and centre of its body scaled by factors."""
        assert self.load is not None
        mass, center, _ = body_numbers(robot, last_moved(robot))
        scaled, *places = (factors.get(name, 1.0) for name in self._of_load(robot))
        place = np.array([self.load.x, self.load.y, self.load.z])
        own = mass * center - self.load.mass * place  # first moment of the body alone
        carried = scaled * mass - self.bare
        if carried <= 0:
            return ToolLoad()
        x, y, z = ((scaled * mass * center * np.array(places) - own) / carried).tolist()
        return ToolLoad(mass=float(carried), x=x, y=y, z=z)


def is_inertial(name: str) -> bool:
    """Return whether a parameter is the mass, a part of the centre of mass or of the inertia of a body.

    Args:
        name: Name of the parameter, e.g. "body_2.center_of_mass.x".
    """
    body, _, number = name.partition(".")
    return body.startswith("body_") and number.partition(".")[0] in ("mass", "center_of_mass", "inertia")


def fitted_bodies(robot: Robot, factors: Mapping[str, float]) -> list[PlacedEffect]:
    """Return the differences of the bodies of a robot whose numbers are scaled by factors.

    Factors of the entries of an inertia are fitted one by one. Where no body can have such an inertia, it is that of
    the file times the factor of the mass.

    Args:
        robot: The robot.
        factors: Factors by name of the parameter [1].
    """
    found = []
    for number in range(1, len(robot.spec.bodies) + 1):
        body = f"body_{number}"
        changes = {
            name.rpartition(".")[2]: (factor - 1.0) * robot.parameters[name].value
            for name, factor in factors.items()
            if name.startswith(f"{body}.") and is_inertial(name)
        }
        difference = BodyDifference(**changes)
        try:
            difference.changed(robot, body)
        except InputError:
            heavier = factors.get(f"{body}.mass", 1.0) - 1.0
            scaled = {name: heavier * robot.parameters[f"{body}.inertia.{name}"].value for name in INERTIA_COMPONENTS}
            difference = difference.model_copy(update=scaled)
        if difference.values(robot, body):
            found.append(PlacedEffect(difference, body))
    return found


def with_rough_bodies(tolerance: Tolerance, rough: float) -> Tolerance:
    """Return a tolerance in which the inertial numbers of bodies deviate by at least some share.

    Args:
        tolerance: The tolerance.
        rough: The share [1].
    """
    pairs = zip(tolerance.names, tolerance.deviations, strict=True)
    return replace(tolerance, deviations=tuple(max(deviation, rough * is_inertial(name)) for name, deviation in pairs))


def unknown_numbers(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    settings: TorqueStartSettings | None = None,
    *,
    as_stated: bool = False,
) -> UnknownNumbers:
    """Estimate the rotor inertias that a model lacks and a load, from a log that this program has not simulated.

    Args:
        record: The log.
        model: The nominal model.
        tolerance: Parameters of the robot that may deviate.
        settings: Settings of the regressions.
        as_stated: Whether bodies deviate within this tolerance, and carry no load that is not clear by far, whatever
            the torques show, so that gaps of different logs can be compared.
    """
    settings = settings or TorqueStartSettings()
    robot = model.robot
    lacking = [name for name in robot.joint_names if robot.parameters[f"{name}.inertia"].value == 0]
    if record.simulated or record.command is not None or not only_coulomb(model) or not (lacking or _may_carry(robot)):
        return UnknownNumbers()
    state = robot.equilibrium(motor_position=np.median(record.position, axis=0))
    masses = robot.model.mass_matrix(state[: robot.n_coordinates], robot.model.parameter_values)
    of_bodies = dict(zip(robot.joint_names, np.diag(np.asarray(masses, dtype=float))[list(robot.motor_rows)]))
    bodies = {name: of_bodies[name] for name in lacking}
    needed = _inertias_to_step(robot, record.sample_time, bodies, settings.least_stepped_rotor)
    viscous = {name: robot.parameters[f"{name}.viscous_friction"].value for name in robot.joint_names}
    delay = torque_delay(record, model, tolerance, settings)
    regress = partial(regress_torque, record, model, delay=delay, settings=settings)
    regression = regress_balanced(record, model, tolerance, delay=delay, settings=settings)
    if regression is None:
        return UnknownNumbers(needed)
    wide = with_rough_bodies(tolerance, settings.rough_bodies)
    of_rough = None
    if wide != tolerance and not as_stated and not robot.flexible_motors:  # what springs leave is no error of bodies
        of_rough = regress_balanced(record, model, wide, delay=delay, settings=settings)
    if of_rough is not None and not _bodies_are_off(of_rough, regression, regress, record, settings):
        of_rough = None
    beside = partial(regress, balanced=next(iter(regression.balance), None))
    loaded, load = _load(regress, robot, tolerance, len(lacking), settings)
    if loaded is None and of_rough is None and _may_carry(robot) and not (as_stated or robot.flexible_motors):
        loaded, load = _load_before_bodies(beside, robot, tolerance, len(lacking), settings) or (None, None)
    if loaded is not None and of_rough is not None:  # what explains more stands for both
        loaded, load, of_rough = (loaded, load, None) if _rest(loaded) < _rest(of_rough) else (None, None, of_rough)
    rough = 0.0 if of_rough is None else settings.rough_bodies
    regression = loaded or of_rough or regression
    found = dict(zip(robot.joint_names, regression.inertia.tolist(), strict=True))
    least = _least_rotors(robot, of_bodies, regression, settings)
    rotors = {name: found[name] for name in lacking if found[name] > least[name]}
    changes = dict(zip(robot.joint_names, regression.viscous_friction.tolist(), strict=True))
    left = {name: viscous[name] + changes[name] for name in lacking} if needed else {}
    placeholders = {name: viscous[name] for name, value in left.items() if value < PLACEHOLDER * viscous[name]}
    needed = {name: value for name, value in needed.items() if name not in placeholders}
    friction = {name: viscous[name] + changes[name] for name in lacking}
    carried = {name: of_bodies[name] + rotors.get(name, 0.0) for name in lacking}
    needed |= _inertias_for_friction(robot, record.sample_time, friction, carried)
    inertias = {name: max(needed.get(name, 0.0), rotors.get(name, 0.0)) for name in (needed | rotors)}
    bare = robot.parameters[f"{last_moved(robot)}.mass"].value if load else 0.0
    return UnknownNumbers(inertias, load, bare, placeholders, rough)


def _bodies_are_off(
    wide: TorqueRegression,
    within: TorqueRegression,
    regress: Regress,
    record: Record,
    settings: TorqueStartSettings,
) -> bool:
    """Return whether errors of the bodies far beyond their tolerance explain torques that nothing else does.

    Held within it, friction, offsets, rotors or a load would stand for them. A last body that alone is wrong is a
    payload error. That a motor has no torque, as where it is not driven, is explained by bodies without weight.

    Args:
        wide: The regression with bodies that are known roughly.
        within: The same with bodies within their tolerance.
        regress: The regression of the log, of a tolerance and a load.
        record: The log.
        settings: Settings of the regressions.
    """
    error = within.rest / np.maximum(within.left, 1e-300)
    torque = np.sqrt(np.nanmean(record.torque**2, axis=0))
    driven = torque > settings.least_share * error
    found = replace(wide, left=np.where(driven, wide.left, within.left))
    if not _explains(found, within, settings):
        return False
    payload = regress(Tolerance(), load="body")
    return payload is None or _explains(found, payload, settings)


def _least_rotors(
    robot: Robot, of_bodies: Mapping[str, float], regression: TorqueRegression, settings: TorqueStartSettings
) -> dict[str, float]:
    """Return the inertias from which motors have rotors that a robot file lacks, by name [kg m2 or kg].

    What is large beside the bodies is no error of these. Less may be one, so that it must be clear beside all errors
    that the tolerance of the bodies allows for; else it would go into bodies, friction and counterbalance.

    Args:
        robot: The nominal robot.
        of_bodies: Inertia of the bodies that each motor moves, by name [kg m2 or kg].
        regression: The regression that shows the rotors.
        settings: Settings of the regressions.
    """
    clear = dict(zip(robot.joint_names, settings.clear_rotor * regression.inertia_deviation, strict=True))
    return {
        name: min(settings.least_rotor * bodies, max(clear[name], settings.least_clear_rotor * bodies))
        for name, bodies in of_bodies.items()
    }


def _inertias_to_step(
    robot: Robot, sample_time: float, of_bodies: Mapping[str, float], shows: float
) -> dict[str, float]:
    """Return the least inertias of motors without rotor with which their friction can be stepped.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        of_bodies: Inertia of the bodies that each of these motors moves, by name [kg m2 or kg].
        shows: Inertia over that of the bodies from which it is given [1].
    """
    if not stops_too_fast(robot, sample_time, STEPS):
        return {}
    friction = {name: robot.parameters[f"{name}.viscous_friction"].value for name in of_bodies}
    least = {name: least_inertia(value, sample_time, STEPS) for name, value in friction.items()}
    return {name: value for name, value in least.items() if value > shows * of_bodies[name]}


def _inertias_for_friction(
    robot: Robot, sample_time: float, friction: Mapping[str, float], carried: Mapping[str, float]
) -> dict[str, float]:
    """Return the least inertias of motors without rotor with which the friction that their torques show can be stepped.

    Without it a light wrist with the friction of its gear would diverge in the steps of the nominal robot, and with it
    all that the torques of the other motors show.

    Args:
        robot: The robot.
        sample_time: Time between two samples [s].
        friction: Viscous friction by motor [Nm s/rad or N s/m].
        carried: Inertia by motor that is known [kg m2 or kg].
    """
    steps = substeps(robot, sample_time)
    least = {name: least_inertia(value, sample_time, steps) for name, value in friction.items()}
    return {name: value for name, value in least.items() if value > carried[name]}


def _may_carry(robot: Robot) -> bool:
    """Return whether a load would show in the torques of several motors."""
    return robot.n_motors > 1 and bool(last_moved(robot))


def _load(
    regress: Regress, robot: Robot, tolerance: Tolerance, lacking: int, settings: TorqueStartSettings
) -> tuple[TorqueRegression | None, ToolLoad | None]:
    """Estimate the load that an arm lacks, and its regression; None for none.

    The weight of many heavy arms is carried by a spring or a gas cylinder at one motor, of which the file says nothing
    either. In the torque of that motor it hides the load, which the others show. It must show without a load: beside
    one it could just take up the weight of a load that is none.
    """
    if not _may_carry(robot):
        return None, None
    kind = _kind(robot, lacking)
    without = regress(Tolerance(), load=kind)
    if without is None:
        return None, None
    found = [_load_beside(regress, robot, tolerance, without, None, settings)]
    for motor, one in enumerate(robot.motors):
        if found[0] is not None or not one.rotary:
            continue
        relieved = regress(Tolerance(), load=kind, balanced=motor)
        if relieved is not None and without.rest[motor] > settings.relieved * relieved.rest[motor]:
            found.append(_load_beside(regress, robot, tolerance, relieved, motor, settings))
    best = min((one for one in found if one is not None), key=lambda one: _rest(one[0]), default=None)
    return (None, None) if best is None else best


def _kind(robot: Robot, lacking: int) -> Load:
    """Return what stands for a load that is none: where the file states rotors, a share of the last body."""
    return "none" if lacking == robot.n_motors else "body"


def _load_before_bodies(
    regress: Regress, robot: Robot, tolerance: Tolerance, lacking: int, settings: TorqueStartSettings
) -> tuple[TorqueRegression, ToolLoad] | None:
    """Estimate a load that explains more than errors of all bodies, though not by far; None for no load.

    In a slow motion friction and rotors stand for most of its weight: acceleration and weight of a joint that goes to
    and fro are much alike. A load is four numbers. Where it leaves less than errors of all numbers of the bodies, those
    far beyond their tolerance included, it is not these.

    Args:
        regress: The regression of the log, of a tolerance and a load, beside a counterbalance where there is one.
        robot: The nominal robot.
        tolerance: Parameters of the robot that may deviate.
        lacking: Number of motors whose rotor the robot file leaves out.
        settings: Settings of the regressions.
    """
    loaded = regress(Tolerance(), load="point")
    if loaded is None or not tolerance.names:
        return None
    load = _at_a_point(loaded, settings)
    if load is None or load.mass < settings.light_load * _moved(robot):
        return None
    without = regress(Tolerance(), load=_kind(robot, lacking))
    if without is None or _lowered(without, loaded, settings) < settings.before_bodies:
        return None
    for bodies, least in (
        (tolerance, settings.before_bodies),
        (with_rough_bodies(tolerance, settings.rough_bodies), 1.0),
    ):
        within = regress(bodies)
        if within is None or _lowered(within, loaded, settings) < least:
            return None
    return loaded, load


def _load_beside(
    regress: Regress,
    robot: Robot,
    tolerance: Tolerance,
    without: TorqueRegression,
    balanced: int | None,
    settings: TorqueStartSettings,
) -> tuple[TorqueRegression, ToolLoad] | None:
    """Estimate the load beside a counterbalance of one motor; None for no load.

    Where the file states rotors, it may state a load too: then it must be clearly elsewhere than the last body, whose
    mass alone is that of a payload error. Errors of the bodies within their tolerance must not explain a light one.

    Args:
        regress: The regression of the log, of a tolerance and a load.
        robot: The nominal robot.
        tolerance: Parameters of the robot that may deviate.
        without: The regression without a load.
        balanced: Index of the motor with the counterbalance; None for none.
        settings: Settings of the regressions.
    """
    loaded = regress(tolerance, load="point", balanced=balanced)
    if loaded is None:
        return None
    load, moved = _at_a_point(loaded, settings), _moved(robot)
    if load is None or load.mass < settings.lightest_load * moved or not _explains(loaded, without, settings):
        return None
    if load.mass < settings.light_load * moved:
        tolerated = regress(tolerance, balanced=balanced)
        if tolerated is None or not _explains(loaded, tolerated, settings):
            return None
    return loaded, load


def _at_a_point(loaded: TorqueRegression, settings: TorqueStartSettings) -> ToolLoad | None:
    """Return the load of a regression; None for one without mass, or farther from the last joint than any tool."""
    mass, moment = float(loaded.load[0]), loaded.load[1:]
    if mass <= 0 or np.linalg.norm(moment) > settings.farthest_load * mass:
        return None
    x, y, z = (moment / mass).tolist()
    return ToolLoad(mass=mass, x=x, y=y, z=z)


def _moved(robot: Robot) -> float:
    """Return the mass of all bodies that move [kg]."""
    return sum(robot.parameters[f"body_{k}.mass"].value for k, b in enumerate(robot.spec.bodies, 1) if b.directions)


def _explains(loaded: TorqueRegression, without: TorqueRegression, settings: TorqueStartSettings) -> bool:
    """Return whether a load lowers what is left of the torques by enough, no motor counting for more than that."""
    return _lowered(without, loaded, settings) >= settings.explained_by_load


def _lowered(before: TorqueRegression, after: TorqueRegression, settings: TorqueStartSettings) -> float:
    """Return the factor by which less is left of the torques, over all motors; none counts for more than is enough."""
    factors = np.minimum(before.left / np.maximum(after.left, 1e-300), settings.explained_by_load)
    return float(np.prod(factors))


def _rest(regression: TorqueRegression) -> float:
    """Return the sum of the logarithms of what is left at the motors [1]."""
    return float(np.log(np.maximum(regression.rest, 1e-300)).sum())
