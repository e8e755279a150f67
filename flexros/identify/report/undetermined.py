"""Section: what the experiment does not determine, and which experiment would."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.identify.report.remedies import Remedy, has_candidates, remedies
from flexros.report.base import AbstractSection, Block, Paragraph, TextTable
from flexros.report.number_text import number, percent

if TYPE_CHECKING:
    from flexros.identify.graybox.identifiability import Direction
    from flexros.identify.result import IdentificationResult

_HELPS = 0.7
"""An experiment that leaves more of the standard deviation than this share is reported to help little (chosen)."""


class UndeterminedSection(AbstractSection["IdentificationResult"]):
    """Combinations that the responses leave open, and the best further experiment for each."""

    title: ClassVar[str] = "What is not determined, and what would determine it"

    def blocks(self, result: IdentificationResult) -> tuple[Block, ...]:
        """Return a sentence per combination and the table of experiments; one sentence where all is determined."""
        proposals = remedies(result)
        directions = _directions(result.identifiability.directions)
        if not proposals:
            open_ones = directions or result.identifiability.names("weak")
            text = (
                "The experiment that would help is not known, because the responses have no covariance."
                if open_ones
                else _all_determined(result)
            )
            return (*directions, Paragraph(text))
        if result.much_missed:  # what noise allows is not what limits the result
            return (*directions, _table(proposals, result))
        return (*directions, _table(proposals, result), *_better_weights(proposals), *_hopeless(proposals))


def _all_determined(result: IdentificationResult) -> str:
    if not result.bias_signs:
        return "All parameters are determined; no further experiment is needed."
    return (
        "All parameters are determined as far as the errors of the responses go. More positions do not remove a "
        "model-form error. Identify with slow_motion, which keeps friction from changing its sign, with another "
        "amplitude, or with more parameters among the unknown ones."
    )


def _directions(directions: tuple[Direction, ...]) -> tuple[Paragraph, ...]:
    """List single parameters in one sentence, and each combination in one of its own."""
    single = [each.exponents[0][0] for each in directions if not each.determined]
    sentences = [Paragraph(each.sentence) for each in directions if each.determined]
    if len(single) > 1:
        sentences.insert(0, Paragraph(f"The responses hardly depend on {', '.join(single[:-1])} and {single[-1]}."))
    elif single:
        sentences.insert(0, Paragraph(next(each.sentence for each in directions if not each.determined)))
    return tuple(sentences)


def _table(found: tuple[Remedy, ...], result: IdentificationResult) -> TextTable:
    rows = tuple(
        (
            each.what,
            _place(each),
            number(each.frequency, 3),
            percent(each.now),
            percent(each.now * each.gain),
        )
        for each in found
    )
    where = f"{len(result.problem.responses)} measured positions"
    if result.design is not None and has_candidates(result):
        where = f"{len(result.design.candidates.gears)} candidate positions"
    unit = "rad" if all(unit == "rad" for unit in result.problem.responses[0].coordinate_units) else "rad or m"
    header = ("Parameters", f"position, gears [{unit}]", "most informative at [Hz]", "std now [%]", "std then [%]")
    caption = (
        f"The single further experiment that helps most, out of {where}, with as many blocks as the others. Standard "
        "deviations of the logarithm of the combination, of this fit and predicted."
    )
    return TextTable(header, rows, caption, left=2)


def _place(remedy: Remedy) -> str:
    """Name a position by its gears, or by its number where they are not known."""
    if remedy.position is not None and np.any(np.isnan(remedy.gears)):
        return f"measured position {remedy.position + 1}"
    return ", ".join(f"{value:.3g}" for value in remedy.gears + 0.0)


def _better_weights(found: tuple[Remedy, ...]) -> tuple[Paragraph, ...]:
    better = [
        f"{each.what} ({percent(each.optimal, 2)} instead of {percent(each.now, 2)} %)"
        for each in found
        if each.optimal < _HELPS * each.now
    ]
    if not better:
        return ()
    return (
        Paragraph(
            f"Optimal weights would reduce the standard deviations with the same responses: {', '.join(better)}."
        ),
    )


def _hopeless(found: tuple[Remedy, ...]) -> tuple[Paragraph, ...]:
    names = [each.what for each in found if each.gain > _HELPS]
    if not names:
        return ()
    text = (
        f"One more position of this kind helps little for {', '.join(names)}: the responses of the motors hardly "
        "depend on it anywhere. Repeat the experiment with a larger amplitude, more periods or a band around the "
        "frequency in the table, or measure the arm itself, for instance with accelerometers."
    )
    return (Paragraph(text),)
