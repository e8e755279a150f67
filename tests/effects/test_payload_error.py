"""Error of the load."""

from __future__ import annotations

import pytest

from flexros.effects import parse_effect
from flexros.effects.payload_error import PayloadError
from flexros.errors import InputError
from flexros.robot import load_robot
from tests.ur5e import ur5e


def test_there_is_no_load_to_be_wrong_where_the_last_body_is_a_frame() -> None:
    """A URDF often ends in a frame for the tool: scaled, its mass of zero would stay zero without a word."""
    assert PayloadError().locations(load_robot("elbow")) == ("tool",)
    assert PayloadError().locations(ur5e()) == ()
    with pytest.raises(InputError, match="location of payload_error on robot ur5e 'tool': there is none"):
        parse_effect("payload_error@tool:relative=0.5", "test").check_location(ur5e())
