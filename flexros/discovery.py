"""Discovery of the members of a package by name: one member per file, no registry."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeVar

from flexros.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping

Base = TypeVar("Base")


def members(package: str, base: type[Base], key: str = "name", folders: Iterable[str] = ()) -> Mapping[str, type[Base]]:
    """Return all final subclasses of a base class in the files of a package.

    Args:
        package: Name of the package whose modules are imported.
        base: Base of the members, direct or through an intermediate abstract class.
        key: Class variable that holds a member's name.
        folders: Folders of the package that hold members as well.

    Returns:
        Classes by name, in alphabetical order, without abstract classes and classes of other packages.

    Raises:
        InputError: Two members have the same name.
    """
    for part in (package, *(f"{package}.{folder}" for folder in folders)):
        for module in pkgutil.iter_modules(importlib.import_module(part).__path__, f"{part}."):
            importlib.import_module(module.name)
    found: dict[str, type[Base]] = {}
    for member in _subclasses(base):
        if inspect.isabstract(member) or not member.__module__.startswith(f"{package}."):
            continue
        name = getattr(member, key)
        if name in found:
            first, second = sorted((found[name].__module__, member.__module__))
            raise InputError(f"'{name}' is the {key} of both {first} and {second}; give one of them another {key}")
        found[name] = member
    return MappingProxyType(dict(sorted(found.items())))


def _subclasses(base: type[Base]) -> Iterator[type[Base]]:
    """Yield all direct and indirect subclasses, each once."""
    seen: set[type[Base]] = set()
    waiting = [base]
    while waiting:
        for member in waiting.pop().__subclasses__():
            if member not in seen:
                seen.add(member)
                waiting.append(member)
                yield member
