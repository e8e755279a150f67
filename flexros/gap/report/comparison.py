"""Several diagnoses side by side: effects and numbers they found, and which differ beyond their deviations."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import chi2

from flexros.config.settings import validate
from flexros.config.text_file import read_json
from flexros.errors import InputError
from flexros.gap.report.files import DIAGNOSIS
from flexros.gap.report.verdict import reported_causes
from flexros.gap.schema import Diagnosis

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from flexros.gap.schema import Cause

LARGEST = 16 * 2**20
"""Largest diagnosis.json that is read [byte] (chosen)."""


@dataclass(frozen=True)
class ComparedValue:
    """A parameter of an effect, or a number of the model, over the diagnoses.

    Attributes:
        effect: Name of the effect; empty for a number of the model.
        location: Its location.
        name: Name of the parameter.
        unit: SI unit, 1 for none.
        values: Fitted value of each diagnosis; None where it was not found.
        stds: Their standard deviations.
        shares: Share of the gap that opens without the effect, of each diagnosis [1]; None where not known.
    """

    effect: str
    location: str
    name: str
    unit: str
    values: tuple[float | None, ...]
    stds: tuple[float | None, ...]
    shares: tuple[float | None, ...]

    @property
    def found(self) -> int:
        """Number of diagnoses that found it."""
        return sum(value is not None for value in self.values)

    @property
    def p_same(self) -> float | None:
        """Probability of values as far apart by chance, were the true ones the same [1]; None for fewer than two.

        The sum of squares about the weighted mean, (value - mean) / std, is chi-squared with one degree of freedom less
        than there are values.
        """
        pairs = [
            (value, std)
            for value, std in zip(self.values, self.stds, strict=True)
            if value is not None and std is not None and std > 0
        ]
        if len(pairs) < 2:
            return None
        values, weights = np.array([one for one, _ in pairs]), np.array([std**-2.0 for _, std in pairs])
        mean = float(weights @ values / weights.sum())
        return float(chi2.sf(weights @ (values - mean) ** 2, len(pairs) - 1))


@dataclass(frozen=True, eq=False)
class DiagnosisComparison:
    """Several diagnoses.

    Attributes:
        names: Name of each.
        diagnoses: The diagnoses.
    """

    names: tuple[str, ...]
    diagnoses: tuple[Diagnosis, ...]

    @property
    def effects(self) -> tuple[ComparedValue, ...]:
        """Parameters of all effects found: first the effects of most diagnoses, of these what makes up most."""
        causes = [
            {(cause.effect, cause.location): cause for cause in _found(diagnosis)} for diagnosis in self.diagnoses
        ]
        shares = [
            {(one.effect, one.location): one.share_last for one in diagnosis.budget if one.effect}
            for diagnosis in self.diagnoses
        ]
        keys = dict.fromkeys(key for found in causes for key in found)

        def weight(key: tuple[str, str]) -> tuple[int, float]:
            sizes = [share.get(key) or 0.0 for share in shares]
            return -sum(key in found for found in causes), -max(sizes)

        rows: list[ComparedValue] = []
        for key in sorted(keys, key=weight):
            found = [one.get(key) for one in causes]
            names = dict.fromkeys(name for cause in found if cause is not None for name in cause.parameters)
            for name in names:
                fitted = [None if cause is None else cause.parameters.get(name) for cause in found]
                unit = next(one.unit for one in fitted if one is not None)
                rows.append(
                    ComparedValue(
                        *key,
                        name,
                        unit,
                        tuple(None if one is None else one.value for one in fitted),
                        tuple(None if one is None else one.std for one in fitted),
                        tuple(share.get(key) for share in shares),
                    )
                )
        return tuple(rows)

    @property
    def numbers(self) -> tuple[ComparedValue, ...]:
        """Numbers of the nominal model that a diagnosis corrects."""
        given = [{one.name: one for one in diagnosis.model_numbers} for diagnosis in self.diagnoses]
        rows = []
        for name in dict.fromkeys(name for numbers in given for name in numbers):
            found = [numbers.get(name) for numbers in given]
            first = next(one for one in found if one is not None)
            rows.append(
                ComparedValue(
                    "",
                    first.location,
                    name,
                    first.unit,
                    tuple(None if one is None else one.value for one in found),
                    tuple(None if one is None else one.std for one in found),
                    tuple(None for _ in found),
                )
            )
        return tuple(rows)


def read_comparison(folders: Sequence[Path]) -> DiagnosisComparison:
    """Read diagnoses to be compared.

    Args:
        folders: Folders of diagnoses, or their files diagnosis.json; at least two.

    Raises:
        InputError: There are fewer than two, or one is no diagnosis.
    """
    if len(folders) < 2:
        raise InputError(
            "one diagnosis was given; give at least two folders that `flexros diagnose` wrote", "diagnosis"
        )
    files = [folder / DIAGNOSIS if folder.is_dir() else folder for folder in folders]
    return DiagnosisComparison(tuple(_names(files)), tuple(map(read_diagnosis, files)))


def read_diagnosis(file: Path) -> Diagnosis:
    """Read a diagnosis.

    Args:
        file: Its diagnosis.json.

    Raises:
        InputError: It is no diagnosis.
    """
    return validate(Diagnosis, read_json(file, LARGEST), str(file))


def _found(diagnosis: Diagnosis) -> tuple[Cause, ...]:
    return () if diagnosis.verdict == "no_gap" else reported_causes(diagnosis)


def _names(files: Sequence[Path]) -> Iterator[str]:
    """Name diagnoses by their folders, or by their paths where folders have the same name."""
    folders = [file.absolute().parent for file in files]
    short = [folder.name for folder in folders]
    for folder, name in zip(folders, short, strict=True):
        yield name if short.count(name) == 1 else str(Path(*folder.parts[-2:]))
