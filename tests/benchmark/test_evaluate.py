"""The benchmark against the figures of an independent program, without noise."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.benchmark.controllers import load_controller
from flexros.benchmark.evaluate import BenchmarkResult, FeedbackBenchmark, check_noise
from flexros.errors import InputError

NOMINAL = (
    (6.394231, 2.237633, 4.344339, 1.831782, 6.745142, 2.642187, 4.704829, 1.675920),
    (0.6320, 0.6225, 1.0485, 0.8150),
    (14.123579, 1.088730),
    68.488846,
)
M1 = (
    (7.248418, 2.327360, 5.074995, 1.933276, 7.552092, 2.778657, 5.343190, 1.734427),
    (0.6510, 0.6300, 1.1775, 0.9140),
    (14.614554, 1.137823),
    74.354877,
)


@pytest.fixture(scope="module")
def benchmark() -> FeedbackBenchmark:
    return FeedbackBenchmark()


@pytest.fixture(scope="module")
def checked(benchmark: FeedbackBenchmark) -> BenchmarkResult:
    return benchmark.evaluate(load_controller("pid_check"), noise=0.0)


def test_cost_without_noise_is_that_of_an_independent_program(checked: BenchmarkResult) -> None:
    assert checked.cost == pytest.approx(138.903095, abs=1e-6)


@pytest.mark.parametrize(("name", "table"), [("nominal", NOMINAL), ("M1", M1)])
def test_measures_without_noise_are_those_of_an_independent_program(
    checked: BenchmarkResult, name: str, table: tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], float]
) -> None:
    deflection, settling, torque, cost = table
    found = checked.measures[name]
    np.testing.assert_allclose(found.deflection, deflection, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found.settling, settling, rtol=0, atol=1e-9)
    np.testing.assert_allclose((found.largest_torque, found.rms_torque), torque, rtol=0, atol=1e-6)
    assert found.noise_torque == 0.0
    assert found.cost == pytest.approx(cost, abs=1e-6)


def test_json_has_the_keys_of_the_contract(checked: BenchmarkResult) -> None:
    content = checked.as_dict()
    assert {"V", "sets", "demands"} <= set(content)
    assert set(content["sets"]) == {"nominal", "M1", "M2"}
    for measures in content["sets"].values():
        assert set(measures) == {"e", "Ts", "T_NOISE", "T_MAX", "T_RMS", "V"}
        assert (len(measures["e"]), len(measures["Ts"])) == (8, 4)


def test_check_controller_meets_all_demands(checked: BenchmarkResult) -> None:
    assert checked.passed
    assert len(checked.demands) == 21


def test_built_in_pid_of_the_scenario_costs_what_an_independent_program_found(benchmark: FeedbackBenchmark) -> None:
    result = benchmark.evaluate(load_controller("pid_regulator"))
    assert result.cost == pytest.approx(154.6, abs=0.3)
    assert len(result.costs) == 5
    assert np.ptp(result.costs) > 0.1


@pytest.mark.parametrize(
    ("noise", "seeds"), [(-1.0, (1,)), (float("nan"), (1,)), (1e-4, ()), (1e-4, (1, 1)), (0.0, (-1,))]
)
def test_invalid_noise_and_seeds_are_refused(noise: float, seeds: tuple[int, ...]) -> None:
    with pytest.raises(InputError):
        check_noise(noise, seeds)
