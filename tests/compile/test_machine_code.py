from __future__ import annotations

import casadi as ca
import pytest

from flexros.compile import compile_function, machine_code
from flexros.errors import InputError


def test_missing_compiler_is_explained(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_code, "find_spec", lambda name: None)
    x = ca.SX.sym("x")
    with pytest.raises(InputError, match="pip install llvmlite"):
        compile_function(ca.Function("f", [x], [x]))
