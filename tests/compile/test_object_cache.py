from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from flexros.compile import compile_function, module_builder, object_cache


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    monkeypatch.setenv(object_cache.VARIABLE, str(tmp_path))
    module_builder._compiled.cache_clear()
    yield tmp_path / "objects"
    module_builder._compiled.cache_clear()


def square(value: float) -> float:
    x = ca.SX.sym("x")
    (result,) = compile_function(ca.Function("square", [x], [x * ca.sin(x)]))(np.array([value]))
    return float(result[0])


def compiled_again(monkeypatch: pytest.MonkeyPatch, value: float) -> tuple[float, int]:
    """Evaluate as another process would; also the number of compilations."""
    made = []
    compiled = object_cache.kept_or_made

    def counted(name: str, make: object) -> bytes:
        assert callable(make)
        return compiled(name, lambda: made.append(name) or make())

    monkeypatch.setattr("flexros.compile.machine_code.kept_or_made", counted)
    module_builder._compiled.cache_clear()
    return square(value), len(made)


def test_another_process_need_not_compile_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = square(0.7)
    assert len(list(folder.iterdir())) == 1
    assert compiled_again(monkeypatch, 0.7) == (first, 0)


@pytest.mark.parametrize("damage", [lambda whole: whole[:-10], lambda whole: whole[:-1] + b"?", lambda whole: b""])
def test_a_damaged_object_is_made_anew(folder: Path, monkeypatch: pytest.MonkeyPatch, damage: object) -> None:
    first = square(0.7)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    assert callable(damage)
    path.write_bytes(damage(whole))
    assert compiled_again(monkeypatch, 0.7) == (first, 1)
    assert path.read_bytes() == whole


@pytest.mark.parametrize("off", ["off", "0"])
def test_the_cache_can_be_switched_off(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, off: str) -> None:
    monkeypatch.setenv(object_cache.VARIABLE, off)
    monkeypatch.chdir(tmp_path)
    assert compiled_again(monkeypatch, 0.7)[1] == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.name == "nt", reason="needs permissions of POSIX")
def test_a_folder_that_others_may_write_is_not_read(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    square(0.7)
    folder.chmod(0o777)
    object_cache._private_folder.cache_clear()
    assert compiled_again(monkeypatch, 0.7)[1] == 1


def test_a_folder_that_cannot_be_made_does_no_harm(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv(object_cache.VARIABLE, str(tmp_path / "file"))
    assert compiled_again(monkeypatch, 0.7)[1] == 1


def test_objects_unused_for_longest_go_first(tmp_path: Path) -> None:
    for number in range(5):
        path = tmp_path / f"{number}.o"
        path.write_bytes(bytes(100))
        os.utime(path, (number, number))
    object_cache.remove_unused(tmp_path, 500)
    assert len(list(tmp_path.iterdir())) == 5
    object_cache.remove_unused(tmp_path, 400)
    assert {path.name for path in tmp_path.iterdir()} == {"2.o", "3.o", "4.o"}


def test_another_compiler_or_processor_has_other_objects() -> None:
    assert object_cache.fingerprint("22", "znver3", "text") != object_cache.fingerprint("22", "znver4", "text")
