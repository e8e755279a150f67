"""Contract of a feedforward method, and the discovery of all methods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from flexros.discovery import members
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from flexros.feedforward.motion import Motion
    from flexros.feedforward.problem import FeedforwardProblem
    from flexros.feedforward.specification import FeedforwardSpecification


class AbstractFeedforward(ABC):
    """A way to compute motor references and torques from a trajectory.

    How to add a method: write one file in `flexros/feedforward` with one final subclass; it is then found by its
    name in scenarios, in the direct simulation and in the feedforward node alike. It provides:

    1. `name`, a class variable: the value of `method` in a specification.
    2. `motions`, a generator of the motion in chunks. All chunks joined must not depend on the chunk size, bit for
       bit, because the feedforward node streams what the direct simulation computes at once.
    3. `compensates_hold`, if its torque should not by default be the mean over the interval in which it is held (see
       `flexros.feedforward.hold`).

    `compute_reference` adds friction, hold and tool pose; they are not part of a method.
    """

    name: ClassVar[str]

    def compensates_hold(self, specification: FeedforwardSpecification) -> bool:
        """Return whether the mean torque over the hold interval is the default of this method."""
        del specification
        return True

    @abstractmethod
    def motions(self, problem: FeedforwardProblem, chunk: int) -> Iterator[Motion]:
        """Compute the motion, at most `chunk` samples at a time.

        Args:
            problem: Robot, trajectory and settings.
            chunk: Largest number of samples per yield.

        Yields:
            Successive parts of the motion; together as many samples as the problem has.

        Raises:
            InputError: The problem does not fit the method.
            RunError: The computation aborted at a sample.
        """


@cache
def feedforward_methods() -> Mapping[str, AbstractFeedforward]:
    """Find all methods in this package, by name."""
    found = members("flexros.feedforward", AbstractFeedforward)  # type: ignore[type-abstract]
    return MappingProxyType({name: method() for name, method in found.items()})


def feedforward_method(name: str) -> AbstractFeedforward:
    """Return a method by its name.

    Raises:
        InputError: No such method.
    """
    methods = feedforward_methods()
    if name not in methods:
        raise unknown_name("feedforward method", name, methods, "feedforward.method")
    return methods[name]
