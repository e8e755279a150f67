"""Elements of a report: sections, each made of blocks of text, tables and pictures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Generic, TypeAlias, TypeVar

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from flexros.arrays import FloatArray

FACTORS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
"""Magnifications that a reader can choose."""


@dataclass(frozen=True)
class Paragraph:
    """A paragraph of plain text; `lead` for the verdict at the top, `note` for small print."""

    text: str
    style: str = ""


@dataclass(frozen=True)
class Heading:
    """A heading within a section."""

    text: str


@dataclass(frozen=True)
class Listing:
    """Text of a file or a command, verbatim, with a button that copies it.

    Attributes:
        text: The text.
        caption: One sentence that describes it.
    """

    text: str
    caption: str


@dataclass(frozen=True)
class Tiles:
    """The main figures, each as name, value, unit and one line below."""

    items: tuple[tuple[str, str, str, str], ...]


@dataclass(frozen=True)
class TextTable:
    """A table of texts; columns after `left` are figures and right-aligned.

    Attributes:
        header: Heading of each column.
        rows: The rows; a row of one cell is a heading within the table.
        caption: One sentence that describes it.
        left: Number of left-aligned columns.
    """

    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str
    left: int = 1


@dataclass(frozen=True, eq=False)
class MagnifiedCurve:
    """A line of a picture that is drawn at base + factor * deviation.

    Attributes:
        trace: Index of the line in the picture.
        base: Points without error, in the units of the picture, shape (n, 2).
        deviation: Error at each point, in the units of the picture, shape (n, 2).
    """

    trace: int
    base: FloatArray
    deviation: FloatArray


@dataclass(frozen=True, eq=False)
class MovingLine:
    """A line in space that the reader plays, drawn at base + factor * deviation of the instant.

    Attributes:
        trace: Index of the line in the picture.
        time: Instants [s], shape (n,).
        base: Points without deviation at each instant [m], shape (n, n_points, 3).
        deviation: What is magnified [m], shape (n, n_points, 3).
    """

    trace: int
    time: FloatArray
    base: FloatArray
    deviation: FloatArray


@dataclass(frozen=True, eq=False)
class Picture:
    """An interactive picture.

    Attributes:
        figure: The picture.
        caption: Caption; "{factor}" is replaced by the magnification.
        magnified: Lines whose error the reader can magnify, drawn at `factor` initially, one of `FACTORS`.
        factor: Initial magnification.
        moving: A line that is played over time; its deviation can be magnified.
    """

    figure: go.Figure
    caption: str
    magnified: tuple[MagnifiedCurve, ...] = ()
    factor: int = 1
    moving: MovingLine | None = None


@dataclass(frozen=True)
class Folded:
    """Blocks for a second look, hidden below one line until the reader opens them.

    Attributes:
        summary: The line: what is inside, and how much of it.
        blocks: The blocks.
    """

    summary: str
    blocks: tuple[Block, ...]


Block: TypeAlias = "Paragraph | Heading | Listing | Tiles | TextTable | Picture | Folded"


Shown = TypeVar("Shown", contravariant=True)
"""Subject of a report: runs, an identification, a diagnosis."""


class AbstractSection(ABC, Generic[Shown]):
    """One section of a report.

    How to add a section: write a class in a module of its own that
    1. sets `title`, the heading;
    2. implements `blocks`, which converts the subject into blocks and returns none where the section does not apply;
    3. takes every figure from the subject and computes none of its own, so that report, table and JSON agree;
    4. is listed, in order of appearance, in the module `write` of the same folder.
    """

    title: ClassVar[str]

    @abstractmethod
    def blocks(self, shown: Shown, /) -> tuple[Block, ...]:
        """Return the content of the section.

        Args:
            shown: The runs, at least one, or the result of an identification or diagnosis.

        Returns:
            Blocks in order; none where the section does not apply.
        """
