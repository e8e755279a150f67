"""Warnings that come from the responses and from the fit themselves."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from flexros.identify.graybox.fit import GrayBoxFit
    from flexros.identify.graybox.problem import GrayBoxProblem


def own_warnings(problem: GrayBoxProblem, found: GrayBoxFit) -> tuple[str, ...]:
    """Collect warnings of responses and fit; those that differ in numbers only are told once.

    Args:
        problem: What was fitted.
        found: Where the fit ended.

    Returns:
        One sentence each.
    """
    alike: dict[str, list[str]] = {}
    for response in problem.responses:
        for text in dict.fromkeys(response.warnings):
            alike.setdefault(re.sub(r"[\d.]+", "#", text), []).append(text)
    texts = []
    for same in alike.values():
        others = len(set(same)) - 1
        texts.append(same[0] if not others else f"{same[0]} (alike in {others} more position{'s' * (others > 1)})")
    if not found.converged:
        texts.append(f"The fit did not converge: {found.message}.")
    bound = [name for name, at in zip(found.names, found.at_bound, strict=True) if at]
    if bound:
        texts.append(f"On a bound of the search: {', '.join(bound)}.")
    return tuple(texts)
