"""The contract of observers inside control laws, and their lookup by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, TypeAlias

from pydantic import BeforeValidator, PlainSerializer

from flexros.config.settings import Settings, validate
from flexros.discovery import members
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    import casadi

    from flexros.control.context import LoopContext
    from flexros.control.limited import LoopSignals


@dataclass(frozen=True, eq=False)
class Estimate:
    """Estimated states at a sample, SX (M, 1) each.

    Attributes:
        motor_position: [rad or m].
        motor_velocity: [rad/s or m/s].
        link_position: Arm coordinates behind the gears [rad or m].
        link_velocity: [rad/s or m/s].
    """

    motor_position: casadi.SX
    motor_velocity: casadi.SX
    link_position: casadi.SX
    link_velocity: casadi.SX


class AbstractObserver(Settings, ABC):
    """Estimates the states of motors and links from the measurements of a loop.

    How to add one: write one file in `flexros/control/observers` with one final subclass, which is found by its `kind`.
    It provides the settings as fields, `check`, `state_size`, `gains` and `estimate`.
    """

    kind: ClassVar[str]

    @abstractmethod
    def check(self, context: LoopContext) -> None:
        """Refuse a robot that lacks a sensor or does not fit.

        Raises:
            InputError: Names robot and what is missing.
        """

    @abstractmethod
    def state_size(self, context: LoopContext) -> int:
        """Return the number of states."""

    @abstractmethod
    def gains(self, context: LoopContext) -> Mapping[str, float]:
        """Return parameters that may change at run time, by name, e.g. "observer.speed_filter"."""

    @abstractmethod
    def estimate(
        self, state: casadi.SX, signals: LoopSignals, gains: Mapping[str, casadi.SX]
    ) -> tuple[Estimate, Callable[[casadi.SX], casadi.SX]]:
        """Estimate the states at a sample.

        Args:
            state: State of the observer, SX (state_size, 1); zeros before the first sample.
            signals: References and measurements of the sample.
            gains: The values of `gains`, SX scalars.

        Returns:
            The estimate, and the next state as a function of the torque command of the sample, SX (M, 1).
        """


@cache
def observers() -> Mapping[str, type[AbstractObserver]]:
    """Return all observers of this package, by `kind`."""
    return members("flexros.control.observers", AbstractObserver, "kind")  # type: ignore[type-abstract]


def _observer(given: Any) -> Any:
    """Build an observer by its kind; its error becomes part of the controller's."""
    if isinstance(given, AbstractObserver):
        return given
    if not isinstance(given, dict):
        raise ValueError(f"is {given!r}, but must be a mapping with the key kind and the settings of that observer")
    kind = str(given.get("kind", ""))
    try:
        if kind not in observers():
            raise unknown_name("kind", kind, observers(), "observer")
        return validate(
            observers()[kind], {key: value for key, value in given.items() if key != "kind"}, "controller.observer"
        )
    except InputError as error:
        raise ValueError(str(error)) from error


def _as_mapping(observer: AbstractObserver) -> dict[str, Any]:
    return {"kind": observer.kind, **observer.model_dump(mode="json")}


Observer: TypeAlias = Annotated[AbstractObserver, BeforeValidator(_observer), PlainSerializer(_as_mapping)]
