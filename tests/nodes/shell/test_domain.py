"""ROS domain of a run."""

from __future__ import annotations

import os
import socket

import pytest

from flexros.errors import InputError
from flexros_nodes.shell.domain import LAST_DOMAIN, claim_domain, domain_of_run, environment


def occupied(domain: int) -> socket.socket:
    participant = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    participant.bind(("", 7400 + 250 * domain + 10))
    return participant


def test_domain_with_a_participant_is_not_chosen() -> None:
    with domain_of_run({}, 40) as first:
        pass
    with occupied(first), domain_of_run({}, first - 1) as other:
        assert other != first


def test_domain_of_a_run_that_only_begins_is_not_chosen() -> None:
    with domain_of_run({}, 40) as first, domain_of_run({}, first - 1) as second:
        assert first != second


def test_claim_ends_with_the_run() -> None:
    with domain_of_run({}, 40) as first:
        pass
    with domain_of_run({}, first - 1) as second:
        assert first == second


@pytest.mark.parametrize("start", [0, 7, 100, 4_194_304])
def test_domain_is_between_1_and_101(start: int) -> None:
    with domain_of_run({}, start) as domain:
        assert 1 <= domain <= LAST_DOMAIN


def test_domain_of_the_user_stays_and_may_have_participants() -> None:
    domain, claim = claim_domain(17)
    with claim, occupied(domain), domain_of_run({"ROS_DOMAIN_ID": str(domain)}, 5) as kept:
        assert kept == domain


@pytest.mark.parametrize("domain", ["-1", "233", "lab"])
def test_domain_that_is_none_is_bad_input(domain: str) -> None:
    with (
        pytest.raises(InputError, match=f"ROS_DOMAIN_ID is '{domain}', allowed is a number from 0 to 232; correct"),
        domain_of_run({"ROS_DOMAIN_ID": domain}, 5),
    ):
        pass


def test_environment_is_restored(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FLEXROS_ONE", "before")
    monkeypatch.delenv("FLEXROS_TWO", raising=False)
    with environment({"FLEXROS_ONE": "inside", "FLEXROS_TWO": "inside"}):
        assert os.environ["FLEXROS_ONE"] == os.environ["FLEXROS_TWO"] == "inside"
    assert os.environ["FLEXROS_ONE"] == "before"
    assert "FLEXROS_TWO" not in os.environ
