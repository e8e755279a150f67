"""Progress of an experiment, in numbers and words."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flexros.errors import RunError
from flexros.identify.experiment.plan import ExperimentPlan
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import load_scenario
from flexros_nodes.protocol.experiment_state import ExperimentCourse, read_experiment_state


@pytest.fixture
def plan(identification_scenario: Path) -> ExperimentPlan:
    return plan_of_scenario(load_scenario(identification_scenario))


def serialised(text: str) -> bytes:
    """A std_msgs/msg/String in little-endian CDR."""
    data = text.encode() + b"\0"
    return b"\0\1\0\0" + len(data).to_bytes(4, "little") + data


def test_course_follows_the_segments_of_the_plan(plan: ExperimentPlan) -> None:
    course = ExperimentCourse(plan)
    third = plan.segments[2]
    state = course.state("running", third.first)
    assert (state.position, state.positions, state.block, state.blocks) == (2, 2, 1, 2)
    assert (state.experiment, state.experiments, state.completed, state.planned) == (1, 1, 2, 4)
    assert state.recording
    assert not course.state("running", third.first - 1).recording
    assert course.state("running", third.stop).completed == 3


def test_time_left_and_share_reach_their_ends(plan: ExperimentPlan) -> None:
    course, last = ExperimentCourse(plan), plan.n_samples - 1
    begin, end = course.state("running", 0), course.state("done", last)
    assert (begin.percent, begin.time_left_s) == (0.0, pytest.approx(plan.duration))
    assert (end.percent, end.time_left_s, end.completed) == (100.0, 0.0, 4)
    assert begin.last_sample == end.last_sample == last


def test_stopped_experiment_counts_what_was_complete_before_the_stop(plan: ExperimentPlan) -> None:
    course, second = ExperimentCourse(plan), plan.segments[1]
    state = course.state("stopping", second.stop + 100, (second.stop - 1, second.stop + 150))
    assert (state.completed, state.last_sample, state.stopped_at_sample) == (1, second.stop + 150, second.stop - 1)
    assert (state.position, state.block) == (1, 2)
    assert state.time_left_s == pytest.approx(0.05)
    assert course.state("stopping", second.stop, (second.stop, second.stop + 1)).completed == 2


def test_stop_takes_the_fade_time_in_an_experiment_and_longer_in_a_move(plan: ExperimentPlan) -> None:
    course, (first, second) = ExperimentCourse(plan), plan.visits
    assert course.n_slowing(0) == 1
    ends = first.begin_first + first.n_experiments * first.experiment
    assert course.n_slowing(first.begin_first) == course.n_slowing(ends - 1) == 50
    move = plan.specification.move
    braking = 1.875 * float(move.speed) / float(move.acceleration)  # type: ignore[arg-type]
    assert course.n_slowing(second.begin + 10) == round(braking / plan.sample_time)


@pytest.mark.parametrize(
    ("state", "sentence"),
    [
        ("waiting", "waiting for the service start"),
        ("running", "recording position 2 of 2, block 1 of 2, experiment 1 of 1; "),
        ("stopping", "stopped at position 2 of 2, block 1 of 2, experiment 1 of 1; 2 of 4 experiments are complete"),
        ("done", "all 4 experiments are complete"),
    ],
)
def test_state_in_words(plan: ExperimentPlan, state: str, sentence: str) -> None:
    assert ExperimentCourse(plan).state(state, plan.segments[2].first).sentence().startswith(sentence)


def test_state_between_two_records_is_on_the_way(plan: ExperimentPlan) -> None:
    sentence = ExperimentCourse(plan).state("running", 0).sentence()
    assert sentence.startswith("moving to position 1 of 2, block 1 of 2, experiment 1 of 1; 0.0 % done, ")


def test_stop_before_the_first_sample_names_no_experiment(plan: ExperimentPlan) -> None:
    sentence = ExperimentCourse(plan).state("stopping", 0, (0, 600)).sentence()
    assert sentence == "stopped before the start; no experiment was run"


def test_message_is_read_back(plan: ExperimentPlan) -> None:
    state = ExperimentCourse(plan).state("stopping", 700, (600, 900))
    assert read_experiment_state(serialised(state.as_json())) == state


@pytest.mark.parametrize(
    "message",
    [
        serialised("running"),
        serialised("{}"),
        serialised("[1]"),
        b"\0\1\0\0\xff\xff\xff\x7f",
    ],
    ids=["no JSON", "no keys", "no mapping", "no text"],
)
def test_message_of_something_else_is_refused(message: bytes) -> None:
    with pytest.raises(RunError, match="a message on experiment_state is rejected: .*; required is JSON with the keys"):
        read_experiment_state(message)


@pytest.mark.parametrize("number", ["1" + 400 * "0", "1e400", "NaN", "-1e16"])
def test_numbers_out_of_all_bounds_are_refused(plan: ExperimentPlan, number: str) -> None:
    text = json.dumps({**json.loads(ExperimentCourse(plan).state("running", 0).as_json()), "percent": 0})
    with pytest.raises(RunError, match="percent must be a number of at most 1e"):
        read_experiment_state(serialised(text.replace('"percent": 0', f'"percent": {number}')))


def test_state_that_does_not_exist_is_refused(plan: ExperimentPlan) -> None:
    text = ExperimentCourse(plan).state("running", 0).as_json().replace('"running"', '"runing"')
    with pytest.raises(RunError, match="state is 'runing'"):
        read_experiment_state(serialised(text))
