"""From a log to the responses of its positions, and the many ways in which a log is spoilt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.frf.positions import estimate_responses
from flexros.identify.frf.settings import FrfSettings
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.logs.time_series import Log
from flexros.robot.linear.positions import linearise_positions
from tests.identify.frf.recorded_experiment import Recorded, cut, run

pytestmark = pytest.mark.slow


def model_of(recorded: Recorded, responses: tuple[FrequencyResponse, ...]) -> np.ndarray:
    """The sampled response of the robot at the measured positions, shape (Q, F, M, M)."""
    positions = linearise_positions(recorded.robot, (), np.array([mine.motor_position for mine in responses]))
    model = FrequencyModel(positions, responses[0].frequency, recorded.plan.sample_time, recorded.robot.delay)
    return np.asarray(model.response(positions.values))


def with_torque(log: Log, torque: np.ndarray) -> Log:
    assert log.joint_commands is not None
    return replace(log, joint_commands=replace(log.joint_commands, effort=torque))


def torque_of(log: Log) -> np.ndarray:
    assert log.joint_commands is not None
    return np.array(log.joint_commands.effort)


def test_responses_are_those_of_the_robot_within_their_deviation(recorded: Recorded) -> None:
    responses = estimate_responses(recorded.log, recorded.plan, robot=recorded.robot)
    assert len(responses) == 2
    np.testing.assert_allclose(responses[1].motor_position, [0.1, 0.5], atol=0.01)
    np.testing.assert_array_equal(responses[1].gears, [0.1, 0.5])
    models = model_of(recorded, responses)
    for mine, model in zip(responses, models):
        assert (mine.n_blocks, mine.n_periods, mine.quantity) == (2, 2, "acceleration")
        assert mine.output_units == ("rad/s²", "rad/s²")
        square = abs(mine.response - model) ** 2 / mine.standard_deviation() ** 2
        assert 0.4 < np.median(square) / np.log(2) < 2.5
        assert np.median(abs(mine.response / model - 1)) < 0.02


def test_reference_unknown_gives_nearly_the_same(recorded: Recorded) -> None:
    known = estimate_responses(recorded.log, recorded.plan)
    unknown = estimate_responses(replace(recorded.log, joint_reference=None), recorded.plan)
    for a, b in zip(known, unknown):
        assert np.max(abs(a.response - b.response) / a.standard_deviation()) < 1.0


def test_chirp_is_estimated_by_local_polynomials() -> None:
    chirp = {"kind": "chirp", "duration": 8, "from_hz": 30, "to_hz": 3, "rest_after": 2, "amplitude": 0.1}
    recorded = run(positions=[[0.0, 0.3]], blocks=1, periods=1, excitation=chirp)
    responses = estimate_responses(recorded.log, recorded.plan, robot=recorded.robot)
    model = model_of(recorded, responses)[0]
    diagonal = np.einsum("fii->fi", responses[0].response / model)
    assert np.median(abs(diagonal - 1)) < 0.05
    assert responses[0].distortion is None


def test_constant_speed_under_the_excitation_is_taken_off() -> None:
    slow = {"kind": "constant_speed", "speed": 0.02, "allow_reversal": True}
    recorded = run(positions=[[0.0, 0.3]], slow_motion=slow)
    responses = estimate_responses(recorded.log, recorded.plan, robot=recorded.robot)
    model = model_of(recorded, responses)[0]
    diagonal = np.einsum("fii->fi", responses[0].response / model)
    assert np.median(abs(diagonal - 1)) < 0.03


def test_log_cut_short_is_refused_or_used_as_far_as_complete(recorded: Recorded) -> None:
    short = cut(recorded.log, slice(0, recorded.plan.segments[-1].stop - 100))
    with pytest.raises(
        InputError, match="too short a log: it ends at .*, position 2, block 2, experiment 2 lasts until"
    ):
        estimate_responses(short, recorded.plan)
    first, second = estimate_responses(short, recorded.plan, FrfSettings(partial=True))
    assert (first.n_blocks, second.n_blocks) == (2, 1)
    assert "the log ends before its plan; 1 incomplete blocks were left out" in second.warnings


def test_log_without_a_complete_block_is_refused(recorded: Recorded) -> None:
    short = cut(recorded.log, slice(0, recorded.plan.segments[0].stop))
    with pytest.raises(InputError, match="too short a log: it ends at .*, before the first block is complete at"):
        estimate_responses(short, recorded.plan, FrfSettings(partial=True))


def stopped(recorded: Recorded, at: int) -> Log:
    """The log of an experiment that was stopped at a sample, after which the motion is slowed down to rest."""
    torque = torque_of(recorded.log)
    torque[at:] *= 0.1
    provenance = {**recorded.log.provenance, "stopped": {"stopped_at_sample": at, "state": "stopping"}}
    return replace(with_torque(recorded.log, torque), provenance=provenance)


def test_motion_after_a_stop_is_not_taken_for_the_plan(recorded: Recorded) -> None:
    segments = recorded.plan.segments
    log = stopped(recorded, segments[-1].stop - 1)
    first, second = estimate_responses(log, recorded.plan, FrfSettings(partial=True))
    assert (first.n_blocks, second.n_blocks) == (2, 1)
    assert "the experiment was stopped before its plan; 1 incomplete blocks were left out" in second.warnings
    whole = estimate_responses(recorded.log, recorded.plan)
    np.testing.assert_array_equal(first.response, whole[0].response)


def test_block_that_ended_before_the_stop_counts_as_planned(recorded: Recorded) -> None:
    log = stopped(recorded, recorded.plan.segments[-1].stop)
    for settings in (FrfSettings(), FrfSettings(partial=True)):
        responses = estimate_responses(log, recorded.plan, settings)
        assert [mine.n_blocks for mine in responses] == [2, 2]
        assert not any("stopped" in warning for mine in responses for warning in mine.warnings)


def test_stopped_experiment_is_refused_unless_a_part_suffices(recorded: Recorded) -> None:
    log = stopped(recorded, recorded.plan.segments[2].stop)
    with pytest.raises(
        InputError, match=r"was stopped at \d+\.\d+ s, when 3 of 8 experiments were complete, .*partial=true"
    ):
        estimate_responses(log, recorded.plan)


def test_experiment_that_was_stopped_before_its_first_block_ended_is_refused(recorded: Recorded) -> None:
    log = stopped(recorded, recorded.plan.segments[1].stop - 1)
    with pytest.raises(
        InputError, match="too short an experiment: it was stopped at .*, before the first block is complete at"
    ):
        estimate_responses(log, recorded.plan, FrfSettings(partial=True))


def test_gap_is_named(recorded: Recorded) -> None:
    inside = recorded.plan.segments[3].first + 10
    keep = np.delete(np.arange(recorded.plan.n_samples), np.arange(inside, inside + 6))
    with pytest.raises(
        InputError, match="gap: 6 samples of joint_states are missing in position 1, block 2, experiment 2"
    ):
        estimate_responses(cut(recorded.log, keep), recorded.plan)


def test_short_gap_is_bridged_with_a_warning(recorded: Recorded) -> None:
    inside = recorded.plan.segments[3].first + 10
    keep = np.delete(np.arange(recorded.plan.n_samples), [inside, inside + 1])
    whole, bridged = (estimate_responses(log, recorded.plan)[0] for log in (recorded.log, cut(recorded.log, keep)))
    size = np.abs(whole.response).max(axis=0)
    assert np.median(np.abs(bridged.response - whole.response) / size) < 2e-3
    assert any("2 samples of joint_states are missing" in text for text in bridged.warnings)


def with_commands(log: Log, keep: slice) -> Log:
    """Keep some of the commands."""
    return replace(log, joint_commands=cut(log, keep).joint_commands)


def test_commands_that_begin_late_are_named(recorded: Recorded) -> None:
    late = with_commands(recorded.log, slice(recorded.plan.segments[0].stop, None))
    for settings in (FrfSettings(), FrfSettings(partial=True)):
        with pytest.raises(InputError, match="the commands of the log begin at .*, position 1, block 1, experiment 1"):
            estimate_responses(late, recorded.plan, settings)


def test_commands_that_end_early_are_named_or_used_as_far_as_complete(recorded: Recorded) -> None:
    segments = recorded.plan.segments
    early = with_commands(recorded.log, slice(0, segments[-1].stop - 1))
    with pytest.raises(InputError, match="the commands of the log end at .*, position 2, block 2, experiment 2 lasts"):
        estimate_responses(early, recorded.plan)
    first, second = estimate_responses(early, recorded.plan, FrfSettings(partial=True))
    assert (first.n_blocks, second.n_blocks) == (2, 1)
    assert "the commands of the log end before its plan; 1 incomplete blocks were left out" in first.warnings
    earlier = with_commands(recorded.log, slice(0, segments[0].stop))
    with pytest.raises(InputError, match="too short a log: its commands end at .*, before the first block is complete"):
        estimate_responses(earlier, recorded.plan, FrfSettings(partial=True))


def test_log_of_every_tenth_sample_is_aliasing(recorded: Recorded) -> None:
    with pytest.raises(
        InputError, match="aliasing: joint_states is sampled at 66.6667 Hz, so what is excited up to 39"
    ):
        estimate_responses(cut(recorded.log, slice(None, None, 30)), recorded.plan)


def test_noise_alone_is_no_excitation(recorded: Recorded) -> None:
    noise = np.random.default_rng(0).standard_normal(torque_of(recorded.log).shape)
    with pytest.raises(InputError, match="position 1: no excitation: the torque of motor_"):
        estimate_responses(with_torque(recorded.log, noise), recorded.plan)


def test_period_that_was_not_excited_is_missing(recorded: Recorded) -> None:
    torque, segment = torque_of(recorded.log), recorded.plan.segments[1]
    torque[segment.first + segment.period : segment.stop] = 0
    with pytest.raises(InputError, match="position 1: period 2 of experiment 2 is missing"):
        estimate_responses(with_torque(recorded.log, torque), recorded.plan)


def test_saturated_torque_is_named(recorded: Recorded) -> None:
    torque = torque_of(recorded.log)
    limit = 0.3 * np.max(abs(torque[recorded.plan.segments[0].first : recorded.plan.segments[0].stop, 0]))
    with pytest.raises(InputError, match="position 1: saturated torque: the command of motor_"):
        estimate_responses(with_torque(recorded.log, np.clip(torque, -limit, limit)), recorded.plan)


def test_swapped_commands_are_named(recorded: Recorded) -> None:
    swapped = with_torque(recorded.log, torque_of(recorded.log)[:, ::-1].copy())
    with pytest.raises(InputError, match="position 1: swapped joints: the command of motor_1 moves motor_2"):
        estimate_responses(swapped, recorded.plan)


def test_joints_swapped_everywhere_are_named(recorded: Recorded) -> None:
    log = recorded.log
    series = {}
    for name in ("joint_states", "joint_commands", "joint_reference"):
        mine = getattr(log, name)
        series[name] = replace(mine, names=("motor_2", "motor_1"))
    swapped = replace(log, **series)
    with pytest.raises(
        InputError, match="swapped joints: motor_1 is at the position of motor_2, motor_2 is at the position of motor_1"
    ):
        estimate_responses(swapped, recorded.plan, robot=recorded.robot)


def test_joints_that_follow_the_reference_of_another_are_named() -> None:
    recorded = run(positions=[[0.3, 0.3]], blocks=1)
    assert estimate_responses(recorded.log, recorded.plan)
    series = {}
    for name in ("joint_states", "joint_commands"):
        mine = getattr(recorded.log, name)
        series[name] = replace(mine, names=("motor_2", "motor_1"))
    with pytest.raises(
        InputError, match="position 1: swapped joints: motor_2 follows the reference of motor_1, not its"
    ):
        estimate_responses(replace(recorded.log, **series), recorded.plan)


def test_transient_in_the_record_is_warned_of_and_modelled_by_local_polynomials() -> None:
    recorded = run(positions=[[0.0, 0.3]], transient_periods=0)
    periodic = estimate_responses(recorded.log, recorded.plan)
    assert any("not settled" in warning for warning in periodic[0].warnings)
    settings = FrfSettings(method="local_polynomial", thinned=False)
    polynomial = estimate_responses(recorded.log, recorded.plan, settings)
    model = model_of(recorded, periodic)[0]
    worse, better = (np.median(abs(r[0].response / model - 1)) for r in (periodic, polynomial))
    assert better < 0.5 * worse


def test_coulomb_friction_shows_on_odd_lines_and_predicts_the_scatter_over_blocks() -> None:
    friction = tuple(f"coulomb_friction@motor_{i}:level=40" for i in (1, 2))
    recorded = run(friction, positions=[[0.0, 0.3]], blocks=3)
    found = estimate_responses(recorded.log, recorded.plan)[0].distortion
    assert found is not None
    odd, even, total, noise = (np.median(part, axis=0) for part in (found.odd, found.even, found.total, found.noise))
    assert np.all(odd > 5 * noise)
    assert np.all(odd > 2 * even)
    np.testing.assert_allclose(odd / total, 1.0, atol=0.6)
