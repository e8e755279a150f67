"""One case of the campaign: generated, diagnosed and deleted except for truth and answer."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from flexros.errors import InputError
from flexros.gap.schema import Diagnosis
from flexros.validation.blind.diagnose_case import FAILURE_FILE, TIME_FILE, diagnose_case
from flexros.validation.blind.make_case import MakeSettings, UndrawnCaseError, make_case
from flexros.validation.blind.score.answer import Answer
from flexros.validation.blind.score.crowd_truth import CrowdTruth, crowd_truth
from flexros.validation.blind.score.oracle import oracle_fraction
from flexros.validation.blind.score.third_log import ThirdLog, third_log
from flexros.validation.blind.seal import DIAGNOSIS_FILE, Truth, read_case, sha256

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.validation.blind.plan import Case


def case_part(settings: MakeSettings, case: Case) -> dict[str, Any]:
    """Make the logs of a case, diagnose them without its truth, and give both.

    Args:
        settings: Seed and lengths.
        case: The case.

    Returns:
        For JSON: `seal`, `truth` (text), `diagnosis` (text or None), `failure` (text or None), `seconds`, and `oracle`:
        the closed fraction of the true effect where it is a single one well above the noise; `third`: the gap of the
        third log with the patch of the diagnosis, or None; `crowd`: figures of the true effects of a crowd, or None.
        Of a case that cannot be drawn: `failure`, and None as its truth.
    """
    with TemporaryDirectory(prefix="flexros_logs_") as logs, TemporaryDirectory(prefix="flexros_truth_") as truths:
        try:
            make_case(case, settings, Path(logs), Path(truths))
        except UndrawnCaseError as error:
            return {"truth": None, "failure": str(error)}
        folder = Path(logs) / case.name
        diagnose_case(folder)
        truth = Truth.model_validate_json((Path(truths) / f"{case.name}.json").read_bytes())
        answered = (folder / DIAGNOSIS_FILE).exists()
        return {
            "seal": read_case(folder).seal,
            "truth": (Path(truths) / f"{case.name}.json").read_text(encoding="utf-8"),
            "diagnosis": _text(folder / DIAGNOSIS_FILE),
            "failure": _text(folder / FAILURE_FILE),
            "seconds": _text(folder / TIME_FILE),
            "third": _third(folder) if answered else None,
            "oracle": oracle_fraction(folder, read_case(folder), truth) if answered else None,
            "crowd": _crowd(folder, truth) if answered else None,
        }


def answer_of(name: str, part: Mapping[str, Any]) -> Answer:
    """Open the truth of a part and check its seal.

    Args:
        name: Name of the case.
        part: What `case_part` gave.

    Returns:
        The case as scored.

    Raises:
        InputError: The truth was changed.
    """
    if sha256(part["truth"]) != part["seal"]:
        raise InputError(
            f"the truth of {name} does not have the SHA-256 it was sealed with; remove its file from the folder of the "
            "campaign, so that it is made again"
        )
    text, seconds = part["diagnosis"], part["seconds"]
    return Answer(
        Truth.model_validate_json(part["truth"]),
        None if text is None else Diagnosis.model_validate_json(text),
        None if seconds is None else float(seconds),
        part["oracle"],
        None if part["third"] is None else ThirdLog.model_validate(part["third"]),
        None if part.get("crowd") is None else CrowdTruth.model_validate(part["crowd"]),
    )


def _third(folder: Path) -> dict[str, Any] | None:
    gap = third_log(folder, read_case(folder))
    return None if gap is None else gap.model_dump(mode="json")


def _crowd(folder: Path, truth: Truth) -> dict[str, Any] | None:
    figures = crowd_truth(folder, read_case(folder), truth)
    return None if figures is None else figures.model_dump(mode="json")


def _text(file: Path) -> str | None:
    return file.read_text(encoding="utf-8") if file.exists() else None
