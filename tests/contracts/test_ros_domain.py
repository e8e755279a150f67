"""The fixture that keeps ROS 2 tests apart."""

from __future__ import annotations

import os
import socket

import pytest


def test_the_domain_is_set_for_the_test_and_its_children(ros_domain: int) -> None:
    assert os.environ["ROS_DOMAIN_ID"] == str(ros_domain)
    assert os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"


def test_a_claimed_domain_cannot_be_claimed_again(ros_domain: int) -> None:
    with socket.socket() as other, pytest.raises(OSError, match="in use"):
        other.bind(("127.0.0.1", 21_500 + ros_domain))
