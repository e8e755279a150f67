"""Node parameters as data."""

from __future__ import annotations

from pathlib import Path

import pytest

from flexros.errors import InputError
from flexros_nodes.bringup.run_plan import NODES
from flexros_nodes.protocol.parameters import ParameterSpecification, check_value, node_parameters, read_parameters

SPECIFICATIONS = {
    "timeout": ParameterSpecification(
        type="double", default=0.5, bounds=(0.1, 2.0), unit="s", description="Time to wait."
    ),
    "count": ParameterSpecification(type="int", default=1, bounds=(0, 5), unit="", description="How many."),
    "kind": ParameterSpecification(type="string", default="a", allowed=("a", "b"), unit="", description="Which."),
}


@pytest.mark.parametrize("node", NODES)
def test_shipped_parameters_are_valid_and_described(node: str) -> None:
    for name, specification in node_parameters(node).items():
        assert specification.description.endswith("."), name
        if specification.type in ("int", "double"):
            assert specification.bounds is not None, name


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        (
            "timeout",
            float("nan"),
            "parameter timeout of node plant is nan, allowed is a finite number from 0.1 to 2 s; Time",
        ),
        ("timeout", 3.0, "parameter timeout of node plant is 3 s, allowed is a number from 0.1 to 2 s"),
        ("timeout", "fast", "is 'fast', allowed is a number from 0.1 to 2 s"),
        ("count", 1.5, "is 1.5, allowed is a whole number from 0 to 5"),
        ("count", True, "is True, allowed is a whole number"),
        ("count", 6, "is 6, allowed is a number from 0 to 5"),
        ("kind", "c", "is 'c', allowed are a, b"),
    ],
)
def test_value_that_is_not_allowed_gives_one_sentence(name: str, value: object, sentence: str) -> None:
    with pytest.raises(InputError) as caught:
        check_value("plant", name, value, SPECIFICATIONS)
    assert sentence in str(caught.value)


def test_whole_number_becomes_a_double() -> None:
    value = check_value("plant", "timeout", 1, SPECIFICATIONS)
    assert isinstance(value, float)


def test_default_outside_its_bounds_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "node.yaml"
    file.write_text("speed: {type: double, default: 3.0, bounds: [0, 1], unit: m/s, description: Speed.}")
    with pytest.raises(InputError, match=r"parameter speed.*default is 3 m/s, allowed is a number from 0 to 1 m/s"):
        read_parameters(file)


def test_row_that_is_not_a_mapping_is_rejected(tmp_path: Path) -> None:
    file = tmp_path / "node.yaml"
    file.write_text("speed: 3")
    with pytest.raises(InputError, match="key speed: allowed is a mapping"):
        read_parameters(file)


def test_unknown_parameter_offers_the_nearest() -> None:
    with pytest.raises(
        InputError, match="unknown parameter of node plant 'resend_tmeout': did you mean 'resend_timeout'"
    ):
        check_value("plant", "resend_tmeout", 0.1, node_parameters("plant"))
