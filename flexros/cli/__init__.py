"""The `flexros` command."""

from __future__ import annotations

import signal
import sys
import threading
from typing import NoReturn

from flexros.errors import INTERRUPTED


def main(arguments: list[str] | None = None) -> NoReturn:
    """Run the command line.

    Ctrl-C ends it with code 130 at any time: also while modules are loaded, and when foreign code has swallowed the
    exception.

    Args:
        arguments: Arguments after the command's name; default: those of the process.

    Raises:
        SystemExit: Always; `flexros.cli.app.reported` lists the codes.
    """
    signals: list[int] = []

    def interrupt(number: int, _frame: object) -> NoReturn:
        signals.append(number)
        raise KeyboardInterrupt

    in_main_thread = threading.current_thread() is threading.main_thread()
    before = signal.signal(signal.SIGINT, interrupt) if in_main_thread else None
    code: int | str | None = 0
    try:
        from flexros.cli.app import app

        app(args=arguments)
    except SystemExit as end:
        code = end.code
    except KeyboardInterrupt:
        code = 0
    finally:
        if in_main_thread:
            signal.signal(signal.SIGINT, before)
    if signals and not code:
        print("flexros: interrupted by Ctrl-C", file=sys.stderr)
        code = INTERRUPTED
    raise SystemExit(code)
