"""Every control law, observer and design has a scenario, a test, a guide section and a row of the thesis table."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.benchmark.controllers import controller_names, read_made_by
from flexros.control.base import control_laws
from flexros.control.design.methods.base import design_methods
from flexros.control.observed import AbstractObservedLaw
from flexros.control.observers.base import observers
from flexros.feedforward.base import feedforward_methods
from flexros.scenario.scenario import load_scenario, scenario_names

CHECKOUT = Path(__file__).parents[2]


def read(folder: str, ending: str) -> str:
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted((CHECKOUT / folder).rglob(f"*{ending}")))


GUIDE, THESIS = read("docs/how-to", ".md"), read("docs/reference", "thesis_map.md")
RESULTS = (CHECKOUT / "docs" / "results" / "feedback_benchmark.md").read_text(encoding="utf-8")
TESTS, OVER_TOPICS = read("tests/control", ".py"), read("tests/nodes", ".py")
FILES = {path.name for path in (CHECKOUT / "tests" / "control").rglob("test_*.py")}
FEEDFORWARD_TESTS = read("tests/feedforward", ".py")
SCENARIOS = {name: load_scenario(name) for name in scenario_names()}


@pytest.mark.parametrize("kind", sorted(control_laws()))
def test_law_has_scenario_test_run_over_topics_guide_and_row(kind: str) -> None:
    law = control_laws()[kind]
    using = [name for name, scenario in SCENARIOS.items() if isinstance(scenario.controller, law)]
    assert using
    assert any(name in OVER_TOPICS for name in using)
    assert law.__name__ in TESTS or f"test_{kind}.py" in FILES
    assert f"`{kind}`" in GUIDE
    assert law.__module__.replace(".", "/") + ".py" in THESIS


@pytest.mark.parametrize("kind", sorted(observers()))
def test_observer_has_scenario_test_and_guide(kind: str) -> None:
    laws = [(name, scenario.controller) for name, scenario in SCENARIOS.items()]
    using = [name for name, law in laws if isinstance(law, AbstractObservedLaw) and law.observer.kind == kind]
    assert any(name in OVER_TOPICS for name in using)
    assert observers()[kind].__name__ in TESTS or f"test_{kind}.py" in FILES
    assert f"kind: {kind}" in GUIDE


@pytest.mark.parametrize("method", sorted(set(feedforward_methods()) - {"none"}))
def test_feedforward_has_scenario_test_guide_and_row(method: str) -> None:
    module = type(feedforward_methods()[method]).__module__
    chosen = {name for name, scenario in SCENARIOS.items() if scenario.feedforward.method == method}
    assert chosen or f"circle_{method}" in SCENARIOS  # stable inversion is chosen by itself where it is needed
    assert method in FEEDFORWARD_TESTS
    assert f"`{method}`" in GUIDE or f"feedforward.method: {method}" in GUIDE
    assert module.replace(".", "/") + ".py" in THESIS


@pytest.mark.parametrize("method", sorted(design_methods()))
def test_design_has_controller_test_guide_result_and_row(method: str) -> None:
    design = design_methods()[method]
    made = [name for name in controller_names() if f"flexros design {method} " in read_made_by(name)]
    assert made
    assert all(f"| `{name}` |" in RESULTS for name in made)
    assert f"import {design.__name__}" in TESTS
    assert f"| `{method}` |" in GUIDE
    assert design.__module__.replace(".", "/") + ".py" in THESIS


def test_every_built_in_controller_of_the_benchmark_is_on_the_page_of_results() -> None:
    assert [name for name in controller_names() if f"| `{name}` |" not in RESULTS] == []
