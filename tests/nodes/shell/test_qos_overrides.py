"""Quality of service changed by parameters: limits, and effect on nodes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from flexros.config.topics import QosProfile, load_topics
from flexros.errors import InputError
from flexros_nodes.shell.qos_overrides import override_problem

OBSERVER, LOOP = load_topics()["joint_states"].qos, load_topics()["joint_states"].subscription_qos
STREAM, CLOCK = load_topics()["joint_reference_ahead"].qos, load_topics()["clock"].qos
LATCHED = load_topics()["robot_description"].qos
Bench = Any  # the class is in conftest


def problem(profile: QosProfile, publisher: bool, **changes: Any) -> str:
    stated = {key: getattr(profile, key) for key in ("history", "depth", "reliability", "durability")}
    return override_problem(profile, publisher, **{**stated, **changes})


@pytest.mark.parametrize("name", sorted(load_topics()))
def test_shipped_profiles_are_allowed(name: str) -> None:
    row = load_topics()[name]
    assert problem(row.qos, True) == problem(row.qos, False) == problem(row.subscription_qos, False) == ""


@pytest.mark.parametrize(
    ("profile", "publisher", "changes"),
    [
        (OBSERVER, True, {"depth": 5000}),
        (OBSERVER, True, {"durability": "transient_local"}),
        (OBSERVER, False, {"reliability": "best_effort"}),
        (LOOP, False, {"reliability": "best_effort", "depth": 1}),
        (CLOCK, True, {"reliability": "reliable"}),
        (LATCHED, False, {"durability": "volatile"}),
    ],
)
def test_publisher_may_offer_more_and_subscription_ask_for_less(
    profile: QosProfile, publisher: bool, changes: dict[str, Any]
) -> None:
    assert problem(profile, publisher, **changes) == ""


@pytest.mark.parametrize(
    ("profile", "publisher", "changes", "sentence"),
    [
        (OBSERVER, True, {"depth": 0}, "depth is 0, allowed is 100 to 100000: fewer would be overwritten"),
        (LOOP, False, {"depth": -1}, "depth is -1, allowed is 1 to 100000"),
        (LOOP, False, {"depth": 2**40}, "allowed is 1 to 100000: more have no effect"),
        (OBSERVER, True, {"reliability": "best_effort"}, "reliability is best_effort, allowed is reliable: a subsc"),
        (
            LATCHED,
            True,
            {"durability": "volatile"},
            "durability is volatile, allowed is transient_local: a subscription",
        ),
        (
            CLOCK,
            False,
            {"reliability": "reliable"},
            "is reliable, allowed is best_effort: a publisher that offers less",
        ),
        (LOOP, False, {"durability": "transient_local"}, "durability is transient_local, allowed is volatile: a publ"),
        (STREAM, False, {"reliability": "best_effort"}, "allowed is reliable: none of these messages may be lost"),
        (LOOP, False, {"history": "keep_all"}, "history is keep_all, allowed is keep_last: with keep_all a slow"),
        (LOOP, False, {"reliability": "system_default"}, "is system_default, allowed is best_effort or reliable"),
    ],
)
def test_what_would_break_the_loop_is_refused(
    profile: QosProfile, publisher: bool, changes: dict[str, Any], sentence: str
) -> None:
    assert sentence in problem(profile, publisher, **changes)


def given(bench: Bench, **overrides: Any) -> Any:
    from flexros_nodes.controller.node import ControllerNode

    values = {f"qos_overrides.{name}": value for name, value in overrides.items()}
    return bench.add(ControllerNode, observers=0, **values)


def test_node_takes_its_overrides_at_every_configuration(bench: Bench) -> None:
    names = {"/joint_commands.publisher.depth": 300, "/joint_states.subscription.reliability": "best_effort"}
    node = given(bench, **names)
    for _ in range(2):
        node.trigger_configure()
        depth = {publisher.topic_name: publisher.qos_profile.depth for publisher in node.publishers}
        asked = {each.topic_name: each.qos_profile.reliability.name for each in node.subscriptions}
        assert (depth["/joint_commands"], depth["/joint_reference"]) == (300, 2000)
        assert (asked["/joint_states"], asked["/joint_reference_ahead"]) == ("BEST_EFFORT", "RELIABLE")
        assert node.describe_parameter("qos_overrides./joint_commands.publisher.depth").read_only
        node.trigger_cleanup()


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("/joint_commands.publisher.reliability", "best_effort", "reliability is best_effort, allowed is reliable"),
        ("/joint_commands.publisher.reliability", "fast", "Unexpected QoS override for policy `reliability`: `fast`"),
        ("/joint_commands.publisher.depth", "many", "of type 'STRING', expecting type 'INTEGER'"),
    ],
)
def test_override_that_is_refused_fails_the_configuration(bench: Bench, name: str, value: Any, sentence: str) -> None:
    node = given(bench, **{name: value})
    node.trigger_configure()
    assert node.report.exit_code == 2
    assert node.report.message.startswith("parameter qos_overrides./joint_commands.publisher of node controller: ")
    assert sentence in node.report.message
    assert node.report.message.endswith("; correct or omit it")


def test_override_of_diagnostics_is_rejected_at_construction(bench: Bench) -> None:
    with pytest.raises(
        InputError, match="qos_overrides./diagnostics.publisher of node controller: depth is 1, allowed"
    ):
        given(bench, **{"/diagnostics.publisher.depth": 1})


def test_executable_ends_with_exit_code_2(ros_domain: int, start_node: Callable[..., Any]) -> None:
    process = start_node("controller", "qos_overrides./joint_commands.publisher.depth:=0")
    _, errors = process.communicate(timeout=60.0)
    assert process.returncode == 2
    assert (
        "error: parameter qos_overrides./joint_commands.publisher of node controller: depth is 0, allowed is" in errors
    )


def test_loop_runs_over_best_effort_subscriptions(bench: Bench) -> None:
    controller = given(bench, **{"/joint_states.subscription.reliability": "best_effort"})
    from flexros_nodes.feedforward import FeedforwardNode
    from flexros_nodes.plant.node import PlantNode

    override = {"qos_overrides./joint_commands.subscription.reliability": "best_effort"}
    plant = bench.add(PlantNode, observers=0, **override)
    nodes = (bench.add(FeedforwardNode, observers=0), controller, plant)
    for step in ("trigger_configure", "trigger_activate"):
        for node in nodes:
            getattr(node, step)()
    bench.spin_until(lambda: plant.report is not None)
    assert (plant.report.exit_code, plant.report.figures["samples"]) == (0, 762)
