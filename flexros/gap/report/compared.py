"""Several diagnoses on one page, and as tables in a terminal: verdicts, sizes of effects, numbers of the model."""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING

from rich.table import Table

from flexros.atomic_file import write_result
from flexros.gap.report.figure_words import gap_closed_words, gap_words, share_words, shows
from flexros.gap.report.verdict import verdict_sentence
from flexros.gap.report.words import capital, effect_words, first_few, listed, location_words, parameter_words
from flexros.gap.schema import CauseParameter
from flexros.report.base import Block, Heading, Paragraph, Picture, TextTable
from flexros.report.origin import folded_origin
from flexros.report.page import Chapter, page_html
from flexros.report.theme import run_colour, stacked

if TYPE_CHECKING:
    from pathlib import Path

    from flexros.gap.report.comparison import ComparedValue, DiagnosisComparison
    from flexros.gap.schema import Diagnosis

SURE = 0.01
"""Probability of a difference by chance below which values are said to differ [1] (chosen)."""
_MOST_BARS = 10
"""Effects in the picture (chosen)."""
_LABEL = 20
"""Letters of a label in a line (chosen): it fits a phone."""
_LEAST_SHARE = 0.001
"""Share of the gap from which an effect is drawn [1] (chosen)."""
_NONE = "\u2013"


def overview(comparison: DiagnosisComparison) -> TextTable:
    """Return the table of logs, verdicts and gaps."""
    rows = tuple(_overview_row(name, one) for name, one in zip(comparison.names, comparison.diagnoses, strict=True))
    header = ("Diagnosis", "log", "verdict", "before", "after", "closed")
    return TextTable(header, rows, "The gap on data that nothing was fitted to; 1 is noise alone.", left=3)


def _overview_row(name: str, diagnosis: Diagnosis) -> tuple[str, ...]:
    gap = diagnosis.gap
    closed = _NONE if gap.closed_fraction is None or not shows(gap) else gap_closed_words(gap)
    after = _NONE if gap.after is None else gap_words(gap.after)
    log = str(diagnosis.provenance.get("log", ""))
    return name, log, diagnosis.verdict.replace("_", " "), gap_words(gap.before), after, closed


def values_table(comparison: DiagnosisComparison, rows: tuple[ComparedValue, ...], caption: str) -> TextTable:
    """Return the table of values by diagnosis, the last column saying whether they differ.

    Args:
        comparison: The diagnoses.
        rows: Its effects or numbers.
        caption: One sentence that describes the table.
    """
    cells = tuple((_name(row), *_values(row), _verdict(row)) for row in rows)
    return TextTable(("Effect or number", *comparison.names, "same?"), cells, caption)


def _name(row: ComparedValue) -> str:
    if not row.effect:
        return row.name
    parameter = "" if row.name in ("level", "relative") else f", {row.name.replace('_', ' ')}"
    return f"{capital(effect_words(row.effect))} {location_words(row.location)}{parameter}"


def _values(row: ComparedValue) -> list[str]:
    return [
        _NONE
        if value is None
        else parameter_words(row.name, CauseParameter(value=value, std=std or 0.0, unit=row.unit))
        for value, std in zip(row.values, row.stds, strict=True)
    ]


def _verdict(row: ComparedValue) -> str:
    if row.found < len(row.values):
        return f"in {row.found} of {len(row.values)}"
    if row.p_same is None:
        return _NONE
    return "differ" if row.p_same < SURE else "yes"


def sentence(comparison: DiagnosisComparison) -> str:
    """Say in how many diagnoses the same effects were found, and which sizes differ."""
    rows = comparison.effects
    keys = dict.fromkeys((row.effect, row.location) for row in rows)
    if not keys:
        return f"None of the {len(comparison.names)} diagnoses found an effect."
    common = {(row.effect, row.location) for row in rows if row.found == len(row.values)}
    differ = list(dict.fromkeys(_short(row) for row in (*rows, *comparison.numbers) if _verdict(row) == "differ"))
    every = "both" if len(comparison.names) == 2 else f"all {len(comparison.names)}"
    text = f"{len(common)} of {len(keys)} effects were found in {every} diagnoses"
    if not common:
        return f"{text}."
    if not differ:
        return f"{text}, and their sizes agree within their standard deviations."
    return f"{text}. {capital(first_few(differ))} {'differ' if len(differ) > 1 else 'differs'} beyond their deviations."


