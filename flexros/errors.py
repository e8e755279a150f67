"""Errors that reach the user as one clear sentence and an exit code."""

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
"""Names beyond which not all are listed, and how many are then (chosen)."""


class FlexrosError(Exception):
    """Base of all errors that FlexROS raises on purpose; `exit_code` is what the command line returns."""

    exit_code: ClassVar[int] = 1

    def __str__(self) -> str:
        """The text as one line: it may hold names from foreign files."""
        return one_line(super().__str__())


class InputError(FlexrosError):
    """Bad input: the message says what was given, what is allowed, where it came from and what to do.

    Attributes:
        argument: Name of the argument that was bad, empty where none is; the command line puts its option there.
    """

    exit_code: ClassVar[int] = 2

    def __init__(self, message: str, argument: str = "") -> None:
        """Keep message and argument."""
        super().__init__(message)
        self.argument = argument


class RunError(FlexrosError):
    """A run aborted: the message says what happened, when, and where the log up to that point is."""

    exit_code: ClassVar[int] = 3


class InterruptedRunError(RunError):
    """A run was interrupted from outside, by Ctrl-C or termination."""

    exit_code: ClassVar[int] = INTERRUPTED


@contextmanager
def source_named(source: str) -> Iterator[None]:
    """Put the source before the text of an InputError that is raised inside.

    Args:
        source: Where the input came from, e.g. "scenario circle_pd, key start".

    Raises:
        InputError: "<source>: <text>".
    """
    try:
        yield
    except InputError as error:
        raise InputError(f"{source}: {error}", error.argument) from error


@contextmanager
def argument_named(argument: str) -> Iterator[None]:
    """Give the name of an argument to every InputError that is raised inside and names none.

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
    """Make the error for a name that is not known, offering the nearest and listing all, or of many the nearest.

    Args:
        kind: What is named, e.g. "robot".
        given: The name that was given.
        allowed: The names that would have been valid.
        source: Where the name came from, e.g. "scenario circle_pd, key robot".
        other: What else is allowed, e.g. "or the path of a .yaml file".

    Returns:
        The error, to be raised by the caller.
    """
    names = sorted(allowed)
    nearest = get_close_matches(given, names, n=1)
    hint = f"did you mean '{nearest[0]}'? " if nearest else ""
    origin = f" in {source}" if source else ""
    if len(names) > _MANY:
        near = get_close_matches(given, names, n=_NEAR, cutoff=0.0)
        listed = f"the nearest of {len(names)} are {', '.join(near)}"
    else:
        listed = f"allowed are {', '.join(names)}"
    return InputError(f"unknown {kind} '{given}'{origin}: {hint}{listed}{other and ' ' + other}")
