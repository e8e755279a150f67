"""The patch as a file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from flexros.config.settings import validate
from flexros.config.yaml_file import read_yaml
from flexros.effects.patching.patch import Patch, name_from, numbered
from flexros.errors import InputError


def patch(**changes: Any) -> Patch:
    given = {
        "robot": "e12",
        "robot_hash": "0123456789abcdef",
        "source": "diagnosis of bags/x: explained",
        "effects": [
            {
                "effect": "coulomb_friction",
                "location": "motor_1",
                "parameters": {"level": {"value": 25.125, "std": 0.25, "unit": "Nm"}, "asymmetry": 0.1},
            },
            {"effect": "torque_ripple", "location": "motor_2", "parameters": {"amplitude": 2, "proportional": False}},
        ],
        "covariance": {"names": ["coulomb_friction@motor_1.level"], "matrix": [[0.0625]]},
        **changes,
    }
    return validate(Patch, given, "patch.yaml")


def test_text_read_back_is_the_same_patch(tmp_path: Path) -> None:
    file = tmp_path / "patch.yaml"
    file.write_text(patch().text(), encoding="utf-8")
    assert validate(Patch, read_yaml(file), "patch.yaml") == patch()
    assert "      level: {value: 25.125, std: 0.25, unit: Nm}\n" in file.read_text()


def test_effects_have_the_given_values_and_their_own_defaults() -> None:
    friction, ripple = patch().placed("patch.yaml")
    assert str(friction) == "coulomb_friction@motor_1:level=25.125,asymmetry=0.1"
    assert ripple.location == "motor_2"
    overtone = {"second_sine": 0.0, "second_cosine": 0.0}
    assert ripple.effect.model_dump() == {
        "amplitude": 2.0,
        "order": 1.0,
        "phase": 0.0,
        "proportional": False,
        **overtone,
    }


@pytest.mark.parametrize(
    ("effect", "message"),
    [
        (
            {"effect": "coulom_friction", "location": "motor_1", "parameters": {"level": 1}},
            r"unknown effect 'coulom_friction' in patch\.yaml, key effects\[0\]: did you mean 'coulomb_friction'\?",
        ),
        (
            {"effect": "coulomb_friction", "location": "motor_1", "parameters": {"levle": 1}},
            r"patch\.yaml, key effects\[0\] \(coulomb_friction@motor_1\): unknown key 'levle': did you mean 'level'\?",
        ),
        (
            {"effect": "stribeck_friction", "location": "motor_1", "parameters": {"extra": -1}},
            r"patch\.yaml, key effects\[0\] \(stribeck_friction@motor_1\).*extra.*-1",
        ),
    ],
)
def test_wrong_effect_is_named_with_file_and_key(effect: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        patch(effects=[effect], covariance=None).placed("patch.yaml")
    assert "\n" not in str(caught.value)


NAMES = ["coulomb_friction@motor_1.level", "coulomb_friction@motor_1.asymmetry"]


@pytest.mark.parametrize(
    ("covariance", "message"),
    [
        ({"names": NAMES, "matrix": [[1, 2], [2, 1]]}, r"not positive semidefinite .* eigenvalue -1\)"),
        ({"names": NAMES, "matrix": [[1, 0], [0, -2]]}, r"variance -2 in row 1, but variances must be above zero"),
        ({"names": NAMES, "matrix": [[1, 0.5], [0.2, 1]]}, r"is not symmetric"),
        ({"names": NAMES, "matrix": [[1, 0]]}, r"has 1 rows of lengths \[2\], but must be square"),
        ({"names": NAMES[:1], "matrix": [[1, 0], [0, 1]]}, r"has 1 names for 2 rows; name each row"),
        (
            {"names": ["coulomb_friction@motor_2.level"], "matrix": [[1]]},
            r"holds 'coulomb_friction@motor_2\.level', but the effects of the patch have coulomb_friction@motor_1\.asy",
        ),
    ],
)
def test_impossible_covariance_is_refused(covariance: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=r"patch\.yaml.*" + message) as caught:
        patch(covariance=covariance)
    assert "\n" not in str(caught.value)


def test_effect_without_parameters_is_refused() -> None:
    with pytest.raises(InputError, match=r"patch\.yaml.*effects\[0\]\.parameters.*at least 1 item"):
        patch(effects=[{"effect": "coulomb_friction", "location": "motor_1", "parameters": {}}], covariance=None)


def test_equal_names_are_numbered() -> None:
    assert numbered(["a", "b", "a", "a"]) == ("a", "b", "a#2", "a#3")


def test_path_of_a_robot_file_is_written_relative_to_the_patch(tmp_path: Path) -> None:
    assert name_from("e12", tmp_path) == "e12"
    assert name_from(str(tmp_path / "robots" / "mine.yaml"), tmp_path / "out") == "../robots/mine.yaml"
