"""Launch files: they cannot run without a full ROS 2, so their text is checked against the package."""

from __future__ import annotations

import ast
import runpy
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from flexros_nodes.parameters import node_parameters
from flexros_nodes.run_plan import NODES

FOLDER = Path(__file__).parents[2] / "nodes"
ARGUMENTS = ["scenario", "folder", "real_time", "begin_at_once", "namespace"]
FILES = sorted((FOLDER / "launch").glob("*.launch.py"))


def constants(tree: ast.Module) -> dict[str, object]:
    found = {}
    for statement in tree.body:
        if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
            try:
                found[statement.targets[0].id] = ast.literal_eval(statement.value)
            except ValueError:
                continue
    return found


def test_there_is_a_launch_file() -> None:
    assert [path.name for path in FILES] == ["closed_loop.launch.py"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_launch_file_names_nodes_and_parameters_that_exist(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"), str(path))
    compile(tree, str(path), "exec")
    functions = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert "generate_launch_description" in functions
    own, arguments = constants(tree)["OWN_PARAMETERS"], constants(tree)["ARGUMENTS"]
    assert isinstance(own, dict)
    assert isinstance(arguments, dict)
    assert tuple(own) == NODES
    for node, parameters in own.items():
        assert (FOLDER / f"{node}.py").is_file()
        for parameter in (*parameters, "scenario"):
            assert parameter in node_parameters(node)
            assert parameter in arguments


class Recorded:
    """Stands for any class of launch: keeps what it was made with."""

    def __init__(self, *arguments: Any, **named: Any) -> None:
        self.arguments, self.named = arguments, named

    def perform(self, context: dict[str, str]) -> str:
        return context[self.arguments[0]]


@pytest.fixture
def launch_stubs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put stand-ins in the place of launch and launch_ros."""
    classes = {
        "launch": ("LaunchContext", "LaunchDescription"),
        "launch.actions": ("DeclareLaunchArgument", "OpaqueFunction", "Shutdown"),
        "launch.substitutions": ("LaunchConfiguration",),
        "launch_ros": (),
        "launch_ros.actions": ("Node",),
        "launch_ros.parameter_descriptions": ("ParameterValue",),
    }
    for name, members in classes.items():
        module = ModuleType(name)
        for member in members:
            setattr(module, member, type(member, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)


@pytest.mark.usefixtures("launch_stubs")
def test_launch_starts_the_node_that_leads_the_scenario(identification_scenario: Path) -> None:
    description = runpy.run_path(str(FILES[0]))["generate_launch_description"]()
    *arguments, function = description.arguments[0]
    assert [argument.arguments[0] for argument in arguments] == ARGUMENTS
    for scenario, leader in (("circle_pd", "feedforward"), (str(identification_scenario), "identification")):
        nodes = function.named["function"]({"scenario": scenario})
        assert [node.named["executable"] for node in nodes] == ["recorder", leader, "controller", "plant"]
        assert [node.named["on_exit"] is not None for node in nodes] == [False, False, False, True]
    assert list(nodes[1].named["parameters"][0]) == ["scenario", "begin_at_once"]
