"""The fixture that keeps ROS 2 tests apart."""

from __future__ import annotations

import os

from flexros_nodes.shell.domain import claim_domain


def test_the_domain_is_set_for_the_test_and_its_children(ros_domain: int) -> None:
    assert os.environ["ROS_DOMAIN_ID"] == str(ros_domain)
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_a_claimed_domain_cannot_be_claimed_again(ros_domain: int) -> None:
    other, claim = claim_domain(ros_domain - 1)
    with claim:
        assert other != ros_domain
