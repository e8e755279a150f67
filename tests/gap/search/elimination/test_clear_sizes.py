"""Effects that are taken back, or left out, by how clear their sizes are beside the others."""

from __future__ import annotations

from typing import Any

import pytest

from flexros.gap.search.elimination import clear_sizes, needless, reduce
from flexros.record.premises import MEASURED, SIMULATED, Premises
from tests.gap.search.elimination.named_fits import (
    BIAS,
    COULOMB,
    DRIFT,
    OFFSET,
    STIFFNESS,
    VISCOUS,
    Fit,
    N,
    Search,
    plain_rules,
    size_of,
)


@pytest.fixture(autouse=True)
def plain(monkeypatch: pytest.MonkeyPatch) -> None:
    plain_rules(monkeypatch, clear_sizes, reduce, needless)


@pytest.mark.parametrize(("before", "found"), [
    ((), {COULOMB, VISCOUS, BIAS}),
    ((DRIFT, BIAS), {DRIFT, BIAS}),
], ids=["another effect was found since", "no effect was found since"])  # fmt: skip
def test_friction_that_was_left_out_returns_once_it_is_clear_beside_what_was_found_since(
    before: tuple[str, ...], found: set[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A law that stood for both kinds of friction gives way to them."""
    monkeypatch.setattr(needless, "parameters_of", lambda fit, _: [{"size": size_of(1.0, 0.1)} for _ in fit.kept])
    both = frozenset({COULOMB, VISCOUS, BIAS})
    chi2 = {both: 1000.0, both | {DRIFT}: 1000.0}
    search: Any = Search(chi2, {COULOMB: 500.0, VISCOUS: 400.0, BIAS: 900.0, DRIFT: 1.0}, (COULOMB, VISCOUS))
    chosen: Any = Fit((DRIFT, BIAS), 2000.0)
    again = clear_sizes.with_dropped_again(search, Fit(before, 3000.0), chosen, [])  # type: ignore[arg-type]
    assert again.names == found


def test_what_was_exchanged_for_an_effect_that_looks_alike_in_torques_does_not_return() -> None:
    search: Any = Search({}, {}, (BIAS,))
    chosen: Any = Fit((OFFSET,), 2000.0)
    assert clear_sizes.with_dropped_again(search, Fit((BIAS,), 3000.0), chosen, []) is chosen  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("std", "without", "premises", "kept"),
    [
        (0.5, N, SIMULATED, False),
        (0.3, N, SIMULATED, True),
        (0.5, 2 * N, SIMULATED, True),
        (0.5, N, MEASURED, True),
    ],
    ids=["a size that may be zero", "a clear size", "more than noise left without it", "a measured log"],
)
def test_at_the_noise_an_effect_of_a_simulated_log_stays_where_its_size_is_clear(
    monkeypatch: pytest.MonkeyPatch, std: float, without: float, premises: Premises, kept: bool
) -> None:
    search: Any = Search({frozenset({COULOMB}): without}, {}, ())
    search.premises = premises
    search.completed = lambda fit: fit
    deviations = {COULOMB: 0.01, STIFFNESS: std}
    monkeypatch.setattr(
        clear_sizes, "parameters_of", lambda fit, *_: [{"size": size_of(1.0, deviations[one])} for one in fit.kept]
    )
    monkeypatch.setattr(clear_sizes, "sizes_of", lambda one: one.free)
    monkeypatch.setattr(clear_sizes, "more_than_chance", lambda _, fit: fit.chi2 > 1.2 * N)
    found = clear_sizes.without_unclear(search, Fit((COULOMB, STIFFNESS), float(N)), [])  # type: ignore[arg-type]
    assert (STIFFNESS in found.names) is kept
