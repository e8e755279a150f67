"""Numbers of the model at the end of a search in a measured log: within tolerance none, far beyond it named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from flexros.effects import effects
from flexros.gap.candidates.tolerance import Tolerance
from flexros.gap.fit.tolerance_takeover import Takeover
from flexros.gap.search import within_tolerance
from flexros.gap.settings import DiagnosisSettings
from flexros.record.premises import MEASURED

STIFFNESS, PAYLOAD, BIAS = "stiffness_error@body_2.ry", "payload_error@tool", "torque_bias@motor_1"
SPRING = "body_2.ry.stiffness"


def fit(chi2: float, penalty: float, **relative: float) -> Any:
    """Fit of a bias and of relative errors of these sizes, by the first word of their effect."""
    names = [BIAS, *(name for name in (STIFFNESS, PAYLOAD) if name.split("_")[0] in relative)]
    hypothesis = tuple(
        SimpleNamespace(name=name, effect=effects()[name.split("@")[0]], location=name.split("@")[1], free=())
        for name in names
    )
    values = [{"level": 1.0}, *({"relative": relative[one.split("_")[0]]} for one in names[1:])]
    predictor = SimpleNamespace(values=lambda _: values)
    return SimpleNamespace(
        names=frozenset(names),
        hypothesis=hypothesis,
        predictor=predictor,
        theta=np.zeros(len(names)),
        chi2=chi2,
        prior_penalty=penalty,
        columns=lambda left: np.array([name in left for name in names]),
    )


class Search:
    """A search in which one fit follows from adding, and one from leaving out."""

    premises = MEASURED
    settings = DiagnosisSettings()

    def __init__(self, after: Any, misfit: float = 1.0) -> None:
        self.after = after
        self.rows = np.zeros(0, dtype=int)
        self.data = SimpleNamespace(misfit=misfit, n_values=1000)
        self.directions = lambda *_: []
        self.of_torques: frozenset[str] = frozenset()
        self.distance = self.chance = lambda *_: 0.0
        self.deadline = SimpleNamespace(stops_finishing=lambda: False)
        tolerance = Tolerance((SPRING,), (0.03,))
        robot = SimpleNamespace(parameters={SPRING: 1.0})
        null = SimpleNamespace(predictor=SimpleNamespace(tolerance=tolerance))
        self.null = SimpleNamespace(fit=null, model=SimpleNamespace(robot=robot))

    def candidates(self) -> list[Any]:
        return [SimpleNamespace(name=STIFFNESS, effect=effects()["stiffness_error"], location="body_2.ry")]

    def together(self, _: Any, additions: Any) -> Any:
        (one,) = (one for one in self.after.hypothesis if one.name == additions[0].candidate.name)
        additions[0].candidate.__dict__.update(one.__dict__)
        self.after.hypothesis = (self.after.hypothesis[0], additions[0].candidate)
        return self.after

    def without(self, _: Any, name: str) -> Any:
        assert name not in self.after.names
        return self.after

    def completed(self, one: Any) -> Any:
        return one


@pytest.fixture(autouse=True)
def plain_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    """A level below the floors; the penalty of a fit is that of the spring alone."""
    monkeypatch.setattr(within_tolerance, "compared", lambda *_: SimpleNamespace(level=lambda one: 0.9, threshold=6.0))
    monkeypatch.setattr(within_tolerance, "exchanged", lambda _search, one, *_, **__: one)
    monkeypatch.setattr(within_tolerance, "ended_at_last", lambda _: set())

    def takeover(one: Any, chosen: Any) -> Takeover | None:
        relative = issubclass(one.effect, within_tolerance.AbstractRelativeError)
        return Takeover(chosen.prior_penalty, np.zeros(1), np.array([True])) if relative else None

    monkeypatch.setattr(within_tolerance, "takeover", takeover)


@pytest.mark.parametrize(("penalty", "size", "named"), [(49.0, -0.2, True), (9.0, -0.09, False), (20.0, -0.1, False)])
def test_a_number_far_beyond_its_tolerance_is_an_effect(penalty: float, size: float, named: bool) -> None:
    """Beyond four tolerances of 3 %, in what the numbers deviate and in the size of the effect."""
    search: Any = Search(fit(1000.0, 1.0, stiffness=size))
    fits: list[Any] = []
    found = within_tolerance.with_far_numbers(search, fit(1000.0 + penalty, penalty), fits)
    assert (STIFFNESS in found.names) is named


def test_a_number_that_goes_to_the_end_of_its_search_is_no_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    """The dampings of two springs of six axes were named at ten times, and all effects exchanged beside them."""
    monkeypatch.setattr(within_tolerance, "ended_at_last", lambda _: {STIFFNESS})
    search: Any = Search(fit(1000.0, 1.0, stiffness=-0.2))
    assert STIFFNESS not in within_tolerance.with_far_numbers(search, fit(1049.0, 49.0), []).names


@pytest.mark.parametrize(("chi2", "further", "exchanged"), [
    (950.0, {"stiffness": -0.2}, True), (999.9, {"stiffness": -0.2}, False), (950.0, {}, False),
])  # fmt: skip
def test_what_stood_for_a_number_that_is_named_now_is_exchanged(
    chi2: float, further: dict[str, float], exchanged: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A gain at a wrist had stood for a payload and for the gain of the lift that carries it."""
    search: Any = Search(fit(1000.0, 1.0, stiffness=-0.2))
    search.of_torques = frozenset({"inertia@motor_1"})
    other = fit(chi2, 1.0, payload=0.3, **further)
    shown: list[frozenset[str]] = []

    def exchange(*_: Any, shown: frozenset[str], protected: list[frozenset[str]] = shown) -> Any:
        protected.append(shown)
        return other

    monkeypatch.setattr(within_tolerance, "exchanged", exchange)
    found = within_tolerance.with_far_numbers(search, fit(1049.0, 49.0), [])
    assert (found is other) is exchanged
    assert shown == [frozenset({"inertia@motor_1"})]  # none that only took the place of one of these


