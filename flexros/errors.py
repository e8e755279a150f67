"""Errors reported to the user as one clear sentence with an exit code."""

from __future__ import annotations

from contextlib import contextmanager
from difflib import get_close_matches
from typing import TYPE_CHECKING, ClassVar

from flexros.one_line import one_line

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

INTERRUPTED = 130
"""Exit code after Ctrl-C or termination."""

INTERNAL_ERROR = 70
"""Exit code of an internal error of FlexROS, with a traceback (EX_SOFTWARE of sysexits.h)."""


_MANY, _NEAR = 20, 5
"""Number of names up to which all are listed, and number of nearest names listed beyond (chosen)."""


class FlexrosError(Exception):
    """Base of all errors that FlexROS raises on purpose; `exit_code` is what the command line returns."""

    exit_code: ClassVar[int] = 1

    def __str__(self) -> str:
        """The text as one line: it may hold names from foreign files."""
        return one_line(super().__str__())


class InputError(FlexrosError):
    """Invalid input: the message states the given value, the allowed ones, its origin and what to do.

    Attributes:
        argument: Name of the invalid argument, empty for none; the command line replaces it by its option.
    """

    exit_code: ClassVar[int] = 2

    def __init__(self, message: str, argument: str = "") -> None:
        """Store message and argument."""
        super().__init__(message)
        self.argument = argument


class RunError(FlexrosError):
    """An aborted run: the message states what happened, when, and where the log up to that point is."""

    exit_code: ClassVar[int] = 3


class InterruptedRunError(RunError):
    """A run was interrupted from outside, by Ctrl-C or termination."""

    exit_code: ClassVar[int] = INTERRUPTED


@contextmanager
def source_named(source: str) -> Iterator[None]:
    """Prefix the message of an InputError that is raised inside, unless it begins with that source already.

    Args:
        source: Origin of the input, e.g. "scenario circle_pd, key start".

    Raises:
        InputError: "<source>: <text>".
    """
    try:
        yield
    except InputError as error:
        if str(error).startswith((f"{source}: ", f"{source}, ")):
            raise
        raise InputError(f"{source}: {error}", error.argument) from error


@contextmanager
def argument_named(argument: str) -> Iterator[None]:
    """Set the argument of every InputError that is raised inside and has none.

    Args:
        argument: Name of the argument that is checked inside.

    Raises:
        InputError: The same error.
    """
    try:
        yield
    except InputError as error:
        error.argument = error.argument or argument
        raise


def unknown_name(kind: str, given: str, allowed: Iterable[str], source: str = "", other: str = "") -> InputError:
    """Return the error for an unknown name, with the nearest name and the allowed ones, or the nearest of many.

    Args:
        kind: Kind of the name, e.g. "robot".
        given: The unknown name.
        allowed: The valid names.
        source: Origin of the name, e.g. "scenario circle_pd, key robot".
        other: Further allowed values, e.g. "or the path of a .yaml file".
    """
    names = sorted(allowed)
    nearest = get_close_matches(given, names, n=1)
    hint = f"did you mean '{nearest[0]}'? " if nearest else ""
    origin = f" in {source}" if source else ""
    if len(names) > _MANY:
        near = get_close_matches(given, names, n=_NEAR, cutoff=0.0)
        listed = f"the nearest of {len(names)} are {', '.join(near)}"
    else:
        listed = f"allowed are {', '.join(names)}" if names else "there is none"
    return InputError(f"unknown {kind} '{given}'{origin}: {hint}{listed}{other and ' ' + other}")
