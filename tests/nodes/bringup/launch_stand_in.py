"""Stand-in for launch and launch_ros, which are on no package index: records the requests of a launch file.

Arguments are those that the documentation of ROS 2 Jazzy names; any other one is a TypeError, as it is there.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from types import ModuleType
from typing import Any

import pytest


@dataclass
class LaunchDescription:
    initial_entities: Iterable[Any] = ()


@dataclass
class LaunchContext:
    launch_configurations: dict[str, str] = field(default_factory=dict)


class Action:
    """Base of all actions."""


@dataclass
class DeclareLaunchArgument(Action):
    name: str
    default_value: str | None = field(default=None, kw_only=True)
    description: str | None = field(default=None, kw_only=True)
    choices: list[str] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        assert self.choices is None or self.default_value in self.choices


@dataclass(kw_only=True)
class OpaqueFunction(Action):
    function: Callable[..., list[Action] | None]
    args: Iterable[Any] | None = None
    kwargs: dict[str, Any] | None = None

    def execute(self, context: LaunchContext) -> list[Action]:
        return list(self.function(context, *(self.args or ()), **(self.kwargs or {})) or [])


@dataclass(kw_only=True)
class LogInfo(Action):
    msg: str


@dataclass(kw_only=True)
class Shutdown(Action):
    reason: str = "reason not given"


@dataclass(kw_only=True)
class OnShutdown:
    on_shutdown: Callable[[Any, LaunchContext], list[Action] | None]


@dataclass
class RegisterEventHandler(Action):
    event_handler: OnShutdown


@dataclass
class ParameterValue:
    value: bool | float | str
    value_type: type | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        assert type(self.value) is self.value_type


@dataclass(kw_only=True)
class Node(Action):
    executable: str
    package: str | None = None
    name: str | None = None
    namespace: str | None = None
    exec_name: str | None = None
    parameters: Iterable[dict[str, ParameterValue] | str] | None = None
    remappings: Iterable[tuple[str, str]] | None = None
    ros_arguments: Iterable[str] | None = None
    arguments: Iterable[str] | None = None
    output: str = "log"
    on_exit: list[Action] | None = None

    def own_parameters(self) -> dict[str, Any]:
        """Give the parameters that the launch file itself sets."""
        first, *_ = self.parameters or ({},)
        assert isinstance(first, dict)
        return {name: value.value for name, value in first.items()}

    def ended(self, context: LaunchContext) -> list[Action]:
        """Give what follows when the process of the node is over."""
        return [action for entry in self.on_exit or [] for action in entry.execute(context)]  # type: ignore[attr-defined]


MODULES = {
    "launch": (LaunchContext, LaunchDescription),
    "launch.action": (Action,),
    "launch.actions": (DeclareLaunchArgument, LogInfo, OpaqueFunction, RegisterEventHandler, Shutdown),
    "launch.event_handlers": (OnShutdown,),
    "launch_ros": (),
    "launch_ros.actions": (Node,),
    "launch_ros.parameter_descriptions": (ParameterValue,),
}


def put_in_place(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let imports of launch and launch_ros find the stand-ins until the test is over."""
    for name, members in MODULES.items():
        module = ModuleType(name)
        for member in members:
            setattr(module, member.__name__, member)
        monkeypatch.setitem(sys.modules, name, module)
