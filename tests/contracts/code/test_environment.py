"""Source of rclpy, and the message for an unsupported Python."""

from __future__ import annotations

import subprocess
from pathlib import Path
from types import ModuleType

import pytest

from tests.program import CHECKOUT, program


@pytest.fixture(scope="module")
def environment() -> ModuleType:
    """Load environment.py, which is no part of a package."""
    return program("environment.py")


@pytest.mark.parametrize(
    ("variables", "rclpy", "system", "machine", "libc", "source"),
    [
        ({"ROS_DISTRO": "jazzy"}, True, "Linux", "x86_64", "glibc 2.39", "sourced"),
        ({"ROS_DISTRO": "jazzy"}, True, "Linux", "aarch64", "glibc 2.39", "sourced"),
        ({"ROS_DISTRO": "jazzy"}, False, "Linux", "x86_64", "glibc 2.39", "wheels"),
        ({"ROS_DISTRO": "humble"}, True, "Linux", "x86_64", "glibc 2.35", "wheels"),
        ({}, False, "Linux", "x86_64", "glibc 2.28", "wheels"),
        ({}, False, "Linux", "x86_64", "glibc 2.17", "none"),
        ({}, False, "Linux", "x86_64", " ", "none"),
        ({}, False, "Linux", "aarch64", "glibc 2.39", "none"),
        ({}, False, "Darwin", "arm64", " ", "none"),
    ],
)
def test_ros_source(
    environment: ModuleType, variables: dict[str, str], rclpy: bool, system: str, machine: str, libc: str, source: str
) -> None:
    assert environment.ros_source(variables, rclpy, system, machine, libc).source == source


def test_missing_wheels_are_explained(environment: ModuleType) -> None:
    reason = environment.ros_source({}, False, "Darwin", "arm64", " ").reason
    assert reason == "there are ROS 2 wheels for Linux x86_64 with glibc 2.28 or newer, not for Darwin arm64"


def test_a_changed_setup_asks_for_a_new_installation(
    environment: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name in ("setup.py", "setup.cfg", "pyproject.toml"):
        (tmp_path / name).write_text("before", encoding="utf-8")
    monkeypatch.setattr(environment, "CHECKOUT", tmp_path)
    before = environment.wanted(set(), environment.Ros("wheels", ""))
    assert environment.wanted(set(), environment.Ros("wheels", "")) == before
    (tmp_path / "setup.py").write_text("after", encoding="utf-8")
    assert environment.wanted(set(), environment.Ros("wheels", "")) != before


def test_an_unfinished_installation_counts_as_none(
    environment: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "unfinished").touch()
    (tmp_path / "stamp").write_text('{"python": "3"}', encoding="utf-8")
    monkeypatch.setattr(environment, "UNFINISHED", tmp_path / "unfinished")
    monkeypatch.setattr(environment, "STAMP", tmp_path / "stamp")
    assert environment.installed() == {}


def make_python(python: Path) -> tuple[int, str]:
    """Let make check a Python, giving exit code and first line of what the user reads."""
    command = ["make", "python", f"PYTHON={python}"]
    run = subprocess.run(command, cwd=CHECKOUT, capture_output=True, text=True, check=False)
    return run.returncode, run.stderr.splitlines()[0]


def sentence(python: Path, found: str) -> str:
    return f"FlexROS needs Python 3.10 to 3.13, '{python}' is {found}; give another one: make PYTHON=python3.12 ..."


def test_a_missing_python_gets_one_sentence(tmp_path: Path) -> None:
    missing = tmp_path / "python3"
    assert make_python(missing) == (2, sentence(missing, "missing"))


def test_an_unsuitable_python_gets_one_sentence(tmp_path: Path) -> None:
    old = tmp_path / "python3.8"
    old.write_text('#!/bin/sh\n[ "$1" = --version ] && echo "Python 3.8.18" && exit\nexit 1\n', encoding="utf-8")
    old.chmod(0o755)
    assert make_python(old) == (2, sentence(old, "Python 3.8.18"))