@pytest.mark.parametrize("worth", [True, False])
def test_an_error_that_the_tolerance_takes_up_at_the_final_misfit_is_none(
    worth: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        within_tolerance, "replace", lambda data, misfit: SimpleNamespace(misfit=misfit, negligible=0.0)
    )
    given: list[Any] = []
    monkeypatch.setattr(within_tolerance, "compare", lambda *arguments: given.extend(arguments[3:]))
    monkeypatch.setattr(within_tolerance, "worth", lambda *_: worth)
    used: list[float] = []

    def fit_candidate(predictor: Any, data: Any, *_: Any, **__: Any) -> Any:
        used.append(data.misfit)
        return predictor

    monkeypatch.setattr(within_tolerance, "fit_candidate", fit_candidate)
    rest, full = fit(1010.0, 9.0), fit(1000.0, 1.0, payload=-0.06)
    search: Any = Search(rest, misfit=4.9)
    search.deadline.of_fit = lambda finishing: None
    search.null.predictor = lambda hypothesis: rest
    full.predictor = full
    found = within_tolerance.without_tolerated(search, full, [])
    assert (PAYLOAD in found.names) is worth
    assert set(used) == {1.0}
    assert given == [search.distance, search.chance, search.settings.ranking]


@pytest.mark.parametrize(("effect", "size", "kept"), [
    ("coulomb_friction", 0.018, False), ("coulomb_friction", 0.022, True),
    ("viscous_friction", 0.008, False), ("viscous_friction", 0.011, True),
])  # fmt: skip
def test_friction_far_within_the_tolerance_of_torques_is_none(effect: str, size: float, kept: bool) -> None:
    """A fifth of 0.1 Nm, for viscous friction by the rms speed of 2.1 rad/s; not where its directions differ.

    Samples that were not measured, and the jump after them, are no speed.
    """
    time = 0.01 * np.arange(630)
    position, valid = np.sin(3.0 * time)[:, None], np.ones(630, dtype=bool)
    valid[100:104], position[100:104] = False, 50.0
    record = SimpleNamespace(position=position, valid=valid, sample_time=0.01, command=None)
    rest = fit(1001.0, 1.0)
    search: Any = Search(rest)
    measurement = SimpleNamespace(tolerated_torque=lambda _: np.array([0.1]))
    search.data = SimpleNamespace(record=record, measurement=measurement)
    search.null.model.robot.joint_names = ("motor_1",)
    search.null.model.robot.parameters["motor_1.viscous_friction"] = SimpleNamespace(value=0.0)
    name = f"{effect}@motor_1"
    full = fit(1000.0, 1.0)
    free = (SimpleNamespace(name="size"),)
    one = SimpleNamespace(name=name, effect=effects()[effect], location="motor_1", free=free)
    full.hypothesis[0].free = free
    full.hypothesis, full.names = (*full.hypothesis, one), full.names | {name}
    full.predictor.values = lambda _: [{"size": 1.0}, {"size": size, "coefficient": size}]
    assert (name in within_tolerance.without_slight_friction(search, full, []).names) is kept
    one.free = (*free, SimpleNamespace(name="asymmetry"))
    assert name in within_tolerance.without_slight_friction(search, full, []).names


@pytest.mark.parametrize(("added", "stated", "needed", "kept"), [
    (0.09, True, False, False), (-0.09, True, False, False), (0.11, True, False, True), (-0.11, True, False, True),
    (0.09, False, False, True), (0.09, True, True, True),
])  # fmt: skip
def test_viscous_friction_within_its_tolerance_is_none(
    added: float, stated: bool, needed: bool, kept: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of an elastic arm six deviations of 2 to 7 %, of numbers stated with 5 %, had been causes at 100 %."""
    monkeypatch.setattr(within_tolerance, "worth", lambda *_: needed)
    number, name = "motor_1.viscous_friction", "viscous_friction@motor_1"
    search: Any = Search(fit(1001.0, 1.0))
    tolerance = Tolerance((number,), (0.05,)) if stated else Tolerance()
    search.null.fit.predictor.tolerance = tolerance
    speed = np.cumsum(np.ones((100, 1)), axis=0)
    record = SimpleNamespace(position=speed, valid=np.ones(100, dtype=bool), sample_time=0.01, command=None)
    search.data = SimpleNamespace(record=record, measurement=SimpleNamespace(tolerated_torque=lambda _: np.zeros(1)))
    search.null.model.robot.joint_names = ("motor_1",)
    search.null.model.robot.parameters[number] = SimpleNamespace(value=1.0)
    full = fit(1000.0, 1.0)
    free = (SimpleNamespace(name="coefficient"),)
    one = SimpleNamespace(name=name, effect=effects()["viscous_friction"], location="motor_1", free=free)
    full.hypothesis[0].free = free
    full.hypothesis, full.names = (*full.hypothesis, one), full.names | {name}
    full.predictor.values = lambda _: [{"level": 1.0}, {"coefficient": added}]
    assert (name in within_tolerance.without_slight_friction(search, full, []).names) is kept
