"""Command that plays a log over ROS 2 topics."""

from __future__ import annotations

import math
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from rich.table import Table

from flexros.cli.options import NetworkOption, warn_of_network
from flexros.cli.output import console, print_json
from flexros.cli.progress import progress_bar
from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

GROUP = "flexros.replay"
"""Entry points that play a log; the package of the nodes registers "ros"."""

FIGURES = {
    "messages": "messages",
    "turns": "times to the end",
    "latest_ms": "longest delay of a message, ms",
    "equal_commands": "commands equal to the recorded ones",
    "different_commands": "commands that differ",
    "commands_without_record": "commands where none was recorded",
    "measurements_repeated": "measurements sent again",
}
"""Name in words of each figure of a replay, by its key in the JSON output."""


def replay(
    bag: Path = typer.Argument(help="Log: a rosbag2 folder, an .mcap or a .db3 file, of any recorder."),
    rate: float = typer.Option(
        1.0, "--rate", help="Times as fast as recorded, 0.001 to 1000 [1]; inf: without pauses."
    ),
    loop: bool = typer.Option(False, "--loop", help="Begin again at the end; stamps and /clock then jump back."),
    paused: bool = typer.Option(False, "--paused", help="Wait for the service ~/resume before the first message."),
    from_time: float = typer.Option(0.0, "--from", help="Where to begin, after the beginning of the log [s]."),
    to_time: float = typer.Option(None, "--to", help="Where to end, after the beginning of the log [s]."),
    topic: list[str] = typer.Option([], "--topic", help="Play only this topic (may be repeated)."),
    remap: list[str] = typer.Option([], "--remap", help="Play a topic under another name, old:=new (may be repeated)."),
    clock: float = typer.Option(0.0, "--clock", help="Messages on /clock per second of the log [Hz]; 0: none."),
    feed_controller: bool = typer.Option(
        False,
        "--feed-controller",
        help="Feed a controller node: joint_reference goes ahead on joint_reference_ahead, each measurement waits for "
        "its command, and the commands are compared with the recorded ones.",
    ),
    network: NetworkOption = False,
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> int:
    """Play a log over ROS 2 topics, in the order of log time; messages and their stamps are as recorded."""
    values: dict[str, Any] = {
        "bag": str(bag),
        "loop": loop,
        "paused": paused,
        "from_time": from_time,
        "topics": ",".join(topic),
        "remaps": ",".join(remap),
        "clock_rate": clock,
        "feed_controller": feed_controller,
        **({"as_fast_as_possible": True} if rate == math.inf else {"rate": rate}),
        **({} if to_time is None else {"to_time": to_time}),
    }
    play = player()
    warn_of_network(network)
    with progress_bar(not loop) as progress:
        task = progress.add_task("playing", total=None)
        summary = play(values, lambda done, total: progress.update(task, completed=done, total=total), network=network)
    for warning in summary.warnings:
        typer.echo(f"flexros: {warning}", err=True)
    if as_json:
        content = {"exit_code": summary.exit_code, "message": summary.message, **summary.figures}
        print_json({**content, "warnings": list(summary.warnings)})
    else:
        _print(bag, summary.figures)
    if summary.exit_code:
        typer.echo(f"flexros: {summary.message}", err=True)
    return int(summary.exit_code)


def player() -> Callable[..., Any]:
    """Load the function that plays a log.

    Returns:
        The function of the nodes' package.

    Raises:
        InputError: The nodes are not installed.
    """
    entries = [entry for entry in metadata.entry_points(group=GROUP) if entry.name == "ros"]
    why = "the ROS 2 nodes of FlexROS are not installed"
    if entries and find_spec("rclpy") is None:
        why = "no rclpy can be imported here (source ROS 2 Jazzy, or install the extra 'ros' on Linux x86_64)"
    elif entries:
        try:
            play: Callable[..., Any] = entries[0].load()
        except ImportError as error:
            why = f"the ROS 2 nodes cannot be loaded ({error})"
        else:
            return play
    raise InputError(f"a log is played over ROS 2 topics, but {why}; analyse it with 'flexros analyze'")


def _print(bag: Path, figures: dict[str, float]) -> None:
    table = Table(title=f"replay of {bag}", show_header=False)
    for key, value in figures.items():
        table.add_row(FIGURES.get(key, key.removesuffix(".messages")), f"{value:.6g}")
    console.print(table)
