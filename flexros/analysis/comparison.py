"""Methods and cases compared with quoted figures, like the table of the circle test in the thesis."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from flexros.report.number_text import number

if TYPE_CHECKING:
    from flexros.analysis.run_analysis import Analysis


@dataclass(frozen=True)
class QuotedFigure:
    """A published path error.

    Attributes:
        method: Name of the method, as in `MethodRun`.
        case: Name of the case, as in `MethodRun`.
        published: Published maximum path error [m]; None where none is published.
        reading: Maximum path error of an independent program based on our reading of the text [m]; None where none.
    """

    method: str
    case: str
    published: float | None
    reading: float | None


@dataclass(frozen=True, eq=False)
class MethodRun:
    """One run of a method in a case; of several runs of one case the worst is used.

    Attributes:
        method: Name of the method, e.g. "DAE".
        case: Name of the case, e.g. "load ±10 kg".
        analysis: The run, analysed.
    """

    method: str
    case: str
    analysis: Analysis


@dataclass(frozen=True)
class ComparisonRow:
    """One method in one case; errors are maximum path errors.

    Attributes:
        method: Name of the method.
        case: Name of the case.
        published: Published [m]; None where none.
        reading: Independent reading [m]; None where none.
        attained: Of this run, the worst if there are several [m]; None where there is no run.
    """

    method: str
    case: str
    published: float | None
    reading: float | None
    attained: float | None

    @property
    def deviation(self) -> float | None:
        """This run relative to the published figure, minus 1; None where one of them is missing."""
        return None if self.attained is None or not self.published else self.attained / self.published - 1.0

    def texts(self) -> tuple[str, str, str, str, str, str]:
        """Return the row as text: method, case, published, reading, this run [mm], deviation [%]."""
        sizes = [number(None if v is None else 1e3 * v, 3) for v in (self.published, self.reading, self.attained)]
        deviation = "-" if self.deviation is None else f"{1e2 * self.deviation:+.1f}"
        return (self.method, self.case, sizes[0], sizes[1], sizes[2], deviation)


HEADINGS = ("Method", "Case", "published [mm]", "our reading [mm]", "this run [mm]", "to published [%]")
"""Headings of `ComparisonRow.texts`."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """Runs by method and case, compared with quoted figures.

    Attributes:
        runs: The runs.
        quoted: The quoted figures.
        caveats: Sentences on the limits of the comparison.
    """

    runs: tuple[MethodRun, ...]
    quoted: tuple[QuotedFigure, ...] = ()
    caveats: tuple[str, ...] = ()

    @property
    def methods(self) -> tuple[str, ...]:
        """Methods in order of their first run."""
        return tuple(dict.fromkeys(run.method for run in self.runs))

    def rows(self) -> tuple[ComparisonRow, ...]:
        """Return the table: every method and case that was run, in order, then those that are only quoted."""
        quotes = {(quote.method, quote.case): quote for quote in self.quoted}
        keys = list(dict.fromkeys([*((run.method, run.case) for run in self.runs), *quotes]))
        methods = list(dict.fromkeys(method for method, _ in keys))
        keys.sort(key=lambda key: methods.index(key[0]))
        rows = []
        for key in keys:
            quote = quotes.get(key)
            paths = [run.analysis.path for run in self.runs if (run.method, run.case) == key]
            errors = [path.path.maximum for path in paths if path is not None]
            published, reading = (None, None) if quote is None else (quote.published, quote.reading)
            rows.append(ComparisonRow(*key, published, reading, max(errors, default=None)))
        return tuple(rows)

    def as_dict(self) -> dict[str, object]:
        """Return the table as plain numbers [m] and texts, ready for JSON."""
        return {
            "path_error_max_m": [
                {
                    "method": row.method,
                    "case": row.case,
                    "published": row.published,
                    "independent_reading": row.reading,
                    "this_run": row.attained,
                }
                for row in self.rows()
            ],
            "caveats": list(self.caveats),
        }
