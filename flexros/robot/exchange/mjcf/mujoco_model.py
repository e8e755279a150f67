"""Compiling an MJCF with MuJoCo, which resolves defaults, angles, frames and inertias of geoms."""

from __future__ import annotations

import math
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

    What its flags disable is zero: damping, stiffness, dry friction. Meshes and pictures whose files are missing are
    left out, unless the inertia of a body depends on them.

    Raises:
        InputError: No MJCF, a mesh is missing that gives a body its inertia, or MuJoCo refuses it or is not installed.
    """
    mujoco = mujoco_package()
    if "<mujoco" not in read_text(file, "MJCF", LARGEST_URDF):
        raise InputError(f"{file} has no element <mujoco>; give an MJCF (for a URDF: flexros import-urdf)")
    try:
        return _compile(mujoco.MjSpec.from_file(str(file)), file.parent, str(file))
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
        return _compile(specification, folder, source)
    except (ValueError, mujoco.FatalError) as error:
        raise InputError(f"{source}: MuJoCo refuses the changed model: {error}") from error


def _compile(specification: Any, folder: Path, source: str) -> Any:
    """Compile a model without the files of shapes and pictures that are missing."""
    compiler = specification.compiler
    missing = {mesh.name for mesh in specification.meshes if _is_missing(mesh.file, compiler.meshdir, folder)}
    for geom in specification.geoms:
        if geom.meshname in missing:
            _refuse_inertia_of_mesh(specification, geom, source)
            _replace_by_point(geom)
    for mesh in list(specification.meshes):
        if mesh.name in missing:
            specification.delete(mesh)
    for texture in list(specification.textures):
        if _is_missing(texture.file, compiler.texturedir, folder):
            for material in specification.materials:
                material.textures = ["" if name == texture.name else name for name in material.textures]
            specification.delete(texture)
    model = specification.compile()
    _switch_off(model)
    return model


def _switch_off(model: Any) -> None:
    """Set to zero what the flags of a model disable: dampers, springs, dry friction, limits of controls."""
    flags, bits = int(model.opt.disableflags), mujoco_package().mjtDisableBit
    passive = "PASSIVE" if hasattr(bits, "mjDSBL_PASSIVE") else ""  # one flag for both in earlier versions
    rows = (
        (passive or "DAMPER", ("dof_damping", "dof_dampingpoly")),
        (passive or "SPRING", ("jnt_stiffness", "jnt_stiffnesspoly")),
        ("FRICTIONLOSS", ("dof_frictionloss",)),
        ("CLAMPCTRL", ("actuator_ctrllimited",)),
    )
    for flag, arrays in rows:
        if flags & int(getattr(bits, f"mjDSBL_{flag}")):
            for array in (each for each in arrays if hasattr(model, each)):
                getattr(model, array)[:] = 0


def _is_missing(name: str, assets: str, folder: Path) -> bool:
    """Whether an asset has a file that is not there."""
    return bool(name) and not any(is_file(place / name) for place in (folder / assets, folder))


def _refuse_inertia_of_mesh(specification: Any, geom: Any, source: str) -> None:
    """Refuse a model in which a missing mesh has a part in the inertia of its body."""
    mujoco = mujoco_package()
    rule, body = specification.compiler.inertiafromgeom, geom.parent
    from_geoms = rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE or (
        rule == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO and not body.explicitinertial
    )
    first, last = specification.compiler.inertiagrouprange
    has_mass = geom.density > 0 if math.isnan(geom.mass) else geom.mass > 0
    if from_geoms and has_mass and first <= geom.group <= last and _moves(body):
        raise InputError(
            f"{source}: the inertia of body '{body.name}' comes from mesh '{geom.meshname}', whose file is missing; "
            "put the meshes where the MJCF looks for them, or give the body an element <inertial>"
        )


def _moves(body: Any) -> bool:
    """Whether a body, or one that carries it, has a joint."""
    return body is not None and (bool(body.joints) or _moves(body.parent))


def _replace_by_point(geom: Any) -> None:
    """Let a point stand for the shape of a geom: others may refer to it by name."""
    geom.type = mujoco_package().mjtGeom.mjGEOM_SPHERE
    geom.meshname = ""
    geom.size = [1e-6, 0.0, 0.0]
    geom.mass = 0.0


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
