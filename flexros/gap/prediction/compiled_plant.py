"""Machine code of the robot with the laws of some candidates, shared by all hypotheses that contain no others."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, lru_cache, partial
from typing import TYPE_CHECKING

import casadi as ca

from flexros.compile.loop.prediction import PredictionLoop
from flexros.compile.over_samples import FunctionOverSamples
from flexros.effects import PlacedLaw
from flexros.effects.kinds.arm_law import AbstractArmLaw
from flexros.effects.kinds.bristle_friction import AbstractBristleFriction
from flexros.effects.kinds.command_law import AbstractCommandLaw
from flexros.effects.kinds.dry_friction import AbstractDryFriction
from flexros.effects.kinds.first_order_lag import AbstractFirstOrderLag
from flexros.effects.kinds.law import AbstractLaw
from flexros.effects.kinds.model_change import AbstractChangedValues
from flexros.effects.kinds.motor_law import AbstractMotorTorque
from flexros.gap.prediction.fractional_delay import HALVES
from flexros.gap.prediction.most_friction import most_friction
from flexros.prediction.integration_step import integration_steps
from flexros.simulate.open_loop import feed_through
from flexros.simulate.plant_model import PlantModel

if TYPE_CHECKING:
    from collections.abc import Hashable, Mapping, Sequence

    from flexros.arrays import FloatArray
    from flexros.effects import RobotWithEffects
    from flexros.gap.candidates.candidate import Candidate, Hypothesis
    from flexros.prediction.integration_step import IntegrationSteps
    from flexros.robot import Robot

LANES = 8
"""Parameter sets that are predicted in parallel."""
PLANTS = 16
"""Plants that are kept (chosen)."""
FEWER = 2
"""Times that long steps must be fewer to serve for changes of a prediction [1] (chosen): they are compiled as well."""
STEPS_OF_STATES = 2
"""Fewest steps per sample with bristles or lags (chosen): as many as delayed torques, with which they compete, need.
The error of one step of 0.5 ms with bristles was 0.6 % of what a delay gained, far more than what tells it from a
lag."""


class CompiledPlant:
    """The robot with the laws of some candidates, each of which may be switched off.

    Compiling takes longer than many predictions, so that candidates are compiled together where they are tried in turn.

    Args:
        model: The nominal model: robot and laws of known effects.
        candidates: Effects in addition to these.
        tolerated: Names of the parameters of the robot that may deviate.
        sample_time: Time between two samples [s].
        measured_torque: Whether the torques of the log were measured at the motors, after the nominal delay.
        rough: Whether it takes as few steps per sample as serve to compare its predictions with each other.
        steps: Integration steps; None: those that the robot and the candidates need.

    Attributes:
        robot: The nominal robot.
        laws: The candidates that are laws.
        robot_names: Names of the robot parameters that may change.
        model: The plant.
        delay: Delay of the torques of the log [s]; one per motor if effects delay single motors.
        parts: Parts of a sample with torques of their own: two where a candidate delays these, as any delay needs.
        steps: Integration steps.
        loop: The predictor of constant gain around it, of one part after the other.
    """

    def __init__(
        self,
        model: RobotWithEffects,
        candidates: Sequence[Candidate],
        tolerated: Sequence[str],
        sample_time: float,
        *,
        measured_torque: bool = False,
        rough: bool = False,
        steps: IntegrationSteps | None = None,
    ) -> None:
        self.robot = model.robot
        self.laws = tuple(one for one in candidates if is_law(one))
        laws = [_law(place, one) for place, one in enumerate(self.laws)]
        self._keys = [_key(one) for one in self.laws]
        self._off = [_switched_off(one, law.effect) for one, law in zip(self.laws, laws, strict=True)]
        changed = [name for one in candidates for name in changed_names(self.robot, one)]
        self.robot_names = tuple(sorted({*changed, *tolerated}))
        names = [*self.robot_names, *(name for law in laws for name in law.parameters)]
        self.model = PlantModel(self.robot, (*_felt(model.laws), *laws), names)
        self.delay = self.model.delay_from(model.added_delay if measured_torque else self.robot.delay)
        known = [law.effect for law in model.laws]
        fast = any(one.needs_short_steps for one in (*known, *map(_acting, self.laws)))
        self.parts = parts_of(self.robot, candidates)
        needed = partial(
            integration_steps,
            self.robot,
            sample_time,
            most_friction(model, candidates),
            may_be_implicit=self.robot.is_rigid,
            fast=fast,
            curved=self.model.friction_follows_speed,
        )
        if steps is None:
            steps = needed(rough=rough)
            least = 1 if rough or not any(map(_bends_or_lags, self.laws)) else STEPS_OF_STATES
            steps = replace(steps, number=max(least, steps.number))
        of_part, self._few = (-(-one.number // self.parts) for one in (steps, needed(rough=True)))
        self.steps = replace(steps, number=of_part * self.parts)
        self._loop = partial(
            PredictionLoop,
            self.model.functions(
                feed_through(self.robot.n_motors), implicit=steps.implicit, placed=self.robot.is_rigid
            ),
            sample_time=sample_time / self.parts,
            delay=self.delay if self.parts == 1 else 0.0,  # else the halves are those of the whole delay
            lanes=LANES,
        )
        self.loop = self._loop(substeps=of_part)
        self._sensors: dict[tuple[tuple[str, int], ...], tuple[FunctionOverSamples, bool]] = {}

    @cached_property
    def coarse_loop(self) -> PredictionLoop | None:
        """The same predictor with few long steps, for changes of a prediction; None where that saves little."""
        worth = not self.steps.implicit and self.steps.number >= FEWER * self._few * self.parts
        return self._loop(substeps=self._few) if worth else None

    def sensors(self, wanted: Sequence[tuple[str, int]]) -> tuple[FunctionOverSamples, bool]:
        """Return the outputs of further sensors over samples, and whether they depend on the input of the model.

        Args:
            wanted: Quantity and number of the motor or of the axis, of each sensor.
        """
        key = tuple(wanted)
        if key not in self._sensors:
            function = self.model.sensor_outputs(key)
            arguments = function.sx_in()
            driven = any(ca.which_depends(function(*arguments), arguments[1], 1, True))
            self._sensors[key] = FunctionOverSamples(function, LANES), driven
        return self._sensors[key]

    def covers(self, hypothesis: Hypothesis) -> bool:
        """Return whether it holds every law of a hypothesis and may change every parameter that it changes."""
        keys = dict(zip(self._keys, self.laws, strict=True))
        wanted = {_key(one) for one in hypothesis if is_law(one)}
        changed = {name for one in hypothesis for name in changed_names(self.robot, one)}
        off = all(switchable(law) for key, law in keys.items() if key not in wanted)
        alike = any(map(_driven_states, self.laws)) == any(map(_driven_states, hypothesis))
        alike = alike and parts_of(self.robot, hypothesis) == self.parts
        return alike and off and wanted <= keys.keys() and changed <= set(self.robot_names)

    def place(self, candidate: Candidate) -> int:
        """Return the place of a candidate that is a law among the laws of the plant."""
        return self._keys.index(_key(candidate))

    def law_parameters(self, acting: Mapping[int, AbstractLaw]) -> list[float]:
        """Return the parameters of all laws, in their order.

        Args:
            acting: Laws that act, by their place; the others are switched off.
        """
        numbers: list[float] = []
        for place, off in enumerate(self._off):
            numbers += acting[place].parameter_values.values() if place in acting else off
        return numbers


@lru_cache(maxsize=PLANTS)
def compiled_plant(
    model: RobotWithEffects,
    candidates: Hypothesis,
    tolerated: tuple[str, ...],
    sample_time: float,
    *,
    measured_torque: bool = False,
    rough: bool = False,
    steps: IntegrationSteps | None = None,
) -> CompiledPlant:
    """Return a plant with some candidates; arguments as of `CompiledPlant`.

    A search comes back to the same effects: with other initial values, in a fit to the end, in a gap on other data.
    """
    return CompiledPlant(
        model, candidates, tolerated, sample_time, measured_torque=measured_torque, rough=rough, steps=steps
    )


def in_lanes(sets: FloatArray) -> list[FloatArray]:
    """Divide sets of numbers, one per column, into those that are predicted in parallel, shape (n, `LANES`) at most.

    Args:
        sets: The sets, shape (n, sets).
    """
    return [sets[:, begin : begin + LANES] for begin in range(0, sets.shape[1], LANES)]


def grouped(candidates: Sequence[Candidate], most: int) -> list[list[Candidate]]:
    """Divide candidates into groups that are compiled together; those that make the plant slower are among themselves.

    Args:
        candidates: The candidates.
        most: Most candidates of a group.
    """
    kinds: dict[Hashable, list[Candidate]] = {}
    for candidate in candidates:
        kinds.setdefault(_kind(candidate), []).append(candidate)
    return [group[begin : begin + most] for group in kinds.values() for begin in range(0, len(group), most)]


def is_law(candidate: Candidate) -> bool:
    """Return whether a candidate acts in the plant, and not on the record of the commands."""
    return issubclass(candidate.effect, AbstractLaw) and not delays(candidate)


def delays(candidate: Candidate) -> bool:
    """Return whether a candidate delays the record of the commands."""
    return candidate.effect.delays_commands


def parts_of(robot: Robot, candidates: Sequence[Candidate]) -> int:
    """Return the parts of a sample with torques of their own: two where a candidate delays torques, else one."""
    return HALVES if any(map(delays, candidates)) and robot.commands != "position" else 1


def changed_names(robot: Robot, candidate: Candidate) -> tuple[str, ...]:
    """Return the names of the robot parameters that a candidate changes."""
    if not issubclass(candidate.effect, AbstractChangedValues) or delays(candidate):
        return ()
    effect = candidate.typical().effect
    assert isinstance(effect, AbstractChangedValues)
    return tuple(effect.values(robot, candidate.location))


def _kind(candidate: Candidate) -> Hashable:
    """Return what candidates of one group have in common: the effect where it is more than a torque."""
    if not is_law(candidate):
        return candidate.effect.name if delays(candidate) else None
    plain = isinstance(_acting(candidate), (AbstractMotorTorque, AbstractDryFriction)) and not _driven_states(candidate)
    return None if plain else candidate.effect.name if switchable(candidate) else candidate


def switchable(candidate: Candidate) -> bool:
    """Return whether a law with its size at zero leaves the plant as it is, even where its states are kept."""
    lasting = (AbstractCommandLaw, AbstractArmLaw)  # a lag without time constant, a mode without inertia
    return not is_law(candidate) or not issubclass(candidate.effect, lasting) or not _driven_states(candidate)


def _driven_states(candidate: Candidate) -> int:
    """Return the number of states that a candidate adds to the plant, but those that only time drives."""
    return _acting(candidate).n_driven_states if is_law(candidate) else 0


def _bends_or_lags(candidate: Candidate) -> bool:
    """Return whether a candidate is a friction that holds by bristles, or a lag."""
    return isinstance(_acting(candidate), (AbstractBristleFriction, AbstractFirstOrderLag))


def _key(candidate: Candidate) -> Hashable:
    """Return what makes a law: its kind, location, and the flags that select its form."""
    flags = frozenset((name, value) for name, value in candidate.fixed if isinstance(value, bool))
    return candidate.effect, type(_acting(candidate)), candidate.location, flags


def _law(place: int, candidate: Candidate) -> PlacedLaw:
    """Build the law of a candidate under a name that no law of the nominal model has."""
    return PlacedLaw(f"candidate {place}", _acting(candidate), candidate.location)


@lru_cache(maxsize=4096)
def _acting(candidate: Candidate) -> AbstractLaw:
    """Make the law that acts for a candidate, with typical parameters."""
    effect = candidate.typical().effect
    assert isinstance(effect, AbstractLaw)
    return effect.acting


def _switched_off(candidate: Candidate, typical: AbstractLaw) -> list[float]:
    """Return the parameters of a law without effect: its sizes are zero, and those that shape it stay typical."""
    sizes = [free.name for free in candidate.free if candidate.neutral(free) is not None]
    return list((typical.parameter_values | dict.fromkeys(sizes, 0.0)).values())


def _felt(laws: Sequence[PlacedLaw]) -> list[PlacedLaw]:
    """Leave out quantization, which is part of the noise of a predictor."""
    return [law for law in laws if not law.effect.as_noise]
