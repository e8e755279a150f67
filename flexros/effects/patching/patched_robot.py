"""Loading a model: a built-in robot, a robot file, or a patch of one."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from flexros.config.settings import validate
from flexros.config.yaml_file import read_yaml
from flexros.effects.patching.patch import Patch, is_patch, named_robot
from flexros.effects.patching.placement import place_effects
from flexros.errors import InputError, source_named
from flexros.robot import load_robot

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from flexros.effects.kinds.base import PlacedEffect
    from flexros.effects.patching.placement import PlacedLaw, RobotWithEffects
    from flexros.robot import Robot


@dataclass(frozen=True, eq=False)
class PatchedRobot:
    """A robot as its files state it: robot file and effects of patches.

    Attributes:
        base: The robot of the robot file.
        placed: Effects of the patches, the innermost patch first; empty for a robot file.
        source: Name or file from which it was loaded.
    """

    base: Robot
    placed: tuple[PlacedEffect, ...]
    source: str

    @cached_property
    def model(self) -> RobotWithEffects:
        """The robot with the effects.

        Raises:
            InputError: The robot has no such location.
        """
        if not self.placed:
            return place_effects(self.base, ())
        with source_named(self.source):
            return place_effects(self.base, self.placed)

    @property
    def fingerprint(self) -> str:
        """Fingerprint of robot file and effects, 16 hexadecimal digits; without effects that of the robot."""
        if not self.placed:
            return self.base.model_hash
        text = "\n".join([self.base.model_hash, *map(str, self.placed)])
        return hashlib.sha256(text.encode()).hexdigest()[:16]

    def with_values(self, values: Mapping[str, float], source: str) -> PatchedRobot:
        """Replace values of the robot file; the effects remain.

        Args:
            values: New values (SI) by parameter name, as for `Robot.with_values`.
            source: Origin of the change; prefix of error messages.

        Raises:
            InputError: A name is unknown or the new robot is not physical.
        """
        return replace(self, base=self.base.with_values(values, source)) if values else self


def load_patched(name_or_path: str | Path) -> PatchedRobot:
    """Load robot file and effects of a model.

    Args:
        name_or_path: Built-in robot, or path of a robot file or of a patch. A patch may apply to another patch: their
            effects add up.

    Raises:
        InputError: Unknown robot, missing or invalid file, a circular patch, or a patch of another robot.
    """
    return _loaded(name_or_path, ())


def load_model(name_or_path: str | Path) -> RobotWithEffects:
    """Load a model as robot and laws of effects; a robot file has no laws.

    Args:
        name_or_path: Built-in robot, or path of a robot file or of a patch.

    Raises:
        InputError: As for `load_patched`, or the robot has no such location.
    """
    return load_patched(name_or_path).model


def fingerprint(robot: Robot, laws: Sequence[PlacedLaw]) -> str:
    """Return the fingerprint of robot and laws, 16 hexadecimal digits; without laws that of the robot."""
    if not laws:
        return robot.model_hash
    text = "\n".join([robot.model_hash, *(f"{law.name}:{law.effect!r}" for law in laws)])
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _loaded(name_or_path: str | Path, above: tuple[Path, ...]) -> PatchedRobot:
    path = Path(name_or_path)
    if path.suffix not in (".yaml", ".yml") or not is_patch(data := read_yaml(path)):
        return PatchedRobot(load_robot(name_or_path), (), str(name_or_path))
    if path.resolve() in above:
        files = " -> ".join(str(file) for file in (*above, path.resolve()))
        raise InputError(f"{path}: the patch is circular ({files}); name a robot file as the robot of one of them")
    patch = validate(Patch, data, str(path))
    with source_named(f"{path}, key robot"):
        below = _loaded(named_robot(patch.robot, path.parent), (*above, path.resolve()))
    if patch.robot_hash and patch.robot_hash != below.fingerprint:
        raise InputError(
            f"{path}, key robot_hash: the patch was made for the robot {patch.robot} with fingerprint "
            f"{patch.robot_hash}, but it has {below.fingerprint} now, because its file has changed; diagnose again "
            "with the present file, or remove the key to use the patch anyway"
        )
    made = PatchedRobot(below.base, (*below.placed, *patch.placed(str(path))), str(path))
    _ = made.model  # reports a location that the robot does not have together with the file
    return made
