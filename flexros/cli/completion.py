"""Names that a shell completes: robots, scenarios, effects, controllers. Read from folders, so that it is quick."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

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


def controllers_or_scenarios(incomplete: str) -> list[str]:
    """Return what `flexros design margins --controller` takes and begins so."""
    return [*controllers(incomplete), *scenarios(incomplete)]


def methods(incomplete: str) -> list[str]:
    """Return the methods of `flexros design` that begin so."""
    beside = [name for name in ("structure", "margins") if name.startswith(incomplete)]
    return [name for name in _names("control/design/methods", "*.py", incomplete) if name != "base"] + beside


def campaigns(incomplete: str) -> list[str]:
    """Return the campaigns that begin so."""
    folders = (path.parent.name for path in (_LIBRARY / "validation" / "campaigns").glob("*/campaign.py"))
    return sorted(name for name in folders if name.startswith(incomplete))


def benchmarks(incomplete: str) -> list[str]:
    """Return the benchmarks of this checkout that begin so; there are none in an installation."""
    found = (path.stem.removeprefix("bench_") for path in (_LIBRARY.parent / "tests" / "bench").glob("bench_*.py"))
    return sorted(name for name in found if name.startswith(incomplete))


def shown(incomplete: str) -> list[str]:
    """Return the robots that begin so, and the word for the topics; `flexros view` takes logs and folders too."""
    return [*robots(incomplete), *choice("topics")(incomplete)]


def choice(*words: str) -> Callable[[str], list[str]]:
    """Return a completion of one of a few words."""

    def begun(incomplete: str) -> list[str]:
        return [word for word in words if word.startswith(incomplete)]

    return begun


COMPLETED: dict[str, Callable[[str], list[str]]] = {
    "model": robots,
    "real": robots,
    "name": robots,
    "scenario": scenarios,
    "effect": placed_effects,
    "effects": effects,
    "transport": choice("ros", "direct"),
    "layout": choice("composed", "processes"),
    "torque": choice("command", "measured"),
    "estimator": choice("LLS", "LLSM", "NLS"),
    "weights": choice("user", "optimal", "combined"),
    "view what": shown,
    "benchmark controller": controllers,
    "benchmark on": choice("e12", "six_axis"),
    "design method": methods,
    "design controller": controllers_or_scenarios,
    "design only": choice("C1", "C2"),
    "export to": choice("mjcf", "urdf", "sdf", "json"),
    "robot flexible": choice("fixed", "continuous"),
    "identify axis gear": choice("piecewise", "cubic", "linear"),
    "identify axis output": choice("position", "velocity"),
    "campaign name": campaigns,
    "bench name": benchmarks,
}
"""What a shell completes, by the name of the argument, for one command alone after its name."""