def _short(row: ComparedValue) -> str:
    return f"{effect_words(row.effect)} {location_words(row.location)}" if row.effect else row.name


def compared_page(comparison: DiagnosisComparison) -> str:
    """Return the comparison as an HTML page that opens offline."""
    effects, numbers = comparison.effects, comparison.numbers
    said = tuple(
        block
        for name, one in zip(comparison.names, comparison.diagnoses, strict=True)
        for block in (Heading(name), Paragraph(verdict_sentence(one)))
    )
    found: list[Block] = []
    picture = _shares(comparison)
    if picture is not None:
        found.append(picture)
    if effects:
        caption = (
            "Fitted sizes with one standard deviation. Same: whether values that far apart would come about by chance "
            f"in more than {share_words(SURE)} of repetitions."
        )
        found.append(values_table(comparison, effects, caption))
    wrong: tuple[Block, ...] = ()
    if numbers:
        wrong = (values_table(comparison, numbers, "Parameters that the diagnoses replace in the model."),)
    made = folded_origin(
        {name: one.provenance for name, one in zip(comparison.names, comparison.diagnoses, strict=True)},
        "diagnosis",
        "diagnoses",
    )
    chapters = (
        Chapter("", (Paragraph(sentence(comparison), "lead"), overview(comparison))),
        Chapter("Effects", tuple(found)),
        Chapter("Parameters of the model", wrong),
        Chapter("What each diagnosis says", said),
        Chapter("Provenance", (made,) if made else ()),
    )
    logs = listed(list(dict.fromkeys(str(one.provenance.get("log", "a log")) for one in comparison.diagnoses)))
    title = f"Comparison of {len(comparison.names)} diagnoses"
    return page_html(title, f"Logs {logs}", [chapter for chapter in chapters if chapter.blocks], packed=True)


def write_compared(comparison: DiagnosisComparison, file: Path) -> None:
    """Write the page.

    Args:
        comparison: The diagnoses.
        file: The HTML file; one that exists is replaced once the new one is complete.

    Raises:
        InputError: The file cannot be written.
    """
    write_result(file, compared_page(comparison), "report")


def terminal_tables(comparison: DiagnosisComparison) -> tuple[Table, ...]:
    """Return the tables for a terminal: verdicts, effects, numbers of the model."""
    tables = [overview(comparison)]
    tables += [values_table(comparison, rows, "") for rows in (comparison.effects, comparison.numbers) if rows]
    return tuple(_terminal(table) for table in tables)


def _terminal(table: TextTable) -> Table:
    made = Table()
    for index, heading in enumerate(table.header):
        made.add_column(heading, justify="left" if index < table.left else "right")
    for row in table.rows:
        made.add_row(*row)
    return made


def _shares(comparison: DiagnosisComparison) -> Picture | None:
    """Draw the shares of the gap by effect, a bar for each diagnosis; None where there is no budget."""
    import plotly.graph_objects as go

    rows = {(row.effect, row.location): row for row in comparison.effects}.values()
    drawn = [row for row in rows if max((share or 0.0 for share in row.shares), default=0.0) >= _LEAST_SHARE]
    if not drawn:
        return None
    drawn = drawn[:_MOST_BARS]
    names = [
        "<br>".join(wrap(f"{capital(effect_words(row.effect))} {location_words(row.location)}", _LABEL))
        for row in drawn
    ]
    figure = stacked([""], height=(12 * max(len(comparison.names), 2) + 16) * len(drawn) + 40)
    for index, name in enumerate(comparison.names):
        shares = [row.shares[index] for row in drawn]
        figure.add_trace(
            go.Bar(
                x=[None if share is None else 100 * share for share in shares], y=names, orientation="h", name=name,
                marker={"color": run_colour(index)}, hovertemplate="%{y}: %{x:.3g} %<extra></extra>",
            )
        )  # fmt: skip
    figure.update_yaxes(autorange="reversed", showgrid=False)
    figure.update_xaxes(title_text="share of the gap [%]")
    figure.update_layout(margin={"l": 150}, barmode="group", bargap=0.3)
    return Picture(figure, "Share of the gap that opens when the effect alone is taken from the repaired model.")
