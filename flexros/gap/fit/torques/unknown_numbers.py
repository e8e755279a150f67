"""Numbers that a robot file leaves out, estimated from the log, since unknown is not wrong: rotors and the load."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from flexros.effects import PlacedEffect
from flexros.effects.friction.viscous_friction import ViscousFriction
from flexros.effects.left_out.body_difference import BodyDifference
from flexros.effects.left_out.rotor_inertia import RotorInertia
from flexros.effects.left_out.tool_load import ENTRIES, ToolLoad, body_numbers, last_moved
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.torques.balanced import regress_balanced
from flexros.gap.fit.torques.delay import torque_delay
from flexros.gap.fit.torques.missing_load import bodies_are_off, clear_load, load_before_bodies, lowered, may_carry
from flexros.gap.fit.torques.missing_rotors import least_rotors, stops_at_once
from flexros.gap.fit.torques.regression import at_zeros, only_coulomb, regress_torque, upright
from flexros.gap.fit.torques.rough_bodies import (
    CENTER,
    fitted_bodies,
    is_inertial,
    with_rough_bodies,
    with_rough_inertias,
)
from flexros.gap.fit.torques.solution import rest_of
from flexros.gap.fit.torques.turned_weight import with_turned_weight
from flexros.gap.settings import TorqueStartSettings
from flexros.robot.parameters import INERTIA_COMPONENTS
from flexros.robot.point_inertia import point_inertia

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from flexros.effects import RobotWithEffects
    from flexros.gap.fit.candidate_fit import CandidateFit
    from flexros.gap.fit.torques.missing_load import Regress
    from flexros.gap.fit.torques.solution import TorqueRegression
    from flexros.record.record import Record
    from flexros.robot import Robot

PLACEHOLDER = 0.5
"""Share of such a friction that the torques of the log have at most, if it stands for none [1] (chosen)."""
UNCERTAIN = 0.5
"""Standard deviation of the logarithm of an estimated inertia, and of the mass and the centre of the body with an
estimated load: the prediction errors decide (chosen). Beside friction of a form that the regression lacks, the weight
showed half of a load of 2 kg, and rotors stood for the rest of it."""


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
        return replace(self, inertias=lacked, load=self.load if bare else None, placeholders=placeholders)

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
        uncertain = {f"{name}.inertia": UNCERTAIN for name in self.inertias}
        uncertain |= dict.fromkeys(self._of_load(robot), UNCERTAIN)
        bodies = with_rough_bodies(tolerance, self.rough)
        deviations = dict(zip(bodies.names, bodies.deviations, strict=True))
        deviations |= {name: one for name, one in uncertain.items() if robot.parameters[name].value != 0}
        return replace(bodies, names=tuple(deviations), deviations=tuple(deviations.values()))

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
        load = () if self.load is None else (self._fitted_load(robot, factors),)
        return (*rotors, *friction, *load, *(fitted_bodies(robot, factors) if self.rough else ()))

    def _of_load(self, robot: Robot) -> list[str]:
        if self.load is None:
            return []
        body = last_moved(robot)
        return [f"{body}.mass", *(f"{body}.center_of_mass.{axis}" for axis in CENTER)]

    def _fitted_load(self, robot: Robot, factors: Mapping[str, float]) -> PlacedEffect:
        """Return the load of a robot that has one, with mass and centre of its body scaled by factors.

        Where nothing of the load is left the body is lighter than by its file, which is a difference of that body.
        """
        assert self.load is not None
        body = last_moved(robot)
        mass, center, _ = body_numbers(robot, body)
        scaled, *places = (factors.get(name, 1.0) for name in self._of_load(robot))
        place, fitted = np.array([self.load.x, self.load.y, self.load.z]), center * np.array(places)
        own = mass * center - self.load.mass * place  # first moment of the body alone
        carried = float(scaled * mass - self.bare)
        if carried > 0:
            x, y, z = ((scaled * mass * fitted - own) / carried).tolist()
            return PlacedEffect(ToolLoad(mass=carried, x=x, y=y, z=z), "tool")
        alone = own / self.bare
        added = point_inertia(self.bare, alone - center) + point_inertia(self.load.mass, place - center)
        numbers = dict(zip(CENTER, (fitted - alone).tolist(), strict=True))
        numbers |= {name: float(added[ENTRIES[name]]) for name in INERTIA_COMPONENTS}
        return PlacedEffect(BodyDifference(mass=carried, **numbers), body)


def unknown_numbers(
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    settings: TorqueStartSettings | None = None,
    *,
    as_stated: bool = False,
) -> UnknownNumbers:
    """Estimate the rotor inertias that a model lacks and a load, from a log that this program has not simulated.

    A log of position commands shows none of them: its torques are not known, and a load is a candidate.

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
    unknown = bool(lacking) or may_carry(robot)
    if record.simulated or record.command is not None or not only_coulomb(model) or not unknown:
        return UnknownNumbers()
    of_bodies = inertias_of_bodies(record, robot)
    delay = torque_delay(record, model, tolerance, settings)
    regression = regress_balanced(record, model, tolerance, delay=delay, settings=settings)
    if regression is None:
        return UnknownNumbers()
    with_load_or_bodies = partial(
        _with_load_or_bodies,
        tolerance=tolerance,
        n_lacking=len(lacking),
        delay=delay,
        settings=settings,
        as_stated=as_stated,
    )
    shown = with_load_or_bodies(regression, record, model)
    turned = _turned(shown, regression, record, model, tolerance, delay, settings)
    if turned is not None:
        moved, standing = at_zeros(record, turned.zeros), replace(model, robot=upright(robot, turned.tilt))
        regression = regress_balanced(moved, standing, tolerance, delay=delay, settings=settings) or regression
        shown = with_load_or_bodies(regression, moved, standing)
    rotors = _clear_rotors(shown.regression, robot, of_bodies, lacking, settings)
    changes = dict(zip(robot.joint_names, shown.regression.viscous_friction.tolist(), strict=True))
    viscous = {name: robot.parameters[f"{name}.viscous_friction"].value for name in lacking}
    calmed = stops_at_once(robot, record.sample_time, {name: of_bodies[name] for name in lacking})
    unseen = {name: value for name, value in viscous.items() if value + changes[name] < PLACEHOLDER * value}
    bare = robot.parameters[f"{last_moved(robot)}.mass"].value if shown.load else 0.0
    return UnknownNumbers(rotors, shown.load, bare, unseen if calmed else {}, shown.rough)


