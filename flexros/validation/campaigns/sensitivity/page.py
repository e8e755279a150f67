"""Page of results of the sensitivity study."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from flexros.validation.campaigns.markdown import version_line

if TYPE_CHECKING:
    from flexros.validation.blind.plan import Case

Answer: TypeAlias = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Study:
    """Answers of the diagnosis with every setting varied.

    Attributes:
        cases: The cases.
        values: Defaults of the varied settings by dotted name.
        factors: Factors on the defaults.
        answers: Answers by name of the case and dotted name of the setting, one per factor; of the empty name the one
            with the defaults. See `case_part`.
    """

    cases: Sequence[Case]
    values: Mapping[str, Any]
    factors: Sequence[float]
    answers: Mapping[str, Mapping[str, Sequence[Answer]]]

    def default(self, case: Case) -> Answer:
        """Return the answer with the default settings."""
        return self.answers[case.name][""][0]

    def varied(self, key: str) -> Iterator[tuple[Case, float, Answer]]:
        """Yield case, factor and answer of every variation of a setting."""
        for case in self.cases:
            for factor, answer in zip(self.factors, self.answers[case.name][key], strict=True):
                yield case, factor, answer


@dataclass(frozen=True)
class Effect:
    """Changes by the variations of one setting.

    Attributes:
        key: Dotted name of the setting.
        answers: Number of variations that gave an answer.
        verdicts: Number of answers with another verdict than that of the defaults.
        causes: Number of answers with another first cause, effect or location.
        probability: Largest change of the probability of the same first cause [1].
        closed_fraction: Largest change of the closed fraction [1].
    """

    key: str
    answers: int
    verdicts: int
    causes: int
    probability: float
    closed_fraction: float


def effects_of(study: Study) -> list[Effect]:
    """Summarise the variations of each setting, the most effective setting first."""
    effects = []
    for key in study.values:
        pairs = [(study.default(case), answer) for case, _, answer in study.varied(key)]
        pairs = [pair for pair in pairs if not any("refused" in answer for answer in pair)]
        effects.append(
            Effect(
                key,
                len(pairs),
                sum(default["verdict"] != answer["verdict"] for default, answer in pairs),
                sum(_cause(default) != _cause(answer) for default, answer in pairs),
                _largest_change(pairs, "probability"),
                _largest_change(pairs, "closed_fraction"),
            )
        )
    return sorted(effects, key=lambda e: (-e.verdicts, -e.causes, -e.probability, -e.closed_fraction, e.key))


def sensitivity_page(study: Study, used: Mapping[str, str]) -> str:
    """Write the page.

    Args:
        study: The answers.
        used: Versions by package.

    Returns:
        Markdown.
    """
    times = " and ".join(f"{factor:g}" for factor in study.factors)
    lines = [
        "# Sensitivity of the diagnosis to its settings",
        "",
        "Written by `flexros campaign sensitivity`. Each numeric setting of the diagnosis is multiplied by "
        f"{times}, one at a time. Fixed cases of the blind check: {len(study.cases)}. The cases are short and drawn "
        "from development seeds: they show which settings matter, not how good the diagnosis is.",
        "",
        *sensitivity_summary(study),
        "",
        "## Cases with the default settings",
        "",
        "| case | robot | hidden | size | nominal model | verdict | first cause | probability | closed |",
        "|---" * 9 + "|",
        *(_case_row(case, study.default(case)) for case in study.cases),
        "",
        "## Settings, the most effective first",
        "",
        "| setting | default | answers | other verdict | other first cause | change of probability | of closed |",
        "|---" * 7 + "|",
        *(_setting_row(effect, study.values[effect.key]) for effect in effects_of(study)),
    ]
    changes = list(_changes(study))
    if changes:
        lines += ["", "## Answers that changed", "", "| setting | times | case | default | varied |", "|---" * 5 + "|"]
        lines += changes
    lines += ["", f"{version_line(used)}."]
    return "\n".join(lines) + "\n"


def sensitivity_summary(study: Study) -> tuple[str, ...]:
    """Count the settings that move a verdict or a first cause."""
    effects = effects_of(study)
    moved = [effect for effect in effects if effect.verdicts or effect.causes]
    answers, verdicts = sum(effect.answers for effect in effects), sum(effect.verdicts for effect in effects)
    text = f"{len(moved)} of {len(effects)} settings change a verdict or a first cause in some of {answers} answers"
    return (f"{text}; {verdicts} verdicts are others.",)


def _largest_change(pairs: Sequence[tuple[Answer, Answer]], key: str) -> float:
    """Largest absolute change of a figure, over answers with the same first cause."""
    changes = (
        abs(answer[key] - default[key])
        for default, answer in pairs
        if _cause(default) == _cause(answer) and default[key] is not None and answer[key] is not None
    )
    return max(changes, default=0.0)


def _cause(answer: Answer) -> tuple[str | None, str | None]:
    return answer["cause"], answer["location"]


def _case_row(case: Case, answer: Answer) -> str:
    hidden = ", ".join(case.effects) or "nothing"
    cells = (case.name, case.robot, hidden, case.size, case.nuisance, *_cells(answer))
    return f"| {' | '.join(cells)} |"


def _cells(answer: Answer) -> tuple[str, str, str, str]:
    if "refused" in answer:
        return answer["refused"], "", "", ""
    cause = "" if answer["cause"] is None else f"{answer['cause']} at {answer['location']}"
    return answer["verdict"], cause, _text(answer["probability"]), _text(answer["closed_fraction"])


def _setting_row(effect: Effect, value: Any) -> str:
    listed = ", ".join(f"{entry:.4g}" for entry in value) if isinstance(value, tuple) else f"{value:.4g}"
    counts = (str(effect.answers), str(effect.verdicts), str(effect.causes))
    cells = (f"`{effect.key}`", listed, *counts, _text(effect.probability), _text(effect.closed_fraction))
    return f"| {' | '.join(cells)} |"


def _changes(study: Study) -> Iterator[str]:
    """Yield a row for each answer with another verdict or first cause, and for each that was refused."""
    for key in study.values:
        for case, factor, answer in study.varied(key):
            default = study.default(case)
            refused = "refused" in answer or "refused" in default
            if refused or (default["verdict"], _cause(default)) != (answer["verdict"], _cause(answer)):
                before, after = (", ".join(filter(None, _cells(each)[:3])) for each in (default, answer))
                yield f"| `{key}` | {factor:g} | {case.name} | {before} | {after} |"


def _text(value: float | None) -> str:
    return "" if value is None else f"{value:.3f}"
