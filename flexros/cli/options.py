"""Options that several commands have, and what is read from them."""

from __future__ import annotations

from typing import Annotated

import typer

from flexros.errors import InputError, unknown_name

NamespaceOption = Annotated[str, typer.Option("--namespace", help="Namespace of the topics, when a log holds several.")]
"""The robot of a log of several."""
KnownModelOption = Annotated[
    str, typer.Option("--model", help="Robot as it is thought to be: shipped name, YAML or patch.yaml.")
]
"""A robot, with the effects that are known of it."""
ToleranceOption = Annotated[
    str,
    typer.Option("--tolerance", help="Relative tolerances of the model, e.g. stiffness=0.03,inertia=0.03,damping=0.3."),
]
"""How well the numbers of a robot are known, see `parse_tolerance`."""

NetworkOption = Annotated[
    bool, typer.Option("--network", help="Let nodes on other machines take part; else sockets are bound to 127.0.0.1.")
]
"""Whether a run is heard on the network."""


def warn_of_network(network: bool) -> None:
    """Say that a run goes on the network, where it does.

    Args:
        network: Whether it does.
    """
    if network:
        text = "flexros: --network: whoever is in reach of this machine can hear and command the nodes of this run"
        typer.echo(text, err=True)


def parse_tolerance(text: str) -> dict[str, float]:
    """Read relative tolerances as written on the command line.

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
