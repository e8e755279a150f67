"""The results of the study as a page with pictures, to be kept with the project."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.provenance import versions
from flexros.validation.campaigns.study.choices import BEST, REASONABLE, REFERENCE
from flexros.validation.campaigns.study.conclusions import conclusion_rows
from flexros.validation.campaigns.study.figures import hardest_spring, shares, table_1
from flexros.validation.campaigns.study.pictures import pictures
from flexros.validation.campaigns.study.quasi_newton import STEPS

if TYPE_CHECKING:
    from flexros.scenario.scenario import Scenario
    from flexros.validation.campaigns.study.jobs import Study

CAPTIONS = {
    "costs_optimal_weights": "LLS cost of all models with optimal weights (figure 3 of the paper).",
    "costs_user_weights": "LLS cost of all models with user weights; dotted: reasonable models (figure 4).",
    "springs_of_gears": "Gear springs over those of the best model, models sorted by user cost (figure 5).",
    "springs_of_arm": "Arm springs over those of the best model (figure 6).",
    "dampers": "Dampers over those of the best model (figure 7).",
    "frequency_responses": "Magnitude of measured and fitted responses in one position (figure 8).",
}


def study_files(study: Study, scenario: Scenario) -> dict[str, str]:
    """Return page, pictures and numbers by file name; the page is study.md, the numbers are data/study.json.

    Args:
        study: The study.
        scenario: The experiment that was measured.
    """
    return {
        "study.md": page(study, scenario),
        "data/study.json": json.dumps(numbers(study, scenario)) + "\n",
        **{f"figures/study_{name}.svg": drawing.svg() for name, drawing in pictures(study).items()},
    }


def study_summary(study: Study) -> tuple[str, ...]:
    """Return the result in sentences, one per estimator."""
    return tuple(
        f"{share.kind.name}: {share.reasonable:.0%} of the models are reasonable ({share.peer:.0%} by BFGS, published "
        f"{share.kind.published_reasonable:.0%}), springs within a factor of 2 in {share.springs:.0%} (published "
        f"{share.kind.published_springs:.0%})."
        for share in shares(study)
    )


def numbers(study: Study, scenario: Scenario) -> dict[str, Any]:
    """Return all that the tables and pictures show, ready for JSON; infinite costs become none."""
    return {
        "scenario": scenario.model_dump(mode="json", exclude_defaults=True),
        "versions": versions(),
        "names": list(study.problem.names),
        "nominal": study.problem.scale.nominal.tolist(),
        "best": study.best.values.tolist(),
        "theory": _digits(study.theory),
        "corrected": _digits(study.corrected),
        "spread": _digits(study.spread),
        "single_position": study.single,
        "runs": {
            name: {
                "iterations": run.iterations.astype(int).tolist(),
                "peer_cost": _digits(run.peer_cost),
                "user_cost": _digits(run.user_cost),
                "optimal_cost": _digits(run.optimal_cost),
                "values_over_nominal": [_digits(row / study.problem.scale.nominal) for row in run.values],
            }
            for name, run in study.runs.items()
        },
    }


def page(study: Study, scenario: Scenario) -> str:
    """Return the page as Markdown."""
    robot, specification = study.problem.robot, scenario.identification
    assert specification is not None
    lines = [
        "# The study of Paper A repeated",
        "",
        "Moberg (2007), Paper A, section 6, on a simulated robot. The measured robot has friction, hardening gears and "
        "torque ripple, all chosen, which the model does not contain. Written by `make campaign`.",
        "",
        f"- robot: {robot.name}, {len(study.problem.names)} unknown parameters",
        f"- experiment: {len(specification.positions)} positions from the D-optimal design, "
        f"{specification.blocks} blocks each, {len(study.problem.frequency)} frequencies",
        f"- starts: {len(study.runs[REFERENCE].values)} within a factor of 10, the same for all estimators",
        f"- measured robot: {', '.join(scenario.plant.effects) or 'linear'}",
        f"- versions: {', '.join(f'{name} {value}' for name, value in versions().items())}",
        "",
        f"## Share of reasonable models (cost at most {REASONABLE:g} times the lowest)",
        "",
        *_share_rows(study),
        "",
        f"Left out of the springs, as one is in the paper: {study.problem.names[hardest_spring(study)]}. The published "
        "shares come from a general-purpose gradient search (fminunc) on a real robot. The column 'by BFGS' is such a "
        f"search (SciPy, exact gradient, at most {STEPS} steps, no bounds) from the first {_peers(study)} starts. All "
        "other columns use the search of FlexROS: Levenberg-Marquardt with limited steps and bounds. Steps are means.",
        "",
        "## Conclusions of the paper, and which of them this study reproduces",
        "",
        *conclusion_rows(study),
        "",
        f"## Parameters of the {REFERENCE} models within {BEST:g} of the lowest cost (Table 1)",
        "",
        *_table_rows(study),
        "",
        _table_notes(study),
        "",
    ]
    for name, caption in CAPTIONS.items():
        lines += [f"![{caption}](figures/study_{name}.svg)", "", caption, ""]
    return "\n".join(lines).rstrip() + "\n"


def _table_notes(study: Study) -> str:
    """Return the explanation of the columns of Table 1."""
    return (
        "All columns but the first are relative to the best model; std is over starts, redrawn over fits to "
        f"{study.redrawn} sets of responses with noise drawn anew from the measured covariance, theory is equation "
        "(5), corrected is the same with the factor for the model-form error. For these three, lines above the noise "
        "are selected by the model's responses instead of the measured ones: (5) has no meaning for lines in a notch "
        "of the model. "
        f"{study.explanation}"
    )


def _peers(study: Study) -> int:
    """Number of starts from which the general-purpose search started as well."""
    return int(np.count_nonzero(~np.isnan(study.runs[REFERENCE].peer_cost)))


def _share_rows(study: Study) -> list[str]:
    rows = [
        "| estimator | reasonable | by BFGS | published | springs within [0.5, 2] | published | all springs | steps |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for share in shares(study):
        kind = share.kind
        rows.append(
            f"| {kind.name} | {share.reasonable:.0%} | {share.peer:.0%} | {kind.published_reasonable:.0%} | "
            f"{share.springs:.0%} | "
            f"{kind.published_springs:.0%} | {share.all_springs:.0%} | {share.iterations:.1f} |"
        )
    return rows


def _table_rows(study: Study) -> list[str]:
    rows = [
        "| parameter | best over nominal | min | median | max | mean | std | redrawn | theory | corrected |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    ratio = study.best.values / study.problem.scale.nominal
    for row, found in zip(table_1(study), ratio, strict=True):
        figures = (row.least, row.median, row.largest, row.mean)
        spreads = (row.deviation, row.spread, row.theory, row.corrected)
        texts = [f"{found:.3f}", *(f"{value:.3g}" for value in figures), *(f"{value:.2g}" for value in spreads)]
        rows.append(f"| {row.name} | {' | '.join(texts)} |")
    return rows


def _digits(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[float | None]:
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
