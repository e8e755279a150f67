"""What a section of an identification report is."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from flexros.analysis.report.base import Block
    from flexros.identify.report.result import IdentificationResult


class AbstractIdentificationSection(ABC):
    """One section of the report of an identification.

    A new section is a class in a file of its own that
    1. sets `title`, the heading;
    2. implements `blocks`, which turns a result into blocks and returns none where the result holds nothing for it;
    3. takes every figure from the result, so that report, table and JSON agree;
    4. is listed in `write.SECTIONS`, in order of appearance.
    """

    title: ClassVar[str]

    @abstractmethod
    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return the content of the section.

        Args:
            result: What was identified.

        Returns:
            Blocks in order; none where the section does not apply.
        """
