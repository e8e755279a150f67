"""Parts of a campaign are kept in files and never computed twice."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest
from distributed import Client

from flexros.errors import InputError
from flexros.scheduler import connected
from flexros.validation.campaigns import parts as parts_module
from flexros.validation.campaigns.parts import claim_folder, finished_parts, versions_of


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with connected(threads=2) as made:
        yield made


def square(number: int) -> dict[str, Any]:
    return {"square": number**2}


def refuse(number: int) -> dict[str, Any]:
    raise InputError(f"{number} is refused")


def test_parts_come_in_the_order_of_the_jobs(client: Client, tmp_path: Path) -> None:
    told: list[int] = []
    parts = finished_parts(tmp_path, client, {f"part_{k}": (k,) for k in range(4)}, square, told.append)
    assert [part["square"] for part in parts.values()] == [k**2 for k in range(4)]
    assert list(parts) == [f"part_{k}" for k in range(4)]
    assert told == [0, 1, 2, 3, 4]


@pytest.mark.parametrize("content", ["", "{", "[1]", "\xff"])
def test_damaged_part_is_refused(client: Client, tmp_path: Path, content: str) -> None:
    (tmp_path / "a.json").write_text(content, encoding="latin-1")
    with pytest.raises(InputError, match=r"a\.json (is not|holds no)"):
        finished_parts(tmp_path, client, {"a": (2,)}, square, lambda done: None)


def test_finished_parts_are_not_computed_again(client: Client, tmp_path: Path) -> None:
    finished_parts(tmp_path, client, {"a": (2,)}, square, lambda done: None)
    told: list[int] = []
    again = finished_parts(tmp_path, client, {"a": (2,)}, refuse, told.append)
    assert again["a"]["square"] == 4
    assert told == [1]


def test_versions_of_the_code_are_those_of_all_parts(
    client: Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    jobs = {f"part_{k}": (k,) for k in range(3)}
    for code, number in (("abc", 2), ("def", 3)):
        monkeypatch.setattr(parts_module, "code_version", lambda code=code: code)
        parts = finished_parts(tmp_path, client, dict(list(jobs.items())[:number]), square, lambda done: None)
    assert versions_of(parts.values())["commit"] == "abc (2 parts), def (1 parts)"
    assert versions_of([{}])["commit"] == "unknown (1 parts)"


def test_error_in_a_part_reaches_the_caller_and_keeps_the_others(client: Client, tmp_path: Path) -> None:
    finished_parts(tmp_path, client, {"a": (2,)}, square, lambda done: None)
    with pytest.raises(InputError, match="3 is refused"):
        finished_parts(tmp_path, client, {"a": (2,), "b": (3,)}, refuse, lambda done: None)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.json"]


class Counted:
    """Counts how often it is sent."""

    sent: ClassVar[list[int]] = []

    def __reduce__(self) -> tuple[Any, ...]:
        self.sent.append(1)
        return Counted, ()


def kind(shared: Counted, number: int) -> dict[str, Any]:
    return {"kind": type(shared).__name__, "number": number}


def test_what_parts_share_is_not_sent_with_every_part(client: Client, tmp_path: Path) -> None:
    jobs = {f"part_{k}": (k,) for k in range(6)}
    parts = finished_parts(tmp_path, client, jobs, kind, lambda done: None, shared=(Counted(),))
    assert [(parts[name]["kind"], parts[name]["number"]) for name in jobs] == [("Counted", k) for k in range(6)]
    assert len(Counted.sent) <= 1


def test_folder_of_other_settings_is_refused(tmp_path: Path) -> None:
    claim_folder(tmp_path, {"positions": 15, "scenario": "one"})
    claim_folder(tmp_path, {"positions": 15, "scenario": "one"})
    with pytest.raises(InputError, match="holds parts with positions 15, but now it is 3; give another folder"):
        claim_folder(tmp_path, {"positions": 3, "scenario": "one"})
