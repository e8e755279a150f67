"""Files of a diagnosis, written as a whole folder or not at all."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING

from flexros.atomic_file import write_result
from flexros.errors import InputError
from flexros.gap.answer.patch import patch_of
from flexros.gap.report.write import diagnosis_report
from flexros.json_text import json_text

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.gap.result import DiagnosisResult

DIAGNOSIS, PATCH, REPORT = "diagnosis.json", "patch.yaml", "report.html"
"""Names of the files of a diagnosis; the patch is written only where an effect, or a number that the model lacks, was
found."""
_KINDS = {DIAGNOSIS: "diagnosis", PATCH: "patch", REPORT: "report"}


def check_folder(folder: Path) -> None:
    """Refuse a folder that a diagnosis must not replace.

    Args:
        folder: Folder of the files; one that is empty or holds an earlier diagnosis may be replaced.

    Raises:
        InputError: It is a file, holds anything else, or its parent cannot be made or written to.
    """
    if not folder.name:
        raise InputError(
            f"the folder of a diagnosis is '{folder}', which cannot be replaced as a whole; give a new one", "out"
        )
    if folder.exists() and not folder.is_dir():
        raise InputError(f"the folder of a diagnosis is '{folder}', which is a file; give a folder", "out")
    held = {entry.name for entry in folder.iterdir()} if folder.is_dir() else set()
    foreign = sorted(held - set(_KINDS))
    if foreign or (held and DIAGNOSIS not in held):
        raise InputError(
            f"the folder '{folder}' holds {', '.join(foreign[:3]) or 'no diagnosis.json'}: only an empty folder or one "
            "of an earlier diagnosis is replaced; give another one",
            "out",
        )
    try:
        folder.absolute().parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _cannot_write(folder, error) from error


def write_diagnosis(result: DiagnosisResult, model: str | Path, folder: Path) -> tuple[str, ...]:
    """Write diagnosis.json, report.html and, where `DiagnosisResult.patch` has anything, patch.yaml.

    They are written into a temporary folder, which then replaces an existing one.

    Args:
        result: The diagnosis.
        model: The model that was diagnosed, as the user named it.
        folder: The folder.

    Returns:
        Names of the files.

    Raises:
        InputError: The folder may not be replaced, or cannot be written.
    """
    check_folder(folder)
    patch = patch_of(result, model, folder.absolute()).text() if result.patch else ""
    texts = {
        DIAGNOSIS: json_text(result.diagnosis.model_dump(mode="json", by_alias=True)),
        **({PATCH: patch} if patch else {}),
        REPORT: diagnosis_report(result, patch=patch),
    }
    part, old = (folder.absolute().with_name(f".{folder.name}.{kind}") for kind in ("part", "old"))
    try:
        for rest in (part, old):  # of an aborted diagnosis
            shutil.rmtree(rest, ignore_errors=True)
        part.mkdir()
        for name, text in texts.items():
            write_result(part / name, text, _KINDS[name])
        if folder.exists():
            folder.replace(old)
        part.replace(folder)
    except OSError as error:
        raise _cannot_write(folder, error) from error
    finally:
        if old.exists() and not folder.exists():  # interrupted between the two
            old.replace(folder)
        for rest in (part, old):
            shutil.rmtree(rest, ignore_errors=True)
    return tuple(texts)


def _cannot_write(folder: Path, error: OSError) -> InputError:
    return InputError(
        f"the diagnosis cannot be written to '{folder}' ({error.strerror or error}); give another folder", "out"
    )
