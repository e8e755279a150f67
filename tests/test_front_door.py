"""`import flexros`: fast, complete, and free of names that a room would hide."""

from __future__ import annotations

import ast
import inspect
import subprocess
import sys
from pathlib import Path

import pytest

import flexros

SOURCE = Path(flexros.__file__)
HEAVY = ("numpy", "casadi", "plotly", "pandas", "xarray", "control", "scipy", "pydantic")


def test_import_loads_nothing_heavy() -> None:
    program = f"import sys, flexros; print([name for name in {HEAVY} if name in sys.modules])"
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_nodes_of_a_run_do_not_wait_for_what_they_do_not_use() -> None:
    """Each of the four starts its own Python: SciPy alone is a third of what they import."""
    pytest.importorskip("rclpy", reason="needs ROS 2")
    program = (
        "import sys, flexros_nodes.plant.__main__, flexros_nodes.controller.__main__, flexros_nodes.recorder\n"
        "import flexros_nodes.feedforward\n"
        "from flexros.control.base import control_laws\n"
        "control_laws()\n"
        f"print([name for name in {HEAVY} if name in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "['numpy', 'casadi', 'pydantic']"


@pytest.mark.parametrize("name", flexros.__all__)
def test_each_name_is_loaded_and_described(name: str) -> None:
    value = getattr(flexros, name)
    assert name in dir(flexros)
    assert inspect.getdoc(value)
    assert value.__name__ == name


def test_no_name_is_that_of_a_room() -> None:
    """Importing `flexros.benchmark` would put the module in the place of a function of that name."""
    taken = {path.stem for path in SOURCE.parent.iterdir()}
    assert set(flexros.__all__) & taken == set()


def test_editors_see_the_same_names() -> None:
    tree = ast.parse(SOURCE.read_text(encoding="utf-8"))
    block = next(node for node in tree.body if isinstance(node, ast.If))
    typed = {alias.name: node.module for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert typed == {name: f"flexros.{flexros._WHERE[name]}" for name in flexros.__all__}


def test_an_unknown_name_lists_what_there_is() -> None:
    with pytest.raises(AttributeError, match="load_robot"):
        _ = flexros.load_robots  # type: ignore[attr-defined]
