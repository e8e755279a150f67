from __future__ import annotations

import pytest

from flexros.config.yaml_file import parse_yaml, read_rows, read_yaml
from flexros.errors import InputError


def file_of(tmp_path, text):
    path = tmp_path / "a.yaml"
    path.write_text(text)
    return path


def test_rows_are_given_by_name(tmp_path):
    assert read_rows(file_of(tmp_path, "a: {x: 1}\nb: {}\n")) == {"a": {"x": 1}, "b": {}}


@pytest.mark.parametrize(("text", "key"), [("a: 3\n", "a"), ("a:\n", "a"), ("a: {}\n7: {}\n", "7"), ("a: [1]\n", "a")])
def test_a_row_that_is_no_mapping_is_named(tmp_path, text, key):
    with pytest.raises(InputError, match=rf"a\.yaml, key {key}: allowed is a name with a mapping of keys; correct"):
        read_rows(file_of(tmp_path, text))


def test_numbers_follow_yaml_1_2(tmp_path):
    assert read_yaml(file_of(tmp_path, "a: 1e5\nb: 010\nc: on\n")) == {"a": 1e5, "b": 10, "c": "on"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: [1\n", r"a\.yaml, line \d: broken YAML"),
        ("a: 1\na: 2\n", r"a\.yaml, line 2: broken YAML, found duplicate key"),
        ("", "the file holds nothing, allowed is a mapping"),
        ("- 1\n", "the file holds a list, allowed is a mapping"),
    ],
)
def test_what_is_no_mapping_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_yaml(file_of(tmp_path, text))


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(InputError, match=r"cannot read .*a\.yaml: No such file or directory"):
        read_yaml(tmp_path / "a.yaml")


def bomb(levels: int) -> str:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, levels)]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (bomb(6), "it has more than the 200000 values that are allowed"),
        ("a: &a [*a]", "an alias refers to a node that contains it"),
        ("a: &a {b: [*a]}", "an alias refers to a node that contains it"),
        (f"a: {'[' * 60}{']' * 60}", "its values are nested 61 levels deep, allowed are 60"),
        ("!!float ", "broken YAML, string index out of range"),
    ],
)
def test_content_beyond_a_limit_is_refused(tmp_path, text, message):
    (tmp_path / "a.yaml").write_text(text)
    with pytest.raises(InputError, match=rf"a\.yaml: {message}"):
        read_yaml(tmp_path / "a.yaml")


def test_aliases_within_the_limits_are_read(tmp_path):
    (tmp_path / "a.yaml").write_text("a: &a {x: 1}\nb: [*a, *a]\nc: {<<: *a, y: 2}\n")
    assert read_yaml(tmp_path / "a.yaml") == {"a": {"x": 1}, "b": [{"x": 1}, {"x": 1}], "c": {"x": 1, "y": 2}}


def test_content_that_was_read_before_is_not_changed_by_its_users():
    text = "a: {b: [1, 2]}\n"
    parse_yaml(text, "x")["a"]["b"].append(3)
    assert parse_yaml(text, "x") == {"a": {"b": [1, 2]}}
