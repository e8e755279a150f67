"""Claims of topics: one producer per domain and topic on a machine."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros_nodes.shell.claims import TopicClaim, refuse_claims_of_others

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="claims are abstract sockets of Linux")

DOMAIN = 90_000 + os.getpid()
TOPIC = "/joint_commands"
CHECKOUT = Path(__file__).parents[3]


def test_second_producer_of_a_topic_is_refused_until_the_first_releases_it() -> None:
    first = TopicClaim(DOMAIN, TOPIC, "", {})
    with pytest.raises(
        InputError, match=rf"a controller of another run is in ROS domain {DOMAIN}: another node of this"
    ):
        TopicClaim(DOMAIN, TOPIC, "", {})
    first.release()
    TopicClaim(DOMAIN, TOPIC, "", {}).release()


@pytest.mark.parametrize("other", [(DOMAIN + 1, TOPIC), (DOMAIN, "/left/joint_commands"), (DOMAIN, "/joint_states")])
def test_other_domains_namespaces_and_topics_do_not_collide(other: tuple[int, str]) -> None:
    first, second = TopicClaim(DOMAIN, TOPIC, "one", {}), TopicClaim(*other, "two", {})
    for held in ((DOMAIN, TOPIC), other):
        with pytest.raises(InputError):
            TopicClaim(*held, "three", {})
    first.release()
    second.release()


def test_process_alone_in_its_domain_needs_no_claim() -> None:
    off = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "OFF"}
    first = TopicClaim(DOMAIN, TOPIC, "", {})
    TopicClaim(DOMAIN, TOPIC, "", off).release()
    refuse_claims_of_others(DOMAIN, TOPIC, "mine", off)
    first.release()


def test_only_nodes_of_another_run_are_refused() -> None:
    claim = TopicClaim(DOMAIN, TOPIC, "mine", {})
    refuse_claims_of_others(DOMAIN, TOPIC, "mine", {})
    refuse_claims_of_others(DOMAIN, TOPIC, "", {})  # a node started by itself takes part in any run
    with pytest.raises(InputError, match="of another run is in ROS domain"):
        refuse_claims_of_others(DOMAIN, TOPIC, "yours", {})
    claim.release()
    refuse_claims_of_others(DOMAIN, TOPIC, "yours", {})


def test_claim_ends_with_its_process_and_names_it() -> None:
    hold = f"""
import sys
from flexros_nodes.shell.claims import TopicClaim
claim = TopicClaim({DOMAIN}, "{TOPIC}", "", {{}})
print(flush=True)
sys.stdin.read()
"""
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    with subprocess.Popen(
        [sys.executable, "-c", hold], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
    ) as holder:
        assert holder.stdout is not None
        holder.stdout.readline()
        with pytest.raises(InputError, match=rf"process {holder.pid} publishes {TOPIC} there; end that run, or give"):
            TopicClaim(DOMAIN, TOPIC, "", {})
        holder.kill()
        holder.wait()
    TopicClaim(DOMAIN, TOPIC, "", {}).release()
