"""Ctrl-C at any time."""

from __future__ import annotations

import contextlib
import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

Flexros = Callable[..., "object"]


def test_interrupt_during_a_command(flexros: Flexros, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("flexros.robot.robot_names", interrupted)
    ended = flexros("robots")
    assert ended.code == 130
    assert "interrupted by Ctrl-C" in ended.err


def test_interrupt_that_foreign_code_swallows(flexros: Flexros, monkeypatch: pytest.MonkeyPatch) -> None:
    def swallowed() -> tuple[str, ...]:
        with contextlib.suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        return ()

    monkeypatch.setattr("flexros.robot.robot_names", swallowed)
    assert flexros("robots").code == 130


def test_handler_is_given_back(flexros: Flexros) -> None:
    before = signal.getsignal(signal.SIGINT)
    flexros("robots", "--json")
    assert signal.getsignal(signal.SIGINT) is before


def test_interrupted_direct_run_leaves_no_log(
    flexros: Flexros, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("flexros.scenario.closed_loop.closed_loop", interrupted)
    ended = flexros("run", "circle_pd", "--transport", "direct", "--out", str(tmp_path / "bag"))
    assert ended.code == 130
    assert not (tmp_path / "bag").exists()
