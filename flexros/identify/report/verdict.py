"""The verdict of an identification in a few sentences."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.identify.graybox.covariance import FORM_ERROR
from flexros.identify.report.words import counted
from flexros.report.number_text import number

if TYPE_CHECKING:
    from flexros.identify.result import IdentificationResult

_AS_GOOD = 0.9
_PART_OF_ALL, _MOST_OF_IT, _ITS_PART = 0.1, 0.8, 0.2
"""Inertias of motors are doubtful where high frequencies have at least this part of the cost, responses of motors to
their own torque this part of it, and one motor this part of that (chosen)."""
_SURE = 2
"""Starts that must end in the same minimum for a large misfit to be the model's (chosen)."""
_SEVERAL = ("values", "their fitted values", "ones")


def verdict(result: IdentificationResult) -> str:
    """Return a few sentences: what was determined, and how well the model explains the responses."""
    if result.much_missed:
        return f"{_explained(result)}{_shifted(result)} {_judged(result)}."
    return f"{_judged(result)}. {_explained(result)}{_shifted(result)}"


def _judged(result: IdentificationResult) -> str:
    """Count the parameters by their verdicts."""
    names = result.fit.names
    determined, weak = (len(result.identifiability.names(kind)) for kind in ("determined", "weak"))
    open_ones = result.identifiability.names("not_determined")
    text = f"{determined} of {counted(len(names), 'parameter')} of {result.problem.robot.name} {_are(determined)}"
    if result.much_missed:
        text += " determined within 10 % as far as noise goes, which is not what limits them here"
    else:
        text += f" determined within 10 %{' as far as noise goes' if result.bias_signs else ''}"
    if weak:
        text += f", {weak} {_are(weak)} known less well"
    if open_ones:
        shown = ", ".join(open_ones[:3]) + (f" and {len(open_ones) - 3} more" if len(open_ones) > 3 else "")
        text += f", {len(open_ones)} {_are(len(open_ones))} not determined ({shown})"
    return text


def _are(count: int) -> str:
    return "is" if count == 1 else "are"


def _explained(result: IdentificationResult) -> str:
    """Return how well the model explains the responses."""
    count = len(result.problem.responses)
    its, them = ("its", "it") if count == 1 else ("their", "them")
    where = "the response" if count == 1 else f"the responses in {count} positions"
    share = result.fit.cost / result.nominal_cost if result.nominal_cost > 0 else 1.0
    gain = f"it leaves {number(100 * share, 2)} % of what the nominal values leave unexplained"
    if share > _AS_GOOD:
        gain = f"the nominal values explain {them} nearly as well"
    if result.covariance.basis == "residuals":
        return f"The errors of {where} are not known, so the identified model is judged by itself: {gain}."
    reduced = result.covariance.reduced_cost
    if reduced < result.limits.cost and not result.much_missed:
        weighed = "With the weights of the fit the" if result.bias_signs else "The"
        return f"{weighed} identified model explains {where} within {its} uncertainty; {gain}."
    times = number(float(np.sqrt(max(reduced, result.residuals.chi_square) if result.much_missed else reduced)), 2)
    return f"The identified model misses {where} by {times} times {its} uncertainty (rms); {gain}."


def _shifted(result: IdentificationResult) -> str:
    """Return what the intervals do not cover, where there are signs of it."""
    if not result.settled:
        how = "ended on a bound of the search" if result.fit.converged else "did not converge"
        return f" The fit {how}, so the misfit is no evidence about the robot."
    if not result.bias_signs:
        return ""
    if result.much_missed and len(result.start_costs) > 0 and result.same_minimum < _SURE:
        return (
            f" Of {counted(len(result.start_costs), 'start')} {result.same_minimum} ended here. Either the search "
            "missed the best values, and more initial values find them, or the model has a form error."
        )
    return (
        " The model has a form error: the robot shows effects that it does not contain. They bias the parameters, "
        "dampers most, and the intervals do not cover this bias."
    )


def advice(result: IdentificationResult) -> str:
    """Name parameters to free where a large misfit sits in the mass lines of motors; empty where it does not.

    Far above the resonances the response of a motor to its own torque is one over its inertia.
    """
    if not result.much_missed:
        return ""
    middle = np.median([cell.lowest for cell in result.residuals.cells])
    high = [cell for cell in result.residuals.cells if cell.lowest >= middle]
    above = {
        name: sum(cell.share for cell in high if cell.output == cell.input == name)
        for name in result.problem.responses[0].output_names
    }
    whole, all_high = sum(above.values()), sum(cell.share for cell in high)
    known = result.problem.robot.parameters
    names = [f"{name}.inertia" for name, share in above.items() if share >= _ITS_PART * whole]
    free = [name for name in names if name in known and name not in result.fit.names]
    if all_high < _PART_OF_ALL or whole < _MOST_OF_IT * all_high or not free:
        return ""
    return (
        f"{number(100 * whole / all_high, 2)} % of the misfit from {number(float(middle), 3)} Hz on is in responses of "
        "motors to their own torque, where inertias rule: identify them, or masses of the arm, as well by adding "
        f"{', '.join(free)} to the unknown parameters."
    )


def covariance_text(result: IdentificationResult) -> str:
    """Return what the covariance rests on; a model-form error only where chance does not explain the cost."""
    text, reduced = result.covariance.explanation, result.covariance.reduced_cost
    if not result.settled:
        return text.replace(FORM_ERROR, "because the fit leaves more than the errors of the responses explain")
    return text if reduced >= result.limits.cost else text.replace(FORM_ERROR, "which is within what scatter explains")


def kept_text(result: IdentificationResult) -> str:
    """Return in a sentence what the file of the identified robot keeps; empty where it keeps nothing."""
    kept = result.kept_nominal
    if not kept:
        return ""
    values, fitted, ones = ("value", "its fitted value", "one") if len(kept) == 1 else _SEVERAL
    return (
        f"The identified robot keeps the nominal {values} of {', '.join(kept)}: not determined, or on a bound of the "
        f"search. The others were fitted together with {fitted}; to fit them with the nominal {ones}, give only them "
        "as unknown parameters."
    )
