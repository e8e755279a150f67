"""Repair: the effects of a diagnosis as a patch of the robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.atomic_file import write_result
from flexros.effects.patching.patch import Covariance, Patch, PatchedEffect, PatchedValue, name_from, numbered
from flexros.effects.patching.patched_robot import load_patched

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

    from flexros.arrays import FloatArray
    from flexros.effects import PlacedEffect
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import CauseParameter

DIGITS = 9
"""Significant digits of values in a patch: far more than any log determines."""


def patch_of(result: DiagnosisResult, model: str | Path, folder: Path) -> Patch:
    """Make the patch of a diagnosis.

    Args:
        result: Result of the diagnosis.
        model: The diagnosed model: built-in robot, or path of a robot file or of a patch.
        folder: Folder of the patch; paths in it are relative to this.

    Returns:
        The effects that repair the model with their fitted parameters; without effects where none was found.

    Raises:
        InputError: The model cannot be loaded.
    """
    causes = result.diagnosis.causes
    fitted = dict(zip(numbered(f"{cause.effect}@{cause.location}" for cause in causes), causes))
    parameters = {name: cause.parameters for name, cause in fitted.items()}
    return Patch(
        robot=name_from(str(model), folder),
        robot_hash=load_patched(model).fingerprint,
        source=f"diagnosis of {result.record.name}: {result.diagnosis.verdict}",
        effects=tuple(_effect(placed, parameters.get(name, {})) for name, placed in zip(_names(result), result.patch)),
        covariance=_covariance(result),
    )


def write_patch(result: DiagnosisResult, model: str | Path, path: Path) -> Patch:
    """Write the patch of a diagnosis as a file, whole or not at all.

    Args:
        result: Result of the diagnosis.
        model: The diagnosed model, as for `patch_of`.
        path: The file, usually patch.yaml next to diagnosis.json.

    Returns:
        The patch.

    Raises:
        InputError: The file cannot be written.
    """
    patch = patch_of(result, model, path.absolute().parent)
    write_result(path, patch.text(), "patch")
    return patch


def _names(result: DiagnosisResult) -> tuple[str, ...]:
    return numbered(f"{placed.effect.name}@{placed.location}" for placed in result.patch)


def _effect(placed: PlacedEffect, fitted: Mapping[str, CauseParameter]) -> PatchedEffect:
    """Return the parameters that are not at their neutral defaults, with errors and units of the fitted ones."""
    values = {**placed.effect.model_dump(mode="json", exclude_defaults=True)}
    values |= {name: getattr(placed.effect, name) for name in fitted}
    parameters = {name: _value(value, fitted.get(name)) for name, value in values.items()}
    return PatchedEffect(effect=placed.effect.name, location=placed.location, parameters=parameters)


def _value(value: bool | float | str, fitted: CauseParameter | None) -> PatchedValue:
    if isinstance(value, (bool, str)):
        return PatchedValue(value=value)
    known = fitted is not None and np.isfinite(fitted.std)
    return PatchedValue(
        value=_rounded(value),
        std=_rounded(fitted.std) if fitted is not None and known else None,
        unit="" if fitted is None else fitted.unit,
    )


def _covariance(result: DiagnosisResult) -> Covariance | None:
    """Select the parameters of the effects with a known variance; tolerated deviations are no part of a patch."""
    if result.covariance is None:
        return None
    pairs = zip(_names(result), result.patch)
    own = {f"{name}.{parameter}" for name, placed in pairs for parameter in type(placed.effect).model_fields}
    variance = np.diagonal(result.covariance)
    known = [
        index
        for index, name in enumerate(result.covariance_of)
        if name in own and np.isfinite(variance[index]) and variance[index] > 0
    ]
    if not known:
        return None
    matrix = result.covariance[np.ix_(known, known)]
    rows = tuple(tuple(_rounded(value) for value in row) for row in _semidefinite(matrix))
    return Covariance(names=tuple(result.covariance_of[index] for index in known), matrix=rows)


def _semidefinite(matrix: FloatArray) -> FloatArray:
    """Remove negative eigenvalues that are left by rounding where parameters are collinear; variances stay."""
    deviation = np.sqrt(np.diagonal(matrix))
    size, direction = np.linalg.eigh(0.5 * (matrix + matrix.T) / np.outer(deviation, deviation))
    half = direction * np.sqrt(np.maximum(size, 0.0))
    half *= (deviation / np.linalg.norm(half, axis=1))[:, None]
    result: FloatArray = half @ half.T
    return result


def _rounded(value: float) -> float:
    return float(f"{float(value):.{DIGITS}g}")
