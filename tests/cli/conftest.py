"""Running the command line in the process of the test."""

from __future__ import annotations

import importlib
import os
from collections.abc import Callable
from dataclasses import dataclass

import pytest

from flexros.cli import main

# The console keeps for good a width that is set when it is made; made without one it asks each time, as tests need it.
os.environ.pop("COLUMNS", None)
importlib.import_module("flexros.cli.output")


@dataclass(frozen=True)
class Ended:
    """Result of a command."""

    code: int
    out: str
    err: str


@pytest.fixture
def flexros(capfd: pytest.CaptureFixture[str]) -> Callable[..., Ended]:
    """Return a function that runs `flexros` with arguments."""

    def run(*arguments: str) -> Ended:
        with pytest.raises(SystemExit) as caught:
            main(list(arguments))
        out, err = capfd.readouterr()
        return Ended(int(caught.value.code or 0), out, err)

    return run
