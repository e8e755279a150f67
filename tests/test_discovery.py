"""Finding the members of a package by their names."""

from __future__ import annotations

import sys
from abc import ABC, abstractmethod
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import ClassVar

import pytest

from flexros.control.base import AbstractControlLaw, control_laws
from flexros.discovery import members
from flexros.effects import effects
from flexros.errors import InputError
from flexros.feedforward.base import feedforward_methods

FILE = """
from tests.test_discovery import AbstractPart
class {base}(AbstractPart):
    '''Between.'''
class {name}({base}):
    name = "{word}"
    def size(self): return 1
"""


class AbstractPart(ABC):
    """Base of the members below."""

    name: ClassVar[str]

    @abstractmethod
    def size(self) -> int:
        """Keep classes between abstract."""


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> Iterator[ModuleType]:
    """Create an importable package with the files of the test's parameter: file -> name of its member."""
    words: dict[str, str] = request.param
    name = f"parts_{request.node.originalname}"
    folder = tmp_path / name
    folder.mkdir()
    (folder / "__init__.py").write_text("")
    for file, word in words.items():
        (folder / f"{file}.py").write_text(FILE.format(base=f"Abstract{file}", name=f"Part{file}", word=word))
    monkeypatch.syspath_prepend(tmp_path)
    yield __import__(name)
    for module in [module for module in sys.modules if module.split(".")[0] == name]:
        del sys.modules[module]


@pytest.mark.parametrize("package", [{"top": "one"}], indirect=True)
def test_members_in_folders_that_are_named_are_found_as_well(package: ModuleType) -> None:
    (path,) = package.__path__
    for folder, word in (("known", "two"), ("other", "three")):
        (Path(path) / folder).mkdir()
        (Path(path) / folder / "__init__.py").write_text("")
        (Path(path) / folder / "one.py").write_text(FILE.format(base=f"Abstract{word}", name=f"Part{word}", word=word))
    assert set(members(package.__name__, AbstractPart, folders=["known"])) == {"one", "two"}


@pytest.mark.parametrize("package", [{"b": "two", "a": "one"}], indirect=True)
def test_members_are_found_by_name_also_below_an_abstract_class(package: ModuleType) -> None:
    found = members(package.__name__, AbstractPart)
    assert list(found) == sorted(found)
    assert {"one", "two"} == set(found)
    assert found["one"].__name__ == "Parta"


@pytest.mark.parametrize("package", [{"x": "same", "y": "same"}], indirect=True)
def test_two_members_of_one_name_are_refused(package: ModuleType) -> None:
    name = package.__name__
    with pytest.raises(
        InputError, match=rf"^'same' is the name of both {name}\.x and {name}\.y; give one of them another name$"
    ):
        members(package.__name__, AbstractPart)


@pytest.mark.parametrize("package", [{"z": "only"}], indirect=True)
def test_classes_of_other_packages_are_omitted(package: ModuleType) -> None:
    class Foreign(AbstractPart):
        name: ClassVar[str] = "foreign"

        def size(self) -> int:
            return 2

    assert set(members(package.__name__, AbstractPart)) == {"only"}
    assert Foreign().size() == 2


def test_rooms_have_their_members() -> None:
    assert {"cascade", "pid", "state_space", "computed_torque", "lqg"} <= set(control_laws())
    assert {"payload_error", "stiffness_error", "delay"} <= set(effects())
    assert set(feedforward_methods()) == {"none", "rigid", "flexible_joint", "dae", "stable_inversion"}
    assert all(issubclass(law, AbstractControlLaw) for law in control_laws().values())