def inertias_of_bodies(
    record: Record, robot: Robot, numbers: Mapping[str, float] = MappingProxyType({})
) -> dict[str, float]:
    """Return the inertia at every motor, with its rotor, in the middle of a motion [kg m2 or kg].

    Args:
        record: The motion.
        robot: The robot.
        numbers: Other values of its parameters, by name; fitted ones need be those of no possible body [SI].
    """
    state = robot.equilibrium(motor_position=np.median(record.position, axis=0))
    masses = robot.symbolic(tuple(numbers)).mass_matrix(state[: robot.n_coordinates], np.array([*numbers.values()]))
    return dict(zip(robot.joint_names, np.diag(np.asarray(masses, dtype=float))[list(robot.motor_rows)]))


@dataclass(frozen=True, eq=False)
class _Shown:
    """What the torques of a log show of a robot: with a load, with bodies that are far off, or with neither.

    Attributes:
        regression: The regression.
        load: The load; None without one.
        rough: Tolerance of bodies that are far off [1]; zero where they are not.
    """

    regression: TorqueRegression
    load: ToolLoad | None = None
    rough: float = 0.0


def _with_load_or_bodies(
    regression: TorqueRegression,
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    n_lacking: int,
    delay: float,
    settings: TorqueStartSettings,
    *,
    as_stated: bool,
) -> _Shown:
    """Add a load, or errors of bodies beyond their tolerance, where the torques show one of them clearly.

    Args:
        regression: Without either.
        record: The log.
        model: The nominal model.
        tolerance: Parameters of the robot that may deviate.
        n_lacking: Number of motors whose rotor is unknown.
        delay: Delay of the torques beyond that of the model [s].
        settings: Settings of the regressions.
        as_stated: As for `unknown_numbers`.
    """
    robot = model.robot
    regress = partial(regress_torque, record, model, delay=delay, settings=settings)
    may_be_rough = not as_stated and not robot.flexible_motors  # what springs leave is no error of bodies
    balanced = partial(regress_balanced, record, model, delay=delay, settings=settings)
    bodies = _of_bodies(regression, record, tolerance, balanced, regress, settings) if may_be_rough else None
    loaded, load = clear_load(regress, robot, tolerance, n_lacking, settings)
    if loaded is None and not (bodies and bodies.rough) and may_be_rough and may_carry(robot):
        beside = partial(regress, position_torques=regression.position_torques)
        loaded, load = load_before_bodies(beside, robot, tolerance, n_lacking, settings) or (None, None)
    if loaded is not None and (bodies is None or rest_of(loaded) < rest_of(bodies.regression)):
        return _Shown(loaded, load)  # what explains more stands for both
    return bodies or _Shown(regression)


