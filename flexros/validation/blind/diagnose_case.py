"""Diagnosing the cases of a blind check: from logs and nominal model alone."""

from __future__ import annotations

import shutil
import time
import traceback
from typing import TYPE_CHECKING, Any

from flexros.atomic_file import write_whole
from flexros.errors import FlexrosError, InputError
from flexros.gap.answer.patch import write_patch
from flexros.json_text import json_text
from flexros.scheduler import finished
from flexros.validation.blind.seal import CASE_FILE, DIAGNOSIS_FILE, ROBOT_FILE, OpenCase, read_case

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from distributed import Client

    from flexros.gap.result import DiagnosisResult
    from flexros.gap.settings import DiagnosisSettings
    from flexros.record.record import Record
    from flexros.robot import Robot

FAILURE_FILE, TIME_FILE, PATCH_FILE = "failure.txt", "seconds.txt", "patch.yaml"
"""Files of a case: reason of a missing diagnosis; computing time [s]; patch of the diagnosis."""


def case_folders(logs: Path) -> tuple[Path, ...]:
    """List the folders of complete cases, by name.

    Args:
        logs: Folder of all logs.

    Raises:
        InputError: There is no case.
    """
    folders = tuple(sorted(path.parent for path in logs.glob(f"*/{CASE_FILE}")))
    if not folders:
        raise InputError(f"the folder '{logs}' holds no cases; give the folder of logs that `flexros blind make` wrote")
    return folders


def waiting(logs: Path) -> tuple[Path, ...]:
    """List the folders of cases that have no diagnosis yet."""
    done = (DIAGNOSIS_FILE, FAILURE_FILE)
    return tuple(folder for folder in case_folders(logs) if not any((folder / name).exists() for name in done))


def failures(logs: Path) -> dict[str, str]:
    """Return the reasons of failed diagnoses: the last line of each, by name of the case."""
    files = sorted(logs.glob(f"*/{FAILURE_FILE}"))
    return {file.parent.name: file.read_text(encoding="utf-8").strip().splitlines()[-1] for file in files}


def diagnose_case(folder: Path, keep_logs: bool = True) -> None:
    """Diagnose a case and write the result to its folder.

    A refused log or an error of the diagnosis is a result as well: its text is kept, and the other cases continue.

    Args:
        folder: Folder of the case.
        keep_logs: Whether its logs stay; they can be made again from the seed.
    """
    case = read_case(folder)
    started = time.perf_counter()  # reported with the result, which does not depend on it
    try:
        result = diagnosed(folder, case)
        text = json_text(result.diagnosis.model_dump(mode="json", by_alias=True))
        if result.patch:
            write_patch(result, folder / ROBOT_FILE, folder / PATCH_FILE)
    except FlexrosError as error:
        write_whole(folder / FAILURE_FILE, f"{error}\n")
    except Exception:  # noqa: BLE001 - counted with the refused logs and shown with its traceback
        write_whole(folder / FAILURE_FILE, traceback.format_exc())
    else:
        write_whole(folder / TIME_FILE, f"{time.perf_counter() - started:.1f}\n")
        write_whole(folder / DIAGNOSIS_FILE, text)
    if not keep_logs:
        for log in case.logs:
            shutil.rmtree(folder / log, ignore_errors=True)


def diagnosed(folder: Path, case: OpenCase) -> DiagnosisResult:
    """Diagnose the logs of a case.

    Args:
        folder: Folder of the case.
        case: What is open of it.

    Returns:
        The result; neither truth nor third log were read.
    """
    from flexros.gap.diagnose import diagnose

    robot, record, holdout = read_logs(folder, case)
    return diagnose(record, robot, holdout=holdout, settings=case_settings())


def case_settings() -> DiagnosisSettings:
    """Return the settings of a diagnosis: the usual ones, on one core because cases run side by side.

    Nothing is done that is not scored: no map of where, no next experiment.
    """
    from flexros.gap.settings import DiagnosisSettings

    return DiagnosisSettings(threads=1, where=None, next_experiment=None)


def read_logs(folder: Path, case: OpenCase) -> tuple[Robot, Record, Record]:
    """Read nominal model, log to fit and log to check on.

    Args:
        folder: Folder of the case.
        case: What is open of it.
    """
    from flexros.gap.checked_log import checked_log
    from flexros.logs.reader import read_log
    from flexros.robot import load_robot

    robot = load_robot(folder / ROBOT_FILE)
    fit, holdout = (checked_log(read_log(folder / log), robot, name=f"{case.name}/{log}") for log in case.logs[:2])
    return robot, fit, holdout


def on_workers(
    client: Client, function: Callable[..., None], jobs: Sequence[tuple[Any, ...]], progress: Callable[[int], None]
) -> None:
    """Work through jobs that leave files behind.

    Args:
        client: Dask client whose workers do it.
        function: What does one job.
        jobs: Its arguments.
        progress: Called with the number of jobs that are done.
    """
    submitted = [client.submit(function, *arguments, pure=False) for arguments in jobs]
    progress(0)
    for done, _ in enumerate(finished(client, submitted), start=1):
        progress(done)
