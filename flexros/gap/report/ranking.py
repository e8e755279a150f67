"""Section: all candidate effects in their order with their probabilities, together with 'nothing'."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.figure_words import share_words
from flexros.gap.report.words import (
    LIKELY,
    capital,
    first_few,
    named,
    parameters_words,
    partners_words,
    undetermined_words,
)
from flexros.gap.schema import same_effect
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.colours import FLOOR, REPAIRED, RIVAL
from flexros.report.number_text import number

if TYPE_CHECKING:
    from collections.abc import Sequence

    import plotly.graph_objects as go

    from flexros.gap.result import DiagnosisResult, RankedCandidate
    from flexros.gap.schema import Diagnosis, ToleranceSensitivity

NOTHING = "nothing"
_MOST_BARS, _MOST_ROWS = 10, 15
"""Effects in the picture and in the table, if no more are causes (chosen)."""
_CAUSE, _RIVAL, _REST, _NONE = REPAIRED, RIVAL, FLOOR, "#009e73"
"""Colours of causes, of effects in an ambiguity group, of the others, and of 'nothing'."""


class RankingSection(AbstractSection["DiagnosisResult"]):
    """Bars of probabilities, ambiguity groups, table of the evidence."""

    title: ClassVar[str] = "Which effect"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return sentence, bars, groups and table."""
        if not result.ranking:
            return (Paragraph("No effects were compared: nothing exceeds noise and tolerance."),)
        groups = [
            Paragraph(
                f"This log cannot distinguish {first_few([named(location) for location in group], 'from', 6)}."
                if len(group) > 1
                else f"This log does not show whether there is {named(group[0])}.",
                "warning",
            )
            for group in result.diagnosis.ambiguity_groups
        ]
        open_sizes = [Paragraph(f"{text}.", "warning") for text in undetermined_words(result.diagnosis.causes)]
        tolerances = _tolerances(result.diagnosis.tolerance_sensitivity)
        return (
            Paragraph(_sentence(result)),
            _picture(result),
            *groups,
            *open_sizes,
            *tolerances,
            table_of_ranking(result),
        )


def _tolerances(rows: tuple[ToleranceSensitivity, ...]) -> tuple[Block, ...]:
    """Show the probabilities with halved and doubled tolerances; nothing where none were guessed."""
    if not rows:
        return ()
    changing = any(row.changes for row in rows)
    caption = "Probability of each effect with all tolerances of the nominal model halved, as stated, and doubled. " + (
        "A name that changes is ambiguous." if changing else "No name changes."
    )
    cells = tuple(
        (capital(named(row)), *(share_words(share) for share in (row.halved, row.stated, row.doubled))) for row in rows
    )
    return (TextTable(("Effect", "halved", "stated", "doubled"), cells, caption),)


def _sentence(result: DiagnosisResult) -> str:
    count = len(result.ranking)
    unknown = (
        " Here none of them explains the gap, so none is probable: the cause is another effect, or several together."
    )
    return (
        f"The explanations that were fitted to the end have {count} effect{'s' * (count > 1)} at their locations. They "
        "and 'nothing' are compared by their gain beyond what their number of parameters gains by chance. The "
        "probability is that of the effect "
        "being part of the truth; where several causes act together, several are high."
        f"{unknown if result.diagnosis.verdict == 'unknown_effect' else ''}"
    )


def _picture(result: DiagnosisResult) -> Picture:
    ranked = first_of_ranking(result, _MOST_BARS)
    names = [*(capital(named(candidate)) for candidate in ranked), capital(NOTHING)]
    values = [*(candidate.probability for candidate in ranked), result.null_probability]
    colours = [*(_colour(candidate, result.diagnosis) for candidate in ranked), _NONE]
    figure = _bars(names, values, colours)
    more = len(result.ranking) - len(ranked)
    ones = "one is" if more == 1 else "ones are"
    rest = f" {more} less probable {ones} left out." if more > 0 else ""
    return Picture(
        figure,
        "Probability of each effect. Blue: reported as a cause. Orange: in a group that this log cannot distinguish. "
        f"Green: no effect at all.{rest}",
    )


def first_of_ranking(result: DiagnosisResult, most: int) -> Sequence[RankedCandidate]:
    """Return the first effects, and all further causes and rivals that the log does not tell from them.

    Args:
        result: The diagnosis.
        most: Effects that are returned if no more are causes or rivals.
    """
    rivals = [one for group in result.diagnosis.ambiguity_groups for one in group]
    return [
        one
        for rank, one in enumerate(result.ranking)
        if rank < most or one.probability >= LIKELY or any(same_effect(one, rival) for rival in rivals)
    ]


