"""What an identification found, in a few sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.analysis.figures_table import number

if TYPE_CHECKING:
    from flexros.identify.report.result import IdentificationResult

_AS_GOOD = 0.9
_MISSES = "because the model misses something"
_SEVERAL = ("values", "their fitted values", "ones")


def verdict(result: IdentificationResult) -> str:
    """Say in a few sentences what was determined and how well the model explains the responses."""
    names = result.fit.names
    determined, weak = (len(result.identifiability.names(kind)) for kind in ("determined", "weak"))
    open_ones = result.identifiability.names("not_determined")
    text = f"{determined} of {len(names)} parameters of {result.problem.robot.name} are determined within 10 %"
    if result.bias_signs:
        text += " as far as noise goes"
    if weak:
        text += f", {weak} {'is' if weak == 1 else 'are'} known less well"
    if open_ones:
        shown = ", ".join(open_ones[:3]) + (f" and {len(open_ones) - 3} more" if len(open_ones) > 3 else "")
        text += f", {len(open_ones)} {'is' if len(open_ones) == 1 else 'are'} not determined ({shown})"
    return f"{text}. {_explained(result)}{_shifted(result)}"


def _explained(result: IdentificationResult) -> str:
    """Say how well the model explains what was measured."""
    count = len(result.problem.responses)
    where = f"the responses in {count} positions" if count > 1 else "the response"
    share = result.fit.cost / result.nominal_cost if result.nominal_cost > 0 else 1.0
    gain = f"it leaves {number(100 * share, 2)} % of what the nominal values leave unexplained"
    if share > _AS_GOOD:
        gain = "the nominal values explain them nearly as well"
    if result.covariance.basis == "residuals":
        return f"The errors of {where} are not known, so the identified model is judged by itself: {gain}."
    reduced = result.covariance.reduced_cost
    if reduced < result.limits.cost:
        weighed = "With the weights of the fit the" if result.bias_signs else "The"
        return f"{weighed} identified model explains {where} within their uncertainty; {gain}."
    times = number(float(np.sqrt(reduced)), 2)
    return f"The identified model misses {where} by {times} times their uncertainty (rms); {gain}."


def _shifted(result: IdentificationResult) -> str:
    """Say what the intervals do not cover, where there are signs of it."""
    if not result.settled:
        how = "ended on a bound of the search" if result.fit.converged else "did not converge"
        return f" The fit {how}, so the misfit tells nothing about the robot."
    if not result.bias_signs:
        return ""
    return (
        " The robot does something that the model lacks: parameters shift, dampers most of all, and the intervals do "
        "not cover it."
    )


def covariance_text(result: IdentificationResult) -> str:
    """Say what the covariance rests on; that the model misses something only where chance does not explain it."""
    text, reduced = result.covariance.explanation, result.covariance.reduced_cost
    if not result.settled:
        return text.replace(_MISSES, "because the fit leaves more than the errors of the responses explain")
    return text if reduced >= result.limits.cost else text.replace(_MISSES, "which is within what scatter explains")


def kept_text(result: IdentificationResult) -> str:
    """Say in a sentence what the file of the identified robot keeps; empty where it keeps nothing."""
    kept = result.kept_nominal
    if not kept:
        return ""
    values, fitted, ones = ("value", "its fitted value", "one") if len(kept) == 1 else _SEVERAL
    return (
        f"The identified robot keeps the nominal {values} of {', '.join(kept)}: not determined, or on a bound of the "
        f"search. The others were fitted beside {fitted}; to fit them beside the nominal {ones}, name only them with "
        "--unknown."
    )
