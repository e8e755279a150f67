"""Options that several commands share, and their parsers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from flexros.record.topic_reader import TorqueSource

NamespaceOption = Annotated[str, typer.Option("--namespace", help="Namespace of the topics, when a log holds several.")]
"""Namespace of the robot in a log of several robots."""
KnownModelOption = Annotated[
    str, typer.Option("--model", help="Nominal robot model: built-in name, robot YAML or patch.yaml.")
]
"""A robot with its known effects."""
ToleranceOption = Annotated[
    str,
    typer.Option(
        "--tolerance",
        help="Relative tolerances of the model, e.g. stiffness=0.03,inertia=0.03,damping=0.3, and of the torques of an "
        "imported log: torque=0.005 for those of a simulator; default: those of the robot file, and 0.05.",
    ),
]
"""Relative tolerances of the parameters of a robot, see `parse_tolerance`."""

TorqueOption = Annotated[
    str,
    typer.Option("--torque", help="Torque that is used where both were recorded: command or measured."),
]
"""Source of the torque of a log, see `torque_source`."""


PrescribedOption = Annotated[
    str,
    typer.Option(
        "--prescribed",
        help="Motors without a usable torque, whose measured motion drives the model, e.g. motor_5,motor_6.",
    ),
]
"""Motors whose motion is prescribed."""


def torque_source(text: str) -> TorqueSource:
    """Check the source of the torque given on the command line.

    Raises:
        InputError: It is neither "command" nor "measured".
    """
    if text == "command":
        return "command"
    if text == "measured":
        return "measured"
    raise unknown_name("source of the torque", text, ("command", "measured"), "--torque")


NetworkOption = Annotated[
    bool,
    typer.Option("--network", help="Let nodes on other machines take part; default: sockets are bound to 127.0.0.1."),
]
"""Exposes a run to the network."""


def warn_of_network(network: bool) -> None:
    """Print a warning where a run is exposed to the network."""
    if network:
        text = "flexros: --network: any host that can reach this machine can subscribe to and command these nodes"
        typer.echo(text, err=True)


def checked_limit(seconds: float | None) -> float | None:
    """Check a time limit of the command line [s]; None is no limit.

    Raises:
        InputError: It is not above zero and finite.
    """
    if seconds is not None and not 0 < seconds < float("inf"):
        raise InputError(f"the time limit is {seconds:g} s, but must be above 0 s and finite", "time_limit")
    return seconds


def names_in(text: str) -> tuple[str, ...]:
    """Split names that are separated by commas."""
    return tuple(name for name in (part.strip() for part in text.split(",")) if name)


def parse_tolerance(text: str) -> dict[str, float]:
    """Parse relative tolerances of the command line.

    Args:
        text: KIND=SHARE,..., e.g. "stiffness=0.03,damping=0.3"; empty for those of the robot file.

    Returns:
        One standard deviation by kind, relative to the value [1].

    Raises:
        InputError: Wrong form, unknown kind, or a share that is not from 0 to below 1.
    """
    from flexros.gap.candidates.tolerance import KINDS

    tolerances: dict[str, float] = {}
    for part in (part.strip() for part in text.split(",") if part.strip()):
        kind, is_pair, value = part.partition("=")
        if not is_pair:
            raise InputError(f"--tolerance is '{text}', but must be KIND=SHARE,..., for instance stiffness=0.03")
        if kind not in KINDS:
            raise unknown_name("kind", kind, KINDS, "--tolerance")
        if kind in tolerances:
            raise InputError(f"--tolerance gives {kind} twice; remove one of them")
        try:
            tolerances[kind] = float(value)
        except ValueError:
            raise InputError(
                f"--tolerance gives {kind} as '{value}', but a relative deviation such as 0.03 is asked"
            ) from None
        if not 0 <= tolerances[kind] < 1:
            raise InputError(f"--tolerance gives {kind} as {value}, allowed are relative deviations from 0 to below 1")
    return tolerances