def explanation_of(candidate: RankedCandidate) -> frozenset[tuple[str, str]]:
    """Return the effects, with their locations, that the figures of a candidate are of."""
    others = ((one.effect, one.location) for one in candidate.together_with)
    return frozenset([(candidate.effect, candidate.location), *others])


def first_of_explanations(ranked: Sequence[RankedCandidate]) -> list[bool]:
    """Return which candidates are the first of their explanation, whose figures would only be repeated below."""
    explanations = [explanation_of(candidate) for candidate in ranked]
    return [explanation not in explanations[:rank] for rank, explanation in enumerate(explanations)]


def _bars(names: Sequence[str], values: Sequence[float], colours: Sequence[str]) -> go.Figure:
    import plotly.graph_objects as go

    from flexros.report.theme import stacked

    figure = stacked([""], height=30 * len(names) + 30)
    figure.add_trace(
        go.Bar(
            x=[100 * value for value in values],
            y=list(names),
            orientation="h",
            marker={"color": list(colours)},
            text=[share_words(value) for value in values],
            textposition="outside",
            cliponaxis=False,
            hovertemplate="%{y}: %{x:.3g} %<extra></extra>",
        )
    )
    figure.update_yaxes(autorange="reversed", showgrid=False)
    figure.update_xaxes(title_text="probability [%]", range=[0, 109], tickvals=[0, 25, 50, 75, 100])
    figure.update_layout(margin={"l": 290, "t": 16}, showlegend=False, bargap=0.35)
    return figure


def _colour(candidate: RankedCandidate, diagnosis: Diagnosis) -> str:
    if any(same_effect(candidate, location) for group in diagnosis.ambiguity_groups for location in group):
        return _RIVAL
    reported = diagnosis.verdict in ("explained", "partly_explained", "ambiguous") and any(
        same_effect(candidate, cause) for cause in diagnosis.causes
    )
    return _CAUSE if reported and candidate.probability >= LIKELY else _REST


def table_of_ranking(result: DiagnosisResult) -> TextTable:
    """Return the first effects in their order with their fitted parameters and evidence."""
    unseen = any(candidate.holdout_gain is not None for candidate in result.ranking)
    opened = {(share.effect, share.location): share.share_last for share in result.diagnosis.budget}
    ranked = first_of_ranking(result, _MOST_ROWS)
    rows = tuple(
        (
            capital(named(candidate))
            + (f" (with {partners_words(candidate)})" if first and candidate.together_with else ""),
            parameters_words(candidate.parameters),
            _short(candidate.probability),
            *([_opened(opened.get((candidate.effect, candidate.location)))] if opened else []),
            *(_figures(candidate, unseen) if first else [""] * (3 + unseen)),
        )
        for candidate, first in zip(ranked, first_of_explanations(ranked), strict=True)
    )
    of_explanation = ("gain", "penalty", *(["gain, held out"] if unseen else []), "leaves")
    header = ("Effect", "fitted (± std)", "probability", *(["removed last"] if opened else []), *of_explanation)
    last = "Removed last: share of the held-out gap that opens without it. " if opened else ""
    held_out = "gain, held out: the same in held-out data, for the first few; " if unseen else ""
    caption = (
        f"{last}Gain: twice the gain in log-likelihood over the nominal model in the fitted log; penalty: cost of its "
        f"parameters; {held_out}leaves: share of the excess over noise that remains in the fitted log. Of effects that "
        "explain the log together these are written at the first one."
    )
    return TextTable(header, rows, caption, left=2)


def _figures(candidate: RankedCandidate, unseen: bool) -> list[str]:
    """Write the figures of an explanation: gain, penalty, gain in held-out data where `unseen`, and remainder."""
    held_out = [number(candidate.holdout_gain, 4)] if unseen else []
    return [number(candidate.gain, 4), number(candidate.penalty, 3), *held_out, _share(candidate.remainder)]


def _opened(share: float | None) -> str:
    """Write what opens without an effect, as ">100 %" where the others predict worse than the nominal model."""
    return ">100\u00a0%" if share is not None and share > 1.0 else _share(share)


def _share(share: float | None) -> str:
    return "-" if share is None else _short(share)


def _short(share: float) -> str:
    """Write a share briefly."""
    return share_words(share).replace("under ", "<").replace("over ", ">").replace(" %", "\u00a0%")
