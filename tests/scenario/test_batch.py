"""Batches give what single runs give, on any number of lanes and threads."""

from __future__ import annotations

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.scenario.batch import RunRecord, batch, whole_record
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario

CIRCLE = Experiment.prepare(load_scenario("circle_dae"))
NOISY = Experiment.prepare(load_scenario("circle_dae").with_values({"noise": True, "duration": 0.1}))


def radial_error(record: RunRecord) -> float:
    distance = np.hypot(record.tool_pose[:, 0] - 2.121403786951, record.tool_pose[:, 2] + 0.354624247994)
    return float(1e3 * np.max(np.abs(distance - 0.025)))


@pytest.mark.slow
def test_load_sweep_gives_the_figures_of_single_runs() -> None:
    errors = batch(CIRCLE, radial_error, values={"body_3.mass": [190.0, 200.0, 210.0]})
    np.testing.assert_allclose(errors, [1.2486502659747738, 0.3292, 1.4149781413518685], rtol=1e-3)


@pytest.mark.slow
def test_gain_sweep_equals_single_runs_to_the_last_bit() -> None:
    kp = np.linspace(1e5, 2e5, 11)  # two groups of eight lanes, the second one not full
    records = batch(CIRCLE, whole_record, gains={"motor_1.kp": kp, "motor_2.kp": kp})
    for k in (0, 7, 10):
        single = closed_loop(Experiment.prepare(CIRCLE.scenario.with_values({"controller.kp": float(kp[k])})))
        assert single.joint_commands is not None
        assert np.array_equal(records[k].encoder, single.joint_states.position)  # type: ignore[arg-type]
        assert np.array_equal(records[k].command, single.joint_commands.effort)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("n_runs", [1, 2, 5])
def test_seeds_equal_single_runs_to_the_last_bit(n_runs: int) -> None:
    records = batch(NOISY, whole_record, seeds=range(3, 3 + n_runs))
    for k, record in enumerate(records):
        single = closed_loop(Experiment.prepare(NOISY.scenario.with_values({"seed": 3 + k})))
        assert single.tool_pose is not None
        assert np.array_equal(record.encoder, single.joint_states.position)  # type: ignore[arg-type]
        assert np.array_equal(record.tool_pose[:, :3], single.tool_pose.position)


def test_threads_do_not_change_the_result() -> None:
    masses = {"body_3.mass": np.linspace(150.0, 250.0, 40)}
    one, two = (batch(NOISY, radial_error, values=masses, threads=threads) for threads in (1, 2))
    assert one == two


def test_heavier_plant_starts_at_its_own_rest_under_gravity() -> None:
    elbow = Experiment.prepare(load_scenario("elbow_moves").with_values({"duration": 0.1, "noise": False}))
    records = batch(elbow, whole_record, values={"body_2.mass": [45.0, 60.0]})
    heavy = closed_loop(Experiment.prepare(elbow.scenario.with_values({"plant.values.body_2.mass": 60.0})))
    assert heavy.tool_pose is not None
    np.testing.assert_allclose(records[1].tool_pose[:, :3], heavy.tool_pose.position, atol=1e-12)
    assert np.max(np.abs(records[0].tool_pose[0] - records[1].tool_pose[0])) > 1e-4


def test_run_that_diverges_ends_early_and_leaves_the_others_alone() -> None:
    good, bad = batch(CIRCLE, whole_record, gains={"motor_1.kp": [135000.0, 1e12]})
    assert (good.diverged, len(good.encoder)) == (-1, CIRCLE.n_samples)
    assert 0 < bad.diverged < CIRCLE.n_samples
    assert len(bad.encoder) == bad.diverged
    assert np.all(np.isfinite(bad.encoder))
    assert radial_error(good) == pytest.approx(0.3292, rel=1e-3)


def test_progress_counts_runs() -> None:
    seen: list[int] = []
    batch(NOISY, radial_error, seeds=range(20), progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 20


def test_interrupt_ends_the_batch() -> None:
    def interrupt(_done: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch(NOISY, radial_error, seeds=range(100), threads=1, progress=interrupt)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({}, "batch: nothing were given, allowed is the same number for all, at least one"),
        ({"seeds": []}, "batch: 0 seeds were given"),
        ({"seeds": [1], "gains": {"motor_1.kp": [1.0, 2.0]}}, r"batch: 2 gains motor_1\.kp, 1 seeds were given"),
        ({"gains": {"motor_1.kq": [1.0]}}, r"unknown gain of controller pid 'motor_1\.kq' .* did you mean 'motor_1\.k"),
        ({"values": {"body_3.mas": [1.0]}}, r"'body_3\.mas'.*did you mean 'body_3\.mass'"),
        ({"values": {"body_3.mass": [np.nan]}}, r"batch: values of body_3\.mass are \[nan\], allowed is one finite"),
        ({"values": {"body_3.mass": [-1.0]}}, r"run 0 of the batch.*-1"),
    ],
)
def test_impossible_sets_are_refused(settings: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        batch(NOISY, radial_error, **settings)  # type: ignore[arg-type]
