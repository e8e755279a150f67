"""Section: the gap as a budget, divided among effects, and the unexplained rest by joint and regime."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.gap.report.how_far import AFTER, BEFORE
from flexros.gap.report.words import budget_words, capital, interval_words, share_words
from flexros.gap.where.regimes import REGIMES
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    import plotly.graph_objects as go

    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import BudgetShare, Diagnosis, ModelNumber, Unexplained

FEWEST = 2
"""Effects from which a waterfall is drawn."""


class BudgetSection(AbstractSection["DiagnosisResult"]):
    """Bars of the shares, shares of the effects, the rest, and wrong numbers of the model."""

    title: ClassVar[str] = "The budget of the gap"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return picture and tables; nothing where no effect was found."""
        diagnosis = result.diagnosis
        if not diagnosis.budget:
            return ()
        blocks: list[Block] = [
            Paragraph(
                "Each share is of the gap on held-out data. Added first: what closes when the effect alone is put on "
                "the nominal model. Removed last: what opens when it alone is taken from the repaired model. The two "
                "differ where effects overlap."
            )
        ]
        if sum(share.effect is not None for share in diagnosis.budget) >= FEWEST:
            blocks.append(Picture(_bars(diagnosis), "Share of the gap by effect, removed last, and what is left."))
        blocks.append(_shares(diagnosis.budget))
        if diagnosis.unexplained:
            blocks.append(_rest(diagnosis.unexplained))
        if diagnosis.model_numbers:
            blocks.append(_numbers(diagnosis.model_numbers))
        return tuple(blocks)


def _bars(diagnosis: Diagnosis) -> go.Figure:
    """Draw effects of all joints, the largest first, and the rest; shares may overlap, so they are bars, not steps."""
    import plotly.graph_objects as go

    from flexros.report.theme import stacked

    effects = [share for share in diagnosis.budget if share.effect is not None]
    bars = [(capital(budget_words(share)), share.share_last or 0.0, BEFORE) for share in effects]
    rest = [(f"left at {one.joint}", one.share, AFTER) for one in diagnosis.unexplained if one.regime == "all"]
    shown = [*bars, *rest]
    figure = stacked([""], height=28 * len(shown) + 60)
    figure.add_trace(
        go.Bar(
            x=[max(share, 0.0) for _, share, _ in shown],
            y=[name for name, _, _ in shown],
            orientation="h",
            marker={"color": [colour for _, _, colour in shown]},
            text=[share_words(max(share, 0.0)) for _, share, _ in shown],
            textangle=0,
            hovertemplate="%{y}: %{x:.1%}<extra></extra>",
        )
    )
    figure.update_yaxes(autorange="reversed", showgrid=False)
    figure.update_xaxes(title_text="share of the gap", tickformat=".0%")
    figure.update_layout(margin={"l": 240, "t": 16}, showlegend=False, bargap=0.3)
    return figure


def _shares(budget: tuple[BudgetShare, ...]) -> TextTable:
    rows = tuple(
        (
            capital(budget_words(share)),
            share.joint,
            share.cause_class,
            "-" if share.share_first is None else share_words(share.share_first) + interval_words(share.interval),
            "-" if share.share_last is None else share_words(share.share_last),
        )
        for share in budget
    )
    return TextTable(("Effect", "joint", "class", "added first", "removed last"), rows, "Shares of the gap.", left=3)


def _rest(unexplained: tuple[Unexplained, ...]) -> TextTable:
    rows = tuple((one.joint, REGIMES[one.regime].phrase or "all", share_words(one.share)) for one in unexplained)
    caption = "What the repaired model leaves, as a share of the gap. Regimes overlap."
    return TextTable(("Joint", "motion", "share"), rows, caption, left=2)


def _numbers(numbers: tuple[ModelNumber, ...]) -> TextTable:
    rows = tuple(
        (one.name, number(one.nominal, 4), f"{number(one.value, 4)} ± {number(one.std, 2)}", one.unit)
        for one in numbers
    )
    caption = "Numbers of the nominal model that are wrong beyond their tolerance."
    return TextTable(("Parameter", "nominal", "fitted", "unit"), rows, caption)
