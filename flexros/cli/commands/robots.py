"""Commands about robots: list, modes and zeros at a pose, Bode picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import typer
from rich.table import Table

from flexros.atomic_file import write_result
from flexros.cli.model import ROBOT, linear_robot
from flexros.cli.output import console, print_json, say
from flexros.cli.progress import working
from flexros.errors import InputError, unknown_name

if TYPE_CHECKING:
    from flexros.arrays import ComplexArray
    from flexros.robot import Robot
    from flexros.robot.linear.linearise import LinearModel
    from flexros.robot.linear.zeros import ZeroDynamics

_FEW_MOTORS = 2
"""With more motors than this the table has the zeros of each motor's own channel only (chosen)."""


def robots(as_json: bool = typer.Option(False, "--json", help="Print JSON.")) -> None:
    """List the built-in robots."""
    from flexros.robot import load_robot, robot_names

    loaded = [load_robot(name) for name in robot_names()]
    if as_json:
        print_json(
            [
                {"name": r.name, "arm_dof": r.n_arm, "motors": r.n_motors, "description": r.spec.description}
                for r in loaded
            ]
        )
        return
    table = Table("robot", "arm DOF", "motors", "description")
    for r in loaded:
        table.add_row(r.name, str(r.n_arm), str(r.n_motors), r.spec.description)
    console.print(table)


def robot(
    name: str = typer.Argument(help=ROBOT),
    q: str = typer.Option("", "--q", help="Arm coordinates of the pose [rad or m], e.g. 0,0.3,0; default: home."),
    output: str = typer.Option("", "--output", help="Controlled output; default: that of the robot file."),
    bode: Path = typer.Option(None, "--bode", help="Write a Bode picture to this HTML file."),
    urdf: Path = typer.Option(None, "--urdf", help="Write the robot to this URDF file."),
    flexible: str = typer.Option("fixed", "--flexible", help="Springs in the URDF: fixed, or continuous for joints."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Compute modes, zeros and zero dynamics of a robot at a pose, with the minimum-phase verdict."""
    from flexros.robot.linear.linearise import linear_model
    from flexros.robot.linear.zeros import channel_zeros, poles, transmission_zeros, zero_dynamics

    loaded = linear_robot(name)
    if urdf:
        _write_urdf(loaded, urdf, flexible)
    pose = np.array(loaded.home) if not q else parse_numbers(q, "--q")
    with working("modes and zeros"):
        linear = linear_model(loaded, pose, output or None)
        verdict = zero_dynamics(loaded, pose, output or None)
        zeros = {
            source: {target: channel_zeros(linear, column, row) for row, target in enumerate(linear.measurement_names)}
            for column, source in enumerate(linear.input_names)
        }
    if bode:
        from flexros.robot.linear.bode import write_bode

        write_bode(linear, bode, f"{loaded.name} at q = {pose.tolist()}")
    content = {
        "robot": loaded.name,
        "q": pose.tolist(),
        "output": verdict.output,
        "poles": _entries(poles(linear)),
        "zeros": {source: {target: _entries(z) for target, z in row.items()} for source, row in zeros.items()},
        "transmission_zeros": _entries(transmission_zeros(linear)),
        "zero_dynamics": _entries(verdict.eigenvalues),
        "minimum_phase": verdict.minimum_phase,
    }
    if as_json:
        print_json(content)
        return
    _print_robot(content, linear, verdict)
    if bode:
        say(f"Bode picture: {bode}")
    if urdf:
        say(f"URDF: {urdf}")


def _write_urdf(robot: Robot, file: Path, flexible: str) -> None:
    from flexros.robot.exchange.urdf.export import FLEXIBLE, urdf_text

    kinds = {kind: kind for kind in FLEXIBLE}
    if flexible not in kinds:
        raise unknown_name("way to write springs", flexible, kinds, "--flexible")
    write_result(file, urdf_text(robot, kinds[flexible]), "URDF")


def parse_numbers(text: str, option: str) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Parse comma-separated numbers of an option.

    Args:
        text: Value of the option.
        option: Name of the option, for the error text.

    Returns:
        The numbers, shape (n,).

    Raises:
        InputError: Something is not a number.
    """
    try:
        return np.array([float(part) for part in text.split(",")])
    except ValueError as error:
        raise InputError(f"{option} is '{text}', but must be numbers separated by commas, e.g. 0,0.3,0") from error


def _entries(values: ComplexArray) -> list[dict[str, float]]:
    return [
        {"re": float(value.real), "im": float(value.imag), "hz": float(abs(value) / (2 * np.pi))} for value in values
    ]


def _print_robot(content: dict[str, Any], linear: LinearModel, verdict: ZeroDynamics) -> None:
    console.print(f"{content['robot']} at rest, q = {np.round(verdict.pose, 6).tolist()}")
    table = Table("", "frequency [Hz] (damping ratio); real: [1/s]")
    table.add_row("poles", _readable(content["poles"]))
    hidden = 0
    for source in linear.input_names:
        for target, entries in content["zeros"][source].items():
            if target == source or len(linear.input_names) <= _FEW_MOTORS:
                table.add_row(f"zeros {source} torque -> {target}", _readable(entries))
            else:
                hidden += 1
    table.add_row(f"zeros torques -> {verdict.output}", _readable(content["transmission_zeros"]))
    table.add_row(f"zero dynamics of {verdict.output}", _readable(content["zero_dynamics"]))
    console.print(table)
    if hidden:
        say(f"Zeros from motors to other locations, {hidden} channels: --json")
    if verdict.minimum_phase:
        console.print(f"Minimum phase for output '{verdict.output}': causal feedforward exists.")
    elif not verdict.solvable:
        console.print(f"The motors cannot set output '{verdict.output}' independently at this pose (singular).")
    else:
        worst = verdict.unstable[np.argmax(verdict.unstable.real)]
        console.print(
            f"NOT minimum phase for output '{verdict.output}': {verdict.unstable.size} unstable zeros, the fastest at "
            f"{worst.real:.4g} {worst.imag:+.4g}i 1/s; causal feedforward diverges."
        )


def _readable(entries: list[dict[str, float]]) -> str:
    """Write eigenvalues once per pair, with damping ratio."""
    words = []
    for entry in entries:
        size = 2 * np.pi * entry["hz"]
        if size < 1e-3:
            words.append("0")
        elif abs(entry["im"]) < 1e-6 * size:
            words.append(f"real {entry['re']:.5g}")
        elif entry["im"] > 0:
            words.append(f"{entry['hz']:.5f} ({-entry['re'] / size:.3f})")
    return ", ".join(words) or "none"