def _of_bodies(
    regression: TorqueRegression,
    record: Record,
    tolerance: Tolerance,
    balanced: Callable[[Tolerance], TorqueRegression | None],
    regress: Regress,
    settings: TorqueStartSettings,
) -> _Shown | None:
    """Return what bodies explain whose inertias, or whose numbers altogether, are far off; None where neither does.

    Where inertias alone do as well, masses and centres keep their tolerance, and the search names the inertias.

    Args:
        regression: With bodies within their tolerance.
        record: The log.
        tolerance: Parameters of the robot that may deviate.
        balanced: The regression of a tolerance, beside a counterbalance where there is one.
        regress: The regression of a tolerance and a load.
        settings: Settings of the regressions.
    """
    wide = with_rough_bodies(tolerance, settings.rough_bodies)
    of_all = None if wide == tolerance else balanced(wide)
    if of_all is None:
        return None
    of_inertias = balanced(with_rough_inertias(tolerance, settings.rough_inertias))
    if of_inertias is not None and lowered(of_inertias, of_all, settings) < settings.before_bodies:
        return _Shown(of_inertias) if lowered(regression, of_inertias, settings) > settings.before_bodies else None
    off = bodies_are_off(of_all, regression, regress, record, settings)
    return _Shown(of_all, rough=settings.rough_bodies) if off else None


def _turned(
    shown: _Shown,
    regression: TorqueRegression,
    record: Record,
    model: RobotWithEffects,
    tolerance: Tolerance,
    delay: float,
    settings: TorqueStartSettings,
) -> TorqueRegression | None:
    """Return the regression with offsets of encoders or a slant of the base; None where the weight is not turned.

    They must explain more than a load or bodies that are far off, or be clear beside a load.

    Args:
        shown: What the torques show without them.
        regression: Their regression with neither.
        record: The log.
        model: The nominal model.
        tolerance: Parameters of the robot that may deviate.
        delay: Delay of the torques beyond that of the model [s].
        settings: Settings of the regressions.
    """
    regress = partial(regress_torque, record, model, delay=delay, settings=settings)
    alone = partial(regress, tolerance, position_torques=regression.position_torques)
    turned = with_turned_weight(alone, regression, model.robot, record, settings)
    if turned is not None and rest_of(turned) < rest_of(shown.regression):
        return turned
    if shown.load is None:
        return None
    loaded = partial(regress, Tolerance(), load="point", position_torques=shown.regression.position_torques)
    beside = loaded()
    return None if beside is None else with_turned_weight(loaded, beside, model.robot, record, settings)


def _clear_rotors(
    regression: TorqueRegression,
    robot: Robot,
    of_bodies: Mapping[str, float],
    lacking: Sequence[str],
    settings: TorqueStartSettings,
) -> dict[str, float]:
    """Return the inertias of the rotors that a model lacks and a regression shows [kg m2 or kg].

    It shows them clearly, or bodies alone are so light that it is the best guess, which prediction errors improve.
    """
    clear = dict(zip(robot.joint_names, regression.inertia.tolist(), strict=True))
    faint = dict(zip(robot.joint_names, regression.faint_inertia.tolist(), strict=True))
    least = least_rotors(robot, of_bodies, regression, settings)
    return {
        name: faint[name]
        for name in lacking
        if clear[name] > least[name] or faint[name] > settings.no_body * of_bodies[name]
    }
