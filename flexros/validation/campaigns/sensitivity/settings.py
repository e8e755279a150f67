"""Fixed development cases of the sensitivity study, and the settings that it varies."""

from __future__ import annotations

from dataclasses import dataclass, field

from flexros.validation.blind.plan import Case

SEED = 17
"""Seed of the cases, in the stream of development (chosen)."""

CASES: tuple[Case, ...] = (
    Case(1, "null", "four_mass_linear", (), "none", "exact", tool=False),
    Case(2, "null", "four_mass_linear", (), "none", "tolerance_3", tool=True),
    Case(3, "single", "four_mass_linear", ("coulomb_friction",), "medium", "exact", tool=False),
    Case(4, "single", "four_mass_linear", ("hysteresis",), "weak", "tolerance_1", tool=True),
    Case(5, "pair", "four_mass_linear", ("delay", "viscous_friction"), "any", "exact", tool=False),
    Case(6, "unknown", "four_mass_linear", ("position_dependent_friction",), "any", "exact", tool=True),
)
"""Two nulls, two single effects, a pair, and a cause outside the library (chosen)."""

FACTORS: tuple[float, ...] = (0.5, 2.0)
"""Factors on the default of each setting."""

NOT_VARIED = ("threads", "seed", "fitted_share", "where", "next_experiment")
"""Settings and groups that cannot move a verdict here: computing resources, the split of a log that has a holdout, and
what is computed besides the verdict."""


@dataclass(frozen=True)
class SensitivitySettings:
    """Settings of the study.

    Attributes:
        cases: Cases of the blind check, drawn from the stream of development.
        seed: Seed of the cases.
        durations: Lengths of the log to fit, the holdout and the third log, about [s]; the third one is not used.
        factors: Factors on the default of each setting.
        keys: Dotted names of the settings to vary; empty for all.
    """

    cases: tuple[Case, ...] = CASES
    seed: int = SEED
    durations: tuple[float, float, float] = (8.0, 5.0, 2.0)
    factors: tuple[float, ...] = FACTORS
    keys: tuple[str, ...] = field(default=())
