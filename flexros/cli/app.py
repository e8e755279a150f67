"""The command with its subcommands; errors become one sentence and an exit code."""

from __future__ import annotations

import functools
import inspect
import os
import sys
import traceback
from importlib import metadata
from typing import TYPE_CHECKING, Any, get_type_hints

import typer
from typer.models import OptionInfo

from flexros.cli import (
    analyze,
    benchmark,
    demo,
    design,
    diagnose,
    exchange,
    gap,
    import_log,
    learn,
    monitor,
    replay,
    robots,
    run,
)
from flexros.cli.identify import procedure as identify
from flexros.errors import INTERNAL_ERROR, INTERRUPTED, FlexrosError, InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

BROKEN_PIPE = 141
"""Exit code after a broken pipe, as of a program that SIGPIPE ends."""

EXIT_CODES = (
    "Exit codes: 0 done, 1 a gap was found, 2 bad input, 3 run aborted (the log is valid up to that point), "
    "70 internal error (traceback printed), 130 Ctrl-C, 141 broken pipe."
)

GROUP = "flexros.commands"
"""Entry points of further commands: modules with `COMMANDS`, and with a `HELP` text for a group."""

app = typer.Typer(
    name="flexros",
    epilog=EXIT_CODES,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def reported(command: Callable[..., Any]) -> Callable[..., None]:
    """Wrap a command such that it ends with an exit code and reports errors in one sentence on stderr.

    Args:
        command: The command; its return value is the exit code, None counts as 0.

    Returns:
        The wrapped command, which ends with one of the `EXIT_CODES`.
    """

    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> None:
        try:
            code = command(*args, **kwargs) or 0
            sys.stdout.flush()
        except FlexrosError as error:
            print(f"flexros: {_with_option(error, command)}", file=sys.stderr)
            code = error.exit_code
        except KeyboardInterrupt:
            print("flexros: interrupted by Ctrl-C", file=sys.stderr)
            code = INTERRUPTED
        except BrokenPipeError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # else Python complains when it ends
            code = BROKEN_PIPE
        except OSError as error:
            text = error.strerror or str(error)
            if error.filename:
                text = f"'{error.filename}': {text}; give a path that can be used"
            print(f"flexros: {text}", file=sys.stderr)
            code = InputError.exit_code
        except Exception:  # noqa: BLE001 - uncaught it would end with 1, which says "a gap was found"
            traceback.print_exc()
            print("flexros: internal error, please report it with the lines above", file=sys.stderr)
            code = INTERNAL_ERROR
        raise SystemExit(code)

    return wrapped


def _with_option(error: FlexrosError, command: Callable[..., Any]) -> str:
    """Put the option before an error of the library that names an argument of the command."""
    if not isinstance(error, InputError) or not error.argument:
        return str(error)
    parameter = inspect.signature(command).parameters.get(error.argument)
    if parameter is None:
        return str(error)
    hint = get_type_hints(command, include_extras=True).get(error.argument)
    declared = (parameter.default, *getattr(hint, "__metadata__", ()))
    # typer keeps the first name of an annotated option as its default
    names = [
        name for each in declared if isinstance(each, OptionInfo) for name in (*(each.param_decls or ()), each.default)
    ]
    option = next((name for name in names if str(name).startswith("--")), None)
    return f"{option}: {error}" if option else str(error)


COMMANDS: dict[str, Callable[..., Any]] = {
    "robots": robots.robots,
    "robot": robots.robot,
    "import": import_log.import_log,
    "import-urdf": robots.import_urdf,
    "import-mjcf": exchange.import_mjcf,
    "export": exchange.export,
    "scenarios": run.scenarios,
    "run": run.run,
    "learn": learn.learn,
    "replay": replay.replay,
    "analyze": analyze.analyze,
    "benchmark": benchmark.benchmark,
    "design": design.design,
    "diagnose": diagnose.diagnose,
    "gap": gap.gap,
    "monitor": monitor.monitor,
    "demo": demo.demo,
}


def _add(name: str, commands: Mapping[str, Callable[..., Any]], help_text: str = "") -> None:
    """Add commands to the application, or with a help text to a group of their own."""
    into = typer.Typer(name=name, help=help_text, no_args_is_help=True, rich_markup_mode=None) if help_text else app
    for word, command in commands.items():
        into.command(word)(reported(command))
    if help_text:
        app.add_typer(into)


_add("", COMMANDS)
_add("identify", identify.COMMANDS, identify.HELP)
for entry in sorted(metadata.entry_points(group=GROUP)):
    room = entry.load()
    _add(entry.name, room.COMMANDS, room.HELP)


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"flexros {metadata.version('flexros')}")
        raise typer.Exit


@app.callback()
def _options(
    version: bool = typer.Option(
        False, "--version", callback=_print_version, is_eager=True, help="Print the version and exit."
    ),
) -> None:
    """Modelling, control, identification and gap diagnosis of flexible robot manipulators."""
