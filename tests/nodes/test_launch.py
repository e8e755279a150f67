"""Launch files: they cannot run without a full ROS 2, so their text is checked against the package."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from flexros_nodes.parameters import node_parameters
from flexros_nodes.run_plan import NODES

FOLDER = Path(__file__).parents[2] / "nodes"
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
