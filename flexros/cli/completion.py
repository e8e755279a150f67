"""Names that a shell completes: robots, scenarios, effects, controllers. Read from folders, so that it is quick."""

from __future__ import annotations

from pathlib import Path

_LIBRARY = Path(__file__).parents[1]
_BEHIND_EFFECTS = {"kinds", "patching"}
"""Folders of `effects` that hold no effects."""


def _names(folder: str, pattern: str, incomplete: str) -> list[str]:
    stems = (path.stem for path in (_LIBRARY / folder).glob(pattern))
    return sorted(stem for stem in stems if stem.startswith(incomplete) and not stem.startswith("_"))


def robots(incomplete: str) -> list[str]:
    """Return the built-in robots that begin so; files are completed by the shell where there is none."""
    return _names("robot/library", "*.yaml", incomplete)


def scenarios(incomplete: str) -> list[str]:
    """Return the built-in scenarios that begin so."""
    return _names("scenario/library", "*.yaml", incomplete)


def controllers(incomplete: str) -> list[str]:
    """Return the built-in controllers of the feedback benchmark that begin so."""
    return _names("benchmark/library", "*.yaml", incomplete)


def effects(incomplete: str) -> list[str]:
    """Return the last name of a list of effects completed, with those before it: coulomb_friction,back -> backlash."""
    before, comma, last = incomplete.rpartition(",")
    files = (_LIBRARY / "effects").rglob("*.py")
    names = {path.stem for path in files if not _BEHIND_EFFECTS & set(path.parts) and not path.stem.startswith("_")}
    return sorted(f"{before}{comma}{name}" for name in names if name.startswith(last))


def placed_effects(incomplete: str) -> list[str]:
    """Return the effects that begin so, each followed by the @ of its location."""
    return [f"{name}@" for name in effects(incomplete)] if "@" not in incomplete else []
