"""Compiling an MJCF with MuJoCo, which resolves defaults, angles, frames and inertias of geoms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flexros.config.text_file import is_file, read_text
from flexros.errors import InputError
from flexros.input_limits import LARGEST_URDF
from flexros.robot.exchange.xml_text import XmlText

if TYPE_CHECKING:
    from pathlib import Path


def mujoco_package() -> Any:
    """Return the package mujoco, an optional part of the installation.

    Raises:
        InputError: It is not installed.
    """
    try:
        import mujoco
    except ImportError as error:
        raise InputError(
            "an MJCF is read by MuJoCo, which is not installed; install the extra: pip install 'flexros[mujoco]'"
        ) from error
    return mujoco


def compile_file(file: Path) -> Any:
    """Return the compiled model (mujoco.MjModel) of an MJCF.

    Raises:
        InputError: No MJCF, or MuJoCo refuses it, or is not installed.
    """
    mujoco = mujoco_package()
    if "<mujoco" not in read_text(file, "MJCF", LARGEST_URDF):
        raise InputError(f"{file} has no element <mujoco>; give an MJCF (for a URDF: flexros import-urdf)")
    try:
        return mujoco.MjModel.from_xml_path(str(file))
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"{file}: MuJoCo refuses the model: {error}; correct the MJCF") from error


def compile_text(text: str, folder: Path, source: str) -> Any:
    """Return the compiled model of an MJCF text whose assets and included files are in a folder.

    Raises:
        InputError: MuJoCo refuses it, or is not installed.
    """
    mujoco = mujoco_package()
    try:
        specification = mujoco.MjSpec.from_string(text, include=_included(text, folder))
        specification.modelfiledir = str(folder)
        return specification.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"{source}: MuJoCo refuses the changed model: {error}") from error


def _included(text: str, folder: Path) -> dict[str, bytes]:
    """Return the files that a text includes, also through others, by the name in the text."""
    found: dict[str, bytes] = {}
    waiting = [text]
    while waiting:
        for element in XmlText(waiting.pop(), "the MJCF").root.iter("include"):
            name = element.attributes.get("file", "")
            path = folder / name
            if name and name not in found and is_file(path):
                content = read_text(path, "MJCF", LARGEST_URDF)
                found[name] = content.encode()
                waiting.append(content)
    return found
