"""The contract of effects, effects at a location, and their lookup and parsing by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Literal

from flexros.config.settings import Settings, validate
from flexros.discovery import members
from flexros.effects.kinds.floors import WORD, check_has_floor, floor_of
from flexros.effects.kinds.ranges import HarmonicEntry, Range
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from typing import Self

    from flexros.robot import Robot


Stage = Literal["actuator", "motor friction", "gear", "structure", "load", "sensor", "timing"]
"""Point of the loop at which an effect acts."""

FOLDERS = ("encoders", "friction", "gear", "left_out", "servos")
"""Folders of `flexros/effects` with effects that have much in common."""


class AbstractEffect(Settings, ABC):
    """A deviation of the plant from the nominal model.

    How to add one: write one file in `flexros/effects`, or in one of its `FOLDERS`, with one final subclass of one of
    the kinds below. It is discovered by its name in scenarios (`plant.effects`), on the command line and in everything
    that lists effects. It provides:

    1. `name`, a class variable by which it is chosen, and `stage`, where in the loop it acts.
    2. Its parameters as fields, each with a description that states unit and meaning; the default is the neutral
       value, which switches the effect off.
    3. `locations`, the locations of a robot where it can act.
    4. For a diagnosis: `ranges` of the parameters to fit, `fingerprint`, one sentence on its observable signature,
       `signatures`, the pictures of `flexros/gap/signatures` that show it, and where they apply `extends`, `plain`,
       `harmonics` and `delays_commands`.
    5. The methods of its kind: `AbstractModelChange` returns a changed robot, `AbstractChangedValues` changed parameter
       values, `AbstractCommandLaw` the torque between command and motor, `AbstractMotorTorque` a smooth torque at a
       motor, `AbstractDryFriction` friction with sticking, `AbstractYieldingFriction` the same with contacts that may
       yield, `AbstractBristleFriction` friction with presliding,
       `AbstractGearLaw` torques of a spring, `AbstractCurve` torques at a motor or spring without a law,
       `AbstractArmLaw` forces on the arm, `AbstractSensor` a changed measurement, `AbstractToolError` a changed tool
       geometry.

    Any number of effects combine at any locations. The reference shows each with a picture: a row in
    `docs/generate/effects_pictures.py`, then `python docs/generate/effects_page.py`.
    """

    name: ClassVar[str]
    stage: ClassVar[Stage]
    fingerprint: ClassVar[str] = ""
    """Observable signature of the effect: one sentence for report and guide."""
    words: ClassVar[str] = ""
    """Name of the effect in sentences, where it is not its `name`."""
    signatures: ClassVar[tuple[str, ...]] = ()
    """Pictures of a diagnosis in which the effect shows, by name (`flexros.gap.signatures`), the clearest first."""
    ranges: ClassVar[Mapping[str, Range]] = MappingProxyType({})
    """Bounds of the parameters that a diagnosis fits; parameters without a range keep their defaults."""
    extends: ClassVar[Mapping[str, Mapping[str, str]]] = MappingProxyType({})
    """Simpler effects that it contains, by name, with the shared parameters: its fit starts from theirs."""
    plain: ClassVar[bool] = False
    """Whether it is one parameter of the model or of a signal, without a shape of its own. A diagnosis allows such an
    effect less model-form error than a law of friction, backlash or ripple."""
    taken_for: ClassVar[tuple[str, ...]] = ()
    """Effects at the same place, by name, that a regression of torques may show in place of this one."""
    shape_doubt: ClassVar[Mapping[str, float]] = MappingProxyType({})
    """Standard deviation of parameters that shape the law, by how other laws of the same thing look like another shape:
    on a log whose law may be any of them, sizes are known no better than this leaves them."""
    harmonics: ClassVar[tuple[HarmonicEntry, ...]] = ()
    """Where its harmonic of the rotor angle enters, for effects with an `order`, which a diagnosis finds in the
    prediction errors."""
    one_level: ClassVar[bool] = False
    """Whether it is dry friction that has one level at all speeds. How it sticks does not depend on what that level
    follows, so that a diagnosis tells two such effects of a motor apart by the distance of their predictions."""
    common_factor: ClassVar[str] = ""
    """Parameter up to which a log may determine the sizes of other effects at its motor; empty for none. Where those
    end at a limit of their search while it is positive, the effect is left out first: without it they are within their
    ranges again, without them nothing would be left."""
    turned: ClassVar[tuple[str, ...]] = ()
    """Parameters with the other sign at a joint that counts the other way round, see `turned_round`."""
    unsaid: ClassVar[tuple[str, ...]] = ()
    """Parameters that a text names only where they are not at their defaults. A diagnosis fits them once it has found
    the effect without them, and leaves them out together."""
    uneven: ClassVar[tuple[str, ...]] = ()
    """Sizes of a difference between directions, which a motion in one direction does not tell from the others."""
    seeks_less: ClassVar[bool] = False
    """Whether a diagnosis seeks its `reductions` in every log, not in those of real machines alone."""
    jumps: ClassVar[bool] = False
    """Whether predictions with it jump where parameters change a little, as where a contact begins a step earlier."""
    together: ClassVar[bool] = False
    """Whether initial values of its parameters belong together, one of each; else all combinations are tried."""
    sought_where: ClassVar[str] = ""
    """Where alone a diagnosis seeks it: the end of a sentence. Empty for everywhere, and for what the begin of a search
    may find without seeking it."""
    on_request: ClassVar[bool] = False
    """Whether it competes in a diagnosis only where the settings name it."""
    delays_commands: ClassVar[bool] = False
    """Whether it delays commands by its parameter `time` [s]. A predictor then shifts the recorded samples."""

    @abstractmethod
    def locations(self, robot: Robot) -> tuple[str, ...]:
        """Return the locations where the effect can act: motors, springs or bodies, or "tool", "base", "all"."""

    def sought(self, robot: Robot, location: str) -> bool:
        """Return whether a diagnosis seeks the effect at one of its `locations`; default: always."""
        del robot, location
        return True

    def sought_if_measured(self, robot: Robot, location: str) -> bool:
        """Return the same for the log of a real machine, whose numbers are uncertain; default: as in simulated ones."""
        return self.sought(robot, location)

    def sought_for_curve(self, robot: Robot, location: str) -> bool:
        """Return whether it is tried in place of a curve of unknown law; by default where a measured log seeks it."""
        return self.sought_if_measured(robot, location)

    def visible(self, noise: float) -> bool:
        """Return whether the effect is distinguishable from the simpler ones that it extends.

        Args:
            noise: Noise of the encoder at its location, rms [rad or m].
        """
        del noise
        return True

    def fitted(self, robot: Robot, location: str) -> Mapping[str, Range]:
        """Return the ranges of the parameters that are fitted at one of its `locations`; default: all, by name."""
        del robot, location
        return self.ranges

    @classmethod
    def shaped_by(cls, name: str) -> bool:
        """Return whether a parameter with a range only shapes the effect, such as a frequency, and is no size of it."""
        allowed = cls.ranges[name]
        return cls.model_fields[name].default != 0.0 or allowed.vanishes == "never" or allowed.scale == "phase"

    def numbers(self, robot: Robot, location: str) -> tuple[str, ...]:
        """Return the names of the parameters of the robot that it changes or adds to at one of its `locations`.

        Default: none, as for a law that the model lacks.
        """
        del robot, location
        return ()

    def reductions(self, robot: Robot, location: str, known: Sequence[AbstractEffect] = ()) -> Mapping[str, float]:
        """Return the largest sizes of negative values, by name of the parameter [its unit]; default: none.

        A parameter that adds to a number of the nominal model is negative where that number is too large.

        Args:
            robot: The nominal robot.
            location: One of its `locations`.
            known: Laws that the nominal model has there.
        """
        del robot, location, known
        return {}

    def turned_round(self) -> Self:
        """Return the same effect as stated for a joint that counts the other way round."""
        return self.model_copy(update={name: -getattr(self, name) for name in self.turned})

    def stands_for(self) -> str:
        """Return what is likelier where the effect has a size that it hardly ever has; empty for a usual one, default.

        A clause of a warning, after the name of the effect.
        """
        return ""

    def check_on(self, robot: Robot, location: str) -> None:
        """Refuse values that a robot does not allow at one of the effect's `locations`; default: none.

        Raises:
            InputError: Names the parameter, its value and the allowed values.
        """


@dataclass(frozen=True)
class PlacedEffect:
    """An effect at a location.

    Attributes:
        effect: The effect; parameters given in noise floors hold the number of floors until `on` resolves them.
        location: The location.
        in_floors: Names of the parameters that are given in noise floors.
    """

    effect: AbstractEffect
    location: str
    in_floors: tuple[str, ...] = ()

    def __str__(self) -> str:
        """Format it as in a scenario, with all parameters but those that go without saying."""
        fields, unsaid = type(self.effect).model_fields, self.effect.unsaid
        parameters = ",".join(
            f"{name}={value}{WORD if name in self.in_floors else ''}"
            for name, value in self.effect.model_dump().items()
            if name not in unsaid or value != fields[name].default
        )
        return f"{self.effect.name}@{self.location}:{parameters}"

    def on(self, robot: Robot) -> PlacedEffect:
        """Convert parameters given in noise floors to SI values on a robot without effects.

        Raises:
            InputError: A parameter has no floor at this location.
        """
        if not self.in_floors:
            return self
        kind, values = type(self.effect), self.effect.model_dump()
        origin = f"{kind.name}@{self.location}"
        for name in self.in_floors:
            values[name] *= floor_of(robot, kind.ranges[name], self.location, f"{origin}: parameter '{name}'")
        return PlacedEffect(validate(kind, values, origin), self.location)

    def check_location(self, robot: Robot) -> None:
        """Refuse a location that the robot does not have."""
        allowed = self.effect.locations(robot)
        if self.location not in allowed:
            raise unknown_name(f"location of {self.effect.name} on robot {robot.name}", self.location, allowed)


@cache
def effects() -> Mapping[str, type[AbstractEffect]]:
    """Return all effects of this package, by name."""
    return members("flexros.effects", AbstractEffect, folders=FOLDERS)  # type: ignore[type-abstract]


def parse_effect(text: str, source: str) -> PlacedEffect:
    """Parse an effect as written in a scenario or on the command line: NAME@LOCATION:parameter=value,...

    Args:
        text: The effect, e.g. "payload_error@tool:relative=0.05", or with a value in noise floors of the robot
            "coulomb_friction@motor_1:level=12floors", see `flexros.effects.kinds.floors`.
        source: Origin of the text, for error messages.

    Returns:
        The effect at its location; `check_location` checks the location on a robot.

    Raises:
        InputError: Wrong form, unknown effect or parameter, or a value out of bounds.
    """
    head, _, tail = text.partition(":")
    name, at, location = head.partition("@")
    if not at or not location:
        raise InputError(
            f"{source} is '{text}', but must be NAME@LOCATION:parameter=value,..., "
            "for instance payload_error@tool:relative=0.05"
        )
    if name not in effects():
        raise unknown_name("effect", name, effects(), source)
    kind, origin = effects()[name], f"{source} {name}"
    parameters = _parameters(tail, origin)
    in_floors = tuple(key for key, value in parameters.items() if value.endswith(WORD))
    values = {key: value.removesuffix(WORD) for key, value in parameters.items()}
    for key in in_floors:
        if key in kind.model_fields:
            check_has_floor(kind.ranges.get(key), key, origin)
    return PlacedEffect(validate(kind, values, origin), location, in_floors)


def _parameters(text: str, source: str) -> dict[str, str]:
    """Split parameter=value,... and refuse duplicates."""
    parameters: dict[str, str] = {}
    for part in (part for part in text.split(",") if part):
        name, _, value = part.partition("=")
        if name in parameters:
            raise InputError(
                f"{source}: parameter '{name}' is given twice, as {parameters[name]} and {value}; remove one of them"
            )
        parameters[name] = value
    if not parameters:
        raise InputError(f"{source}: no parameter is given, so it would do nothing; add one, e.g. :relative=0.05")
    return parameters
