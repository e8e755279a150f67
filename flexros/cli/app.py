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
from typer.core import TyperGroup
from typer.models import ArgumentInfo, OptionInfo

from flexros.cli.commands import (
    analyze,
    benchmark,
    compare,
    demo,
    diagnose,
    exchange,
    fastest,
    gap,
    import_log,
    installation,
    learn,
    monitor,
    replay,
    robots,
    run,
    view,
)
from flexros.cli.commands.design import command as design
from flexros.cli.commands.identify import procedure as identify
from flexros.cli.completion import COMPLETED
from flexros.cli.guide import JOBS, examples_text, guide_of
from flexros.cli.output import suggest
from flexros.errors import INTERNAL_ERROR, INTERRUPTED, FlexrosError, InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

GAP_FOUND = 1
"""Exit code of a command that found a gap, an alarm or a broken installation: it has done its work."""

BROKEN_PIPE = 141
"""Exit code after a broken pipe, as of a program that SIGPIPE ends."""

EXIT_CODES = (
    "Exit codes: 0 done, 1 a gap was found, 2 bad input, 3 run aborted (the log is valid up to that point), "
    "70 internal error (traceback printed), 130 Ctrl-C, 141 broken pipe."
)

GROUP = "flexros.commands"
"""Entry points of further commands: modules with `COMMANDS`, and with a `HELP` text for a group."""

FIRST_STEPS = """\b
Examples:
  flexros demo                                     # everything once, in 3 minutes
  flexros run circle_dae --out circle              # simulate and record
  flexros analyze circle --report circle.html      # path error, tracking, timing
  flexros diagnose LOG --model ROBOT --out found   # why robot and model differ
"""


class JobGroup(TyperGroup):
    """A group whose help lists its commands by job, as plain text that needs no colours and no wide terminal."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each job with its commands."""
        shown = {name: command for name in self.list_commands(ctx) if (command := self.get_command(ctx, name))}
        width = max(map(len, shown), default=0)
        by_job: dict[str, list[tuple[str, str]]] = {}
        for name, command in shown.items():
            job = getattr(command, "rich_help_panel", None)
            job = job if isinstance(job, str) else "Commands"
            text = command.get_short_help_str(formatter.width - width - 6)
            by_job.setdefault(job, []).append((name.ljust(width), text))
        for job in (*JOBS, *(other for other in by_job if other not in JOBS)):
            if job in by_job:
                with formatter.section(job):
                    formatter.write_dl(by_job[job])


app = typer.Typer(
    name="flexros",
    cls=JobGroup,
    epilog=f"{FIRST_STEPS}\n{EXIT_CODES}",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def reported(
    command: Callable[..., Any], then: Callable[[Mapping[str, Any], int], str] | None = None
) -> Callable[..., None]:
    """Wrap a command such that it ends with an exit code and reports errors in one sentence on stderr.

    Args:
        command: The command; its return value is the exit code, None counts as 0.
        then: Gives what to do next from its arguments and exit code; printed on stderr, not beside JSON.

    Returns:
        The wrapped command, which ends with one of the `EXIT_CODES`.
    """

    @functools.wraps(command)
    def wrapped(*args: Any, **kwargs: Any) -> None:
        try:
            code = command(*args, **kwargs) or 0
            sys.stdout.flush()
            if then is not None and code in (0, GAP_FOUND):
                suggest(then(kwargs, code), unless=bool(kwargs.get("as_json")))
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
    "import-urdf": exchange.import_urdf,
    "import-mjcf": exchange.import_mjcf,
    "export": exchange.export,
    "scenarios": run.scenarios,
    "run": run.run,
    "learn": learn.learn,
    "fastest": fastest.fastest,
    "replay": replay.replay,
    "analyze": analyze.analyze,
    "benchmark": benchmark.benchmark,
    "design": design.design,
    "diagnose": diagnose.diagnose,
    "compare": compare.compare,
    "gap": gap.gap,
    "monitor": monitor.monitor,
    "view": view.view,
    "demo": demo.demo,
    "doctor": installation.doctor,
    "clean": installation.clean,
}


def _add(name: str, commands: Mapping[str, Callable[..., Any]], help_text: str = "") -> None:
    """Add commands to the application, or with a help text to a group of their own."""
    into = app
    if help_text:
        into = typer.Typer(name=name, cls=JobGroup, help=help_text, no_args_is_help=True, rich_markup_mode=None)
    for word, command in commands.items():
        guide = guide_of(f"{name} {word}".strip() if help_text else word, command.__doc__ or "")
        _complete(command, f"{name} {word}" if help_text else word)
        into.command(
            word,
            short_help=guide.short,
            epilog=examples_text(guide),
            rich_help_panel="Commands" if help_text else guide.job,
        )(reported(command, guide.then))
    if help_text:
        group = guide_of(name, help_text)
        app.add_typer(into, short_help=group.short, rich_help_panel=group.job)


def _complete(command: Callable[..., Any], name_of_command: str) -> None:
    """Let shells complete built-in names in the options and arguments of a command."""
    hints = get_type_hints(command, include_extras=True)
    for name, parameter in inspect.signature(command).parameters.items():
        completed = COMPLETED.get(f"{name_of_command} {name}") or COMPLETED.get(name)
        for each in (parameter.default, *getattr(hints.get(name), "__metadata__", ())):
            if completed and isinstance(each, (OptionInfo, ArgumentInfo)):
                each.autocompletion = completed


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
