"""Sealed truth of a case: kept apart from its logs, whose folder holds its hash, so that it cannot be changed."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, TypeVar

from pydantic import Field, ValidationError

from flexros.atomic_file import write_whole
from flexros.config.settings import Settings
from flexros.errors import InputError
from flexros.validation.blind.deviation import Deviation

if TYPE_CHECKING:
    from pathlib import Path

Content = TypeVar("Content", bound=Settings)

CASE_FILE, ROBOT_FILE, DIAGNOSIS_FILE = "case.json", "robot.yaml", "diagnosis.json"
"""Files in the folder of a case."""


class OpenCase(Settings):
    """The open part of a case, known to the diagnosis; `case.json`."""

    name: str = Field(description="name of the case")
    robot: str = Field(description="name of the robot")
    logs: tuple[str, ...] = Field(description="folders of the logs: to fit, to check on, and one for neither")
    seal: str = Field(description="SHA-256 of the sealed truth")


class Truth(Settings):
    """The hidden part of a case."""

    name: str = Field(description="name of the case")
    kind: str = Field(description="single, null, unknown, pair or crowd")
    robot: str = Field(description="name of the robot")
    size: str = Field(description="size that was drawn for")
    nuisance: str = Field(description="state of the nominal model")
    tool: bool = Field(description="whether the tool was measured")
    deviations: tuple[Deviation, ...] = Field(description="what is hidden")
    gains: tuple[float, ...] = Field(
        description="expected gain of each in log-likelihood, alone, in a crowd added last [nats]"
    )
    sample_time: float = Field(description="time between two samples [s]")
    motion: str = Field(description="kind of reference")
    conditions: dict[str, float] = Field(description="noise and clocks [SI]")
    robot_sha256: str = Field(description="hash of the nominal model that the diagnosis was given")
    salt: str = Field(description="random text that keeps the seal from being guessed")

    @property
    def gain(self) -> float:
        """Smallest expected gain of what is hidden [nats]; zero for nothing."""
        return min(self.gains, default=0.0)


def sealed_text(truth: Truth) -> str:
    """Write a truth as text."""
    return truth.model_dump_json(indent=1) + "\n"


def sha256(content: str | bytes) -> str:
    """Hash a text or bytes; 64 hexadecimal digits."""
    return hashlib.sha256(content.encode() if isinstance(content, str) else content).hexdigest()


def write_truth(truth: Truth, folder: Path) -> str:
    """Write a truth into the folder of truths.

    Args:
        truth: The truth.
        folder: Folder of truths, which exists.

    Returns:
        Its seal.
    """
    text = sealed_text(truth)
    write_whole(folder / f"{truth.name}.json", text)
    return sha256(text)


def read_case(folder: Path) -> OpenCase:
    """Read what is open of a case.

    Args:
        folder: Folder of the case.

    Raises:
        InputError: The file is missing or is not one of a case.
    """
    return _read(OpenCase, folder / CASE_FILE, "folder of a case")


def read_truth(case: OpenCase, folder: Path, robot: bytes) -> Truth:
    """Open the truth of a case and check its seal.

    Args:
        case: What is open of it.
        folder: Folder of truths.
        robot: The nominal model in the folder of the logs.

    Returns:
        The truth.

    Raises:
        InputError: There is none, or it was changed after the logs were made.
    """
    file = folder / f"{case.name}.json"
    truth = _read(Truth, file, "folder of truths")
    if sha256(file.read_bytes()) != case.seal:
        raise InputError(
            f"the truth '{file}' has SHA-256 {sha256(file.read_bytes())[:12]}..., but the logs of {case.name} were "
            f"sealed with {case.seal[:12]}...: one of them was changed; make the case again"
        )
    if sha256(robot) != truth.robot_sha256:
        raise InputError(
            f"the file {ROBOT_FILE} in the folder of {case.name} is not the one that was sealed; make the case again"
        )
    return truth


def _read(model: type[Content], file: Path, what: str) -> Content:
    try:
        return model.model_validate_json(file.read_bytes())
    except OSError as error:
        raise InputError(
            f"'{file}' cannot be read ({error.strerror or error}); give a {what} that `flexros blind make` wrote"
        ) from error
    except ValidationError as error:
        raise InputError(
            f"'{file}' is not a file of a blind check ({error.errors()[0]['msg']}); give a {what} that "
            "`flexros blind make` wrote"
        ) from error
