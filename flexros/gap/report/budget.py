"""Section: the gap as a budget, divided among effects, and the unexplained rest by joint, motion and band."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from flexros.effects.left_out import RotorInertia, ToolLoad
from flexros.gap.report.figure_words import band_words, share_interval_words, share_words, signed_share_words
from flexros.gap.report.waterfall import shown, waterfall_figure
from flexros.gap.report.words import capital, clear_words, named_at, number_words
from flexros.gap.where.regimes import REGIMES
from flexros.report.base import AbstractSection, Block, Paragraph, Picture, TextTable
from flexros.report.number_text import number

if TYPE_CHECKING:
    from flexros.gap.result import DiagnosisResult
    from flexros.gap.schema import BudgetShare, Diagnosis, ModelNumber, Unexplained

FEWEST = 2
"""Effects from which a waterfall is drawn."""
WORSE_ALONE = "worse alone"
"""What stands in place of a share added first that is clearly below zero."""
WHY_WORSE = "the effect has the size at which it explains the log together with the others"
WORSE_WITHOUT = "worse without it"
"""What stands in place of a share removed last above the whole gap."""
WHY_NEEDED = "the other effects without this one predict worse than the nominal model"
LITTLE_WORSE = -0.005
"""Share below zero that is written as none [1]: less than half a per cent."""
_VISIBLE = 0.0005
"""Share of the gap from which a band is written [1] (chosen)."""


class BudgetSection(AbstractSection["DiagnosisResult"]):
    """Waterfall by joint, shares of the effects, the rest, and wrong numbers of the model."""

    title: ClassVar[str] = "The budget of the gap"

    def blocks(self, result: DiagnosisResult) -> tuple[Block, ...]:
        """Return picture and tables; nothing where no effect was found."""
        diagnosis = result.diagnosis
        if not diagnosis.budget:
            return ()
        blocks: list[Block] = []
        if draws(diagnosis):
            blocks.append(Picture(waterfall_figure(diagnosis), _caption(diagnosis, result.robot.joint_names)))
        blocks += [Paragraph(_introduction(diagnosis)), _shares(diagnosis)]
        if diagnosis.unexplained:
            blocks.append(_rest(diagnosis.unexplained))
        if diagnosis.model_numbers:
            blocks.append(_numbers(diagnosis.model_numbers))
        return tuple(blocks)


def draws(diagnosis: Diagnosis) -> bool:
    """Return whether a budget is worth a picture: several effects, or one that leaves something."""
    effects = sum(share.effect is not None for share in diagnosis.budget)
    enough = effects >= FEWEST or (effects > 0 and diagnosis.verdict == "partly_explained")
    return enough and bool(shown(diagnosis))


def _caption(diagnosis: Diagnosis, joints: tuple[str, ...]) -> str:
    left_out = [joint for joint in joints if joint not in {one.joint for one in shown(diagnosis)}]
    hidden = f" {', '.join(left_out)}: under 1 % of the gap." if left_out else ""
    return (
        "The gap on held-out data at each joint, as shares of the gap of all joints: with the nominal model, what each "
        "effect closes (blue) or opens there (orange), and what is left. Effects are added in the order of what they "
        "close; one takes what those after it close as well. Effects that act against each other at a joint are one "
        f"row where only together they close a part of the gap there. 0 is the floor, noise alone.{hidden}"
    )


def _introduction(diagnosis: Diagnosis) -> str:
    text = (
        "Each share is of the gap on held-out data. Added first: what closes when the effect alone is put on the "
        "nominal model. Removed last: what opens when it alone is taken from the repaired model. The two differ where "
        "effects overlap. Parameters that are known with a tolerance are fitted again each time."
    )
    if any(is_worse_alone(share) for share in diagnosis.budget):
        text += f" {capital(WORSE_ALONE)}: {WHY_WORSE}, and without these the prediction is worse with it than without."
    if any(is_worse_without(share) for share in diagnosis.budget):
        text += f" {capital(WORSE_WITHOUT)}: {WHY_NEEDED}."
    firsts = [share.share_first for share in diagnosis.budget if not is_worse_alone(share)]
    lasts = [share.share_last for share in diagnosis.budget]
    if any(share is not None and share < 0 for share in (*firsts, *lasts)):
        text += (
            " A share below zero: the prediction is worse with the effect than without, as this log moves in another "
            "way, or as others stand for it."
        )
    if any(share.share_first is None for share in diagnosis.budget):
        text += " No share added first: without this number the model predicts nothing, so the gap begins with it."
    return text


def _shares(diagnosis: Diagnosis) -> TextTable:
    budget = diagnosis.budget
    sizes = _sizes(diagnosis)
    rows: list[tuple[str, ...]] = []
    for joint in dict.fromkeys(share.joint for share in budget):
        rows.append((joint,))
        for share in (share for share in budget if share.joint == joint):
            size = sizes.get((share.effect or "", share.location), "")
            name = named_at(joint, share.effect, share.location) if share.effect else f"all {share.cause_class}"
            first = _share(share.share_first) + share_interval_words(share.interval)
            first = WORSE_ALONE if is_worse_alone(share) else first
            last = _share(share.share_last) + share_interval_words(share.interval_last)
            last = WORSE_WITHOUT if is_worse_without(share) else last
            rows.append((capital(name), size, first, last))
    caption = "Shares of the gap, with 95 % intervals."
    return TextTable(("Effect", "size", "added first", "removed last"), tuple(rows), caption, left=2)


def _sizes(diagnosis: Diagnosis) -> dict[tuple[str, str], str]:
    """Write the sizes of causes, and of rotors and a load that the model lacks, by effect and location."""
    lacked: dict[tuple[str, str], list[str]] = {}
    for one in diagnosis.model_numbers:
        owner, _, name = one.name.partition(".")
        size = number_words(one)
        if owner == ToolLoad.name:
            lacked.setdefault((ToolLoad.name, one.location), []).append(f"{name} {size}")
        elif name == "inertia" and one.nominal == 0:
            lacked[RotorInertia.name, one.location] = [size]
    causes = {(cause.effect, cause.location): clear_words(cause.effect, cause.parameters) for cause in diagnosis.causes}
    return {key: ", ".join(texts) for key, texts in lacked.items()} | causes


def is_worse_alone(share: BudgetShare) -> bool:
    """Return whether the nominal model clearly predicts worse with an effect alone."""
    first = share.share_first
    return first is not None and first < LITTLE_WORSE and (share.interval is None or share.interval[1] < 0)


def is_worse_without(share: BudgetShare) -> bool:
    """Return whether the others without an effect predict worse than the nominal model."""
    return share.share_last is not None and share.share_last > 1.0


def _share(share: float | None) -> str:
    if share is None:
        return "-"
    return share_words(share) if share >= 0 else signed_share_words(share)


def _rest(unexplained: tuple[Unexplained, ...]) -> TextTable:
    """List the rest by joint and motion, divided among the bands in which there is any."""
    bands = list(dict.fromkeys(part.band_hz for one in unexplained for part in one.bands if part.share >= _VISIBLE))
    bands.sort()
    top = max((part.band_hz[1] for one in unexplained for part in one.bands), default=0.0)
    rows: list[tuple[str, ...]] = []
    for joint in dict.fromkeys(one.joint for one in unexplained):
        rows.append((joint,))
        for one in (one for one in unexplained if one.joint == joint):
            by_band = {part.band_hz: part.share for part in one.bands}
            cells = (_part(by_band.get(band, 0.0)) for band in bands)
            rows.append((REGIMES[one.regime].phrase or "all", _part(one.share), *cells))
    header = ("Motion", "share", *(band_words(band, top) for band in bands))
    caption = (
        "What the repaired model leaves, as shares of the gap, by frequency of the prediction errors. Motions overlap."
    )
    return TextTable(header, tuple(rows), caption)


def _part(share: float) -> str:
    return f"{100 * share:.1f} %" if share >= _VISIBLE else "-"


def _numbers(numbers: tuple[ModelNumber, ...]) -> TextTable:
    rows = tuple((one.name, number(one.nominal, 4), number_words(one, unit=False), one.unit) for one in numbers)
    caption = "Parameters of the nominal model that are wrong beyond their tolerance."
    return TextTable(("Parameter", "nominal", "fitted", "unit"), rows, caption)
