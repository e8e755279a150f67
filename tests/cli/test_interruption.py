"""Ctrl-C at any time."""

from __future__ import annotations

import contextlib
import os
import signal
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from flexros.cli.interruption import interruptible

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


def _interrupt_and_wait() -> None:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(5.0)


def test_the_first_interrupt_asks_for_the_end_and_the_second_is_one(capfd: pytest.CaptureFixture[str]) -> None:
    before = signal.default_int_handler  # a job in the background inherits an ignored signal
    signal.signal(signal.SIGINT, before)
    with interruptible("done soon") as asked:
        assert not asked()
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0.5)  # another thread may take the signal, and Python runs its handler in the main thread later
        assert asked()
        with pytest.raises(KeyboardInterrupt):
            _interrupt_and_wait()
    assert signal.getsignal(signal.SIGINT) is before
    out, err = capfd.readouterr()
    assert (out, err.count("done soon")) == ("", 1)


def test_work_that_is_not_interrupted_gives_the_handler_back() -> None:
    before = signal.getsignal(signal.SIGINT)
    with interruptible("done soon") as asked:
        assert signal.getsignal(signal.SIGINT) is not before
    assert not asked()
    assert signal.getsignal(signal.SIGINT) is before


def test_in_a_thread_nothing_is_handled() -> None:
    before = signal.getsignal(signal.SIGINT)

    def work() -> None:
        with interruptible("done soon") as asked:
            assert not asked()

    with ThreadPoolExecutor(1) as pool:
        pool.submit(work).result()
    assert signal.getsignal(signal.SIGINT) is before
