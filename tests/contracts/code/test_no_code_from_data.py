"""Nothing that is read from others becomes code, a command for a shell, or an object of their choice."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).parents[3]
MODULES = [path for room in ("flexros", "nodes", "msgs_config") for path in sorted((CHECKOUT / room).rglob("*.py"))] + [
    CHECKOUT / "environment.py",
    CHECKOUT / "setup.py",
]

FORBIDDEN_CALLS = {
    *(
        "eval",
        "exec",
        "compile",
        "__import__",
        "os.system",
        "os.popen",
        "os.execvp",
        "os.spawnlp",
        "subprocess.getoutput",
    ),
    *("subprocess.getstatusoutput", "asyncio.create_subprocess_shell", "code.interact", "numpy.fromstring"),
    *("tempfile.mktemp", "shutil.unpack_archive", "tarfile.open", "logging.config.listen"),
}
"""Calls that run what they are given, in the names that a module gives them."""
FORBIDDEN_MODULES = {
    "pickle",
    "cPickle",
    "_pickle",
    "dill",
    "cloudpickle",
    "joblib",
    "shelve",
    "marshal",
    "yaml",
    "jsonpickle",
}
"""Modules whose reading makes objects of any class; YAML is read by ruamel.yaml."""


def names_of(tree: ast.Module) -> dict[str, str]:
    """Full name behind each imported name of a module."""
    full = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            full |= {
                alias.asname or alias.name.split(".")[0]: alias.name if alias.asname else alias.name.split(".")[0]
                for alias in node.names
            }
        elif isinstance(node, ast.ImportFrom) and node.module:
            full |= {alias.asname or alias.name: f"{node.module}.{alias.name}" for alias in node.names}
    return full


def full_name(node: ast.expr, names: dict[str, str]) -> str:
    """Name of what is called, "numpy.load" for np.load; empty if it has none."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    if not isinstance(node, ast.Name):
        return ""
    return ".".join([names.get(node.id, node.id), *reversed(parts)])


def keyword(call: ast.Call, name: str) -> ast.expr | None:
    return next((given.value for given in call.keywords if given.arg == name), None)


def offences(text: str) -> Iterator[str]:
    """Forbidden calls of a module, with their lines."""
    tree = ast.parse(text)
    names = names_of(tree)
    for name in {full.split(".")[0] for full in names.values()} & FORBIDDEN_MODULES:
        yield f"imports {name}"
    for call in (node for node in ast.walk(tree) if isinstance(node, ast.Call)):
        name, place = full_name(call.func, names), f"line {call.lineno}"
        if name in FORBIDDEN_CALLS:
            yield f"{place}: calls {name}"
        shell = keyword(call, "shell")
        if shell is not None and not (isinstance(shell, ast.Constant) and shell.value is False):
            yield f"{place}: gives a command to a shell"
        pickled = keyword(call, "allow_pickle")
        if pickled is not None and not (isinstance(pickled, ast.Constant) and pickled.value is False):
            yield f"{place}: allows pickled objects"
        if name in ("numpy.load", "numpy.lib.format.read_array") and pickled is None:
            yield f"{place}: {name} without allow_pickle=False"
        if name == "ruamel.yaml.YAML" and call.keywords and not _is_safe(call):
            yield f"{place}: YAML of type {ast.unparse(call)}"


def _is_safe(call: ast.Call) -> bool:
    kind = keyword(call, "typ")
    return isinstance(kind, ast.Constant) and kind.value in ("safe", "rt")


@pytest.mark.slow
def test_no_module_makes_code_of_data() -> None:
    found = {str(path.relative_to(CHECKOUT)): list(offences(path.read_text(encoding="utf-8"))) for path in MODULES}
    assert len(found) > 500
    assert {path: texts for path, texts in found.items() if texts} == {}


@pytest.mark.parametrize(
    ("text", "offence"),
    [
        ("import pickle", "imports pickle"),
        ("from cloudpickle import loads", "imports cloudpickle"),
        ("import yaml\nyaml.safe_load('')", "imports yaml"),
        ("eval('1')", "line 1: calls eval"),
        ("exec('1')", "line 1: calls exec"),
        ("import os\nos.system('x')", "line 2: calls os.system"),
        ("from os import system as s\ns('x')", "line 2: calls os.system"),
        ("import subprocess\nsubprocess.run('x', shell=True)", "line 2: gives a command to a shell"),
        ("import subprocess\nsubprocess.run('x', shell=wanted)", "line 2: gives a command to a shell"),
        ("import numpy as np\nnp.load('x')", "line 2: numpy.load without allow_pickle=False"),
        ("import numpy as np\nnp.load('x', allow_pickle=True)", "line 2: allows pickled objects"),
        ("from ruamel.yaml import YAML\nYAML(typ='unsafe')", "line 2: YAML of type YAML(typ='unsafe')"),
    ],
)
def test_offence_is_found(text: str, offence: str) -> None:
    assert list(offences(text)) == [offence]
