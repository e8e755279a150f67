"""Tuning on the benchmark, and the files that result."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.benchmark.controllers import load_controller, read_parameters
from flexros.benchmark.evaluate import FeedbackBenchmark
from flexros.benchmark.optimise import UNSTABLE, optimise, part_cost
from flexros.benchmark.tuning import controller_text, structure_of, structure_stages, tune
from flexros.control.design.tunable import PID, TunableStructure
from flexros.control.pid import Pid
from flexros.errors import InputError

pytest.importorskip("cma")


@pytest.fixture(scope="module")
def benchmark() -> FeedbackBenchmark:
    return FeedbackBenchmark()


def test_parts_of_the_cost_sum_to_it(benchmark: FeedbackBenchmark) -> None:
    controller = load_controller("pid_check")
    result = benchmark.evaluate(controller, seeds=(1,))
    parts = [part_cost(benchmark, controller.nominal, part, (1,)) for part in ("C1", "C2")]
    assert sum(parts) == pytest.approx(result.cost)


def test_unstable_controller_costs_more_than_any_other(benchmark: FeedbackBenchmark) -> None:
    assert part_cost(benchmark, Pid(kp=24.0, ki=9e3, kd=0.1), "C1", (1,)) >= UNSTABLE


@pytest.mark.slow
def test_search_lowers_the_cost_and_repeats_itself(benchmark: FeedbackBenchmark) -> None:
    structure = TunableStructure()
    start = structure.vector(PID)

    def law(point: np.ndarray) -> object:
        return structure.law(structure.values(point), 5e-4)

    first, again = (optimise(benchmark, law, start, "C1", evaluations=24) for _ in range(2))
    assert first.cost < part_cost(benchmark, Pid.model_validate(PID), "C1", (1,)) - 0.1
    assert np.array_equal(first.point, again.point)


def test_stages_add_one_factor_at_a_time() -> None:
    stages = structure_stages(TunableStructure(2, 1, True, 1))
    assert [stage.order for stage in stages] == [2, 4, 5, 7, 9, 11]


def test_controller_file_loads_as_the_laws_and_parameters_it_was_made_of(
    tmp_path: Path, benchmark: FeedbackBenchmark
) -> None:
    structure = TunableStructure(sections=1)
    found = tune(benchmark, structure_stages(structure), structure.start(), "C1", evaluations=8)
    law = structure.law(found.values, 5e-4)
    laws, parameters = {"nominal": law, "perturbed": Pid(kp=3.0)}, {"nominal": found.values}
    (tmp_path / "c.yaml").write_text(controller_text("Made by a test.", "a command", laws, parameters))
    loaded = load_controller(tmp_path / "c.yaml")
    assert (loaded.nominal, loaded.perturbed) == (law, Pid(kp=3.0))
    assert read_parameters(tmp_path / "c.yaml")["nominal"] == pytest.approx(found.values)


@pytest.mark.parametrize(
    "settings", [{"section": 1.0}, {"sections": 1.5}, {"sections": 99.0}, {"acceleration_sections": 1.0}]
)
def test_wrong_structures_are_refused(settings: dict[str, float]) -> None:
    with pytest.raises(InputError):
        structure_of(settings)
