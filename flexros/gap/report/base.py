"""What a section of the report of a diagnosis is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from flexros.analysis.report.base import Block
    from flexros.gap.result import DiagnosisResult


class AbstractDiagnosisSection(ABC):
    """One section of the report of a diagnosis.

    A new section is a class in a file of its own that
    1. sets `title`, the heading;
    2. implements `blocks`, which turns a result into blocks and returns none where the result holds nothing for it;
    3. takes every figure from the result, so that report, terminal and JSON agree;
    4. is listed in `write.SECTIONS`, in order of appearance.
    """

    title: ClassVar[str]

    @abstractmethod
    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return the content of the section.

        Args:
            result: What was found.

        Returns:
            Blocks in order; none where the section does not apply.
        """
