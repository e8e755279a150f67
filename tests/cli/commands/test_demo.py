"""The demonstration, in this process."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tests.cli.conftest import check_output

pytestmark = pytest.mark.slow

Flexros = Callable[..., "object"]


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> dict[tuple[str, str], float]:
    import contextlib
    import io

    from flexros.cli import main

    folder = tmp_path_factory.mktemp("demo") / "out"
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), pytest.raises(SystemExit) as ended:
        main(["demo", "--transport", "direct", "--no-repair", "--no-measured", "--json", "--out", str(folder)])
    assert not ended.value.code
    content = check_output(("demo",), printed.getvalue())
    assert (folder / "report.html").exists()
    return {(row["method"], row["case"]): 1e3 * row["this_run"] for row in content["path_error_max_m"]}


@pytest.mark.parametrize(("case", "published"), [("nominal", 0.32), ("load ±10 kg", 1.39), ("1 ms", 0.64)])
def test_dae_figures_are_those_of_the_thesis(rows: dict[tuple[str, str], float], case: str, published: float) -> None:
    assert rows["DAE, as published", case] == pytest.approx(published, rel=0.10)


def test_smooth_case(rows: dict[tuple[str, str], float]) -> None:
    assert rows["DAE, as published", "smooth motion"] == pytest.approx(0.21779, rel=1e-3)
    assert rows["DAE, second order", "smooth motion"] < 0.05


@pytest.mark.parametrize(
    ("method", "case", "reading"),
    [
        ("PD alone", "nominal", 9.30),
        ("flexible-joint", "nominal", 2.109),
        ("flexible-joint", "load ±10 kg", 2.181),
        ("DAE, as published", "nominal", 0.329),
        ("DAE, as published", "load ±10 kg", 1.415),
        ("DAE, as published", "1 ms", 0.661),
    ],
)
def test_agreement_with_an_independent_program(
    rows: dict[tuple[str, str], float], method: str, case: str, reading: float
) -> None:
    assert rows[method, case] == pytest.approx(reading, rel=0.01)


def test_existing_folder_is_kept(flexros: Flexros, tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("data")
    ended = flexros("demo", "--transport", "direct", "--out", str(tmp_path))
    assert ended.code == 2
    assert ended.err == f"flexros: the folder {tmp_path} exists already; give another one with --out\n"
    assert [path.name for path in tmp_path.iterdir()] == ["precious"]


def test_unknown_transport_is_refused_before_anything_is_made(flexros: Flexros, tmp_path: Path) -> None:
    ended = flexros("demo", "--transport", "nonsense", "--out", str(tmp_path / "out"))
    assert ended.code == 2
    assert "unknown transport 'nonsense' in --transport: allowed are direct, ros" in ended.err
    assert not (tmp_path / "out").exists()
