"""Programs of this repository that belong to no package, loaded for tests."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

CHECKOUT = Path(__file__).parents[1]
"""Folder of the repository."""


def program(path: str) -> ModuleType:
    """Load a program, which is no part of a package.

    Args:
        path: Its path in the repository, e.g. "docs/results/programs/simulated/mujoco_servos.py".
    """
    file = CHECKOUT / path
    specification = importlib.util.spec_from_file_location(file.stem, file)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[file.stem] = module  # where dataclasses look up their annotations
    specification.loader.exec_module(module)
    return module
