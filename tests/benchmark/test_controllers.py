"""Controllers for the benchmark: built-in, from files of matrices, and in Python."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.benchmark.controllers import controller_names, load_controller
from flexros.control.pid import Pid
from flexros.control.state_space import StateSpace
from flexros.errors import InputError

LAW = """
from typing import ClassVar
import casadi
import numpy as np
from flexros.control.base import AbstractControlLaw

class Spring(AbstractControlLaw):
    kind: ClassVar[str] = "own_spring"
    stiffness: float = 3.0
    def state_size(self, context):
        return 0
    def gain_names(self, context):
        return ("stiffness",)
    def gains(self, context):
        return np.array([self.stiffness])
    def function(self, context):
        c, r = casadi.SX.sym("c", 0), casadi.SX.sym("r", context.references.size)
        y, g = casadi.SX.sym("y", context.measurements.size), casadi.SX.sym("g", 1)
        return casadi.Function("own", [c, r, y, g], [-g * y[:1], c])
"""


@pytest.mark.parametrize("name", controller_names())
def test_built_in_controllers_load(name: str) -> None:
    loaded = load_controller(name)
    assert loaded.name == name
    assert loaded.description


def test_a_file_of_one_law_holds_for_all_models(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("{kind: pid, kp: 20, kd: 2}")
    loaded = load_controller(tmp_path / "mine.yaml")
    assert loaded.nominal == loaded.perturbed == Pid(kp=20.0, kd=2.0)


def test_matrices_are_found_beside_the_controller_file(tmp_path: Path) -> None:
    np.savez(tmp_path / "k.npz", A=[[1.0]], B=[[2.0]], C=[[3.0]], D=[[4.0]], dt=5e-4)
    text = "nominal: {kind: state_space, file: k.npz}\nperturbed: {kind: pid, kp: 1}\n"
    (tmp_path / "mine.yaml").write_text(text)
    loaded = load_controller(tmp_path / "mine.yaml")
    assert isinstance(loaded.nominal, StateSpace)
    assert loaded.nominal.C == ((3.0,),)
    assert loaded.nominal.matrices_sample_time == 5e-4
    assert loaded.perturbed == Pid(kp=1.0)


def test_python_law_with_settings(tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(LAW)
    (tmp_path / "mine.yaml").write_text("{python: own.py, stiffness: 7}")
    assert load_controller(tmp_path / "own.py").nominal.model_dump() == {"stiffness": 3.0}
    assert load_controller(tmp_path / "mine.yaml").nominal.model_dump() == {"stiffness": 7.0}


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("nominal: {kind: pid, kp: 1}", "nominal"),
        ("{controller: {kind: pid, kp: 1}, nominal: {kind: pid, kp: 1}}", "controller"),
        ("{description: none}", "missing"),
        ("{kind: pidd, kp: 1}", "pidd"),
        ("{kind: state_space, file: absent.npz}", "absent.npz"),
        ("{python: absent.py}", "absent.py"),
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, text: str, named: str) -> None:
    (tmp_path / "mine.yaml").write_text(text)
    with pytest.raises(InputError, match=named):
        load_controller(tmp_path / "mine.yaml")


def test_unknown_name_lists_the_built_in_ones() -> None:
    with pytest.raises(InputError, match="pid_check"):
        load_controller("pid_chekc")


def test_python_file_without_a_law_is_refused(tmp_path: Path) -> None:
    (tmp_path / "none.py").write_text("x = 1\n")
    with pytest.raises(InputError, match="0 control laws"):
        load_controller(tmp_path / "none.py")
