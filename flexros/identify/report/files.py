"""Files of an identification: the robot, the figures, the page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from flexros.atomic_file import write_result
from flexros.errors import InputError
from flexros.identify.graybox.identified_robot import identified_yaml
from flexros.identify.report.record import identification_record
from flexros.identify.report.write import identification_report
from flexros.json_text import json_text

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.identify.result import IdentificationResult

ROBOT, FIGURES, REPORT = "identified.yaml", "identification.json", "report.html"
"""Names of the files in the folder of an identification."""
_KINDS = {ROBOT: "identified robot", FIGURES: "result", REPORT: "report"}


def write_identification(result: IdentificationResult, folder: Path, origin: str = "") -> None:
    """Write identified.yaml, identification.json and report.html, once all of them are made.

    Parameters that are not determined, or that ended on a bound of the search, keep their nominal value in the file of
    the robot: it may be used for feedforward.

    Args:
        result: The identification.
        folder: The folder; made where it is missing.
        origin: Part of the source of the identified values in addition to the estimator, e.g. the experiment.

    Raises:
        InputError: They cannot be written there, or the identified robot is not physical.
    """
    make_folder(folder)
    contents = {
        ROBOT: identified_yaml(result.problem.robot, result.fit, result.covariance, origin, result.kept_nominal),
        FIGURES: json_text(identification_record(result)),
        REPORT: identification_report(result),
    }
    for name, text in contents.items():
        write_result(folder / name, text, _KINDS[name])


def make_folder(folder: Path) -> None:
    """Make the folder of an identification.

    Args:
        folder: The folder; one that exists is taken as it is.

    Raises:
        InputError: It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"the folder '{folder}' of the identification cannot be made ({error.strerror or error}); give another one",
            "out",
        ) from error
