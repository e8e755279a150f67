"""ROS domain and discovery range of a run."""

from __future__ import annotations

import os
import socket

import pytest

from flexros.errors import InputError
from flexros_nodes.domain import LAST_DOMAIN, environment, free_domain, run_environment


def occupied(domain: int) -> socket.socket:
    participant = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    participant.bind(("", 7400 + 250 * domain + 10))
    return participant


def test_domain_with_a_participant_is_not_chosen() -> None:
    first = free_domain(40)
    with occupied(first):
        assert free_domain(first - 1) != first


@pytest.mark.parametrize("start", [0, 7, 100, 4_194_304])
def test_domain_is_between_1_and_101(start: int) -> None:
    assert 1 <= free_domain(start) <= LAST_DOMAIN


def test_run_stays_on_this_machine_in_a_domain_of_its_own() -> None:
    settings = run_environment({}, 5)
    assert settings["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
    assert 1 <= int(settings["ROS_DOMAIN_ID"]) <= LAST_DOMAIN


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ({"ROS_DOMAIN_ID": "17"}, "ROS_DOMAIN_ID"),
        ({"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}, "ROS_AUTOMATIC_DISCOVERY_RANGE"),
        ({"ROS_LOCALHOST_ONLY": "1"}, "ROS_AUTOMATIC_DISCOVERY_RANGE"),
    ],
)
def test_what_the_user_has_set_stays(given: dict[str, str], kept: str) -> None:
    assert kept not in run_environment(given, 5)


@pytest.mark.parametrize("domain", ["-1", "233", "lab"])
def test_domain_that_is_none_is_bad_input(domain: str) -> None:
    with pytest.raises(InputError, match=f"ROS_DOMAIN_ID is '{domain}', allowed is a number from 0 to 232; correct"):
        run_environment({"ROS_DOMAIN_ID": domain}, 5)


def test_environment_comes_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLEXROS_ONE", "before")
    monkeypatch.delenv("FLEXROS_TWO", raising=False)
    with environment({"FLEXROS_ONE": "inside", "FLEXROS_TWO": "inside"}):
        assert os.environ["FLEXROS_ONE"] == os.environ["FLEXROS_TWO"] == "inside"
    assert os.environ["FLEXROS_ONE"] == "before"
    assert "FLEXROS_TWO" not in os.environ
