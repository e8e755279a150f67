"""Running the command line in the process of the test."""

from __future__ import annotations

import importlib
import json
import os
import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pytest
from pydantic import TypeAdapter

from flexros.cli import main
from flexros.cli.json_output import OUTPUTS

# The console keeps for good a width that is set when it is made; made without one it asks each time, as tests need it.
os.environ.pop("COLUMNS", None)
importlib.import_module("flexros.cli.output")


@dataclass(frozen=True)
class Ended:
    """Result of a command."""

    code: int
    out: str
    err: str

    @property
    def told(self) -> list[str]:
        """Lines on standard error but for those of progress, which come on a slow machine."""
        return [line for line in self.err.splitlines() if not re.match(r"flexros: \d+ s: ", line)]


def check_output(arguments: tuple[str, ...], text: str) -> Any:
    """Compare the JSON of a command with its description: every key, and no other. Returns it."""
    content = json.loads(text)
    words = next((" ".join(arguments[:n]) for n in (2, 1) if " ".join(arguments[:n]) in OUTPUTS), None)
    if words is not None:
        TypeAdapter(OUTPUTS[words]).validate_python(content)
    return content


@pytest.fixture
def flexros(capfd: pytest.CaptureFixture[str]) -> Callable[..., Ended]:
    """Return a function that runs `flexros` with arguments; what it prints as JSON must be as described."""

    def run(*arguments: str) -> Ended:
        with pytest.raises(SystemExit) as caught:
            main(list(arguments))
        out, err = capfd.readouterr()
        ended = Ended(int(caught.value.code or 0), out, err)
        if "--json" in arguments and ended.code in (0, 1):
            check_output(arguments, out)
        return ended

    return run
