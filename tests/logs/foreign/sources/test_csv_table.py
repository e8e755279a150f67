"""Tables as text."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.sources.csv_table import CsvTable


def table(tmp_path: Path, text: str) -> CsvTable:
    file = tmp_path / "log.csv"
    file.write_text(text, encoding="utf-8")
    return CsvTable(file)


@pytest.mark.parametrize(
    "text",
    [
        "t,q\n0,1.5\n1,-2e-3\n",
        "t;q\r\n0;1.5\r\n1;-2e-3\r\n",
        "t\tq\n0\t1.5\n\n1\t-2e-3\n",
        "t q\n0 1.5\n1   -2e-3\n",
        "# made by a drive\n# t,q\n0,1.5\n1,-2e-3\n",
        '\ufeff"t","q"\n"0","1.5"\n# pause\n"1","-2e-3"\n',
    ],
)
def test_forms_of_a_table(tmp_path: Path, text: str) -> None:
    opened = table(tmp_path, text)
    assert opened.names == ("t", "q")
    np.testing.assert_array_equal(opened.read(["q"])["q"].values, [1.5, -2e-3])
    assert opened.read(["q"])["q"].time is None


def test_columns_that_are_not_asked_for_may_be_text(tmp_path: Path) -> None:
    signals = table(tmp_path, "t,state,q\n0,idle,1\n1,moving,2\n").read(["q", "t"])
    np.testing.assert_array_equal(signals["q"].values, [1, 2])
    np.testing.assert_array_equal(signals["t"].values, [0, 1])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,q\n0,1\n1,x\n", "line 3: column 'q' is 'x', which is not a number"),
        ("t;q\n0;1,5\n", "line 2: column 'q' is '1,5', which is not a number"),
        ("t,q\n0,1\n\n1\n", "line 4: column 'q' is missing"),
    ],
)
def test_entry_that_is_no_number(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        table(tmp_path, text).read(["t", "q"])
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("0,a\n1,2\n", "line 1: the first line holds '0' at column 1, but must name the columns"),
        (
            "timestep,q,0.5\n1,2,3\n",
            "holds '0.5' at column 3, but must name the columns; add such a line, or name that",
        ),
        ("t,q,q\n0,1,2\n", "line 1: the column name 'q' occurs twice"),
        ("# only a comment\n", "has no rows; give a table with a line of names"),
    ],
)
def test_line_of_names(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError) as caught:
        table(tmp_path, text)
    assert message in str(caught.value)


def test_no_text(tmp_path: Path) -> None:
    file = tmp_path / "log.csv"
    file.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="byte 0 is not UTF-8"):
        CsvTable(file)


@pytest.mark.filterwarnings("error")
def test_line_of_names_alone(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"log.csv has no rows below its line of names \(t, q\); give a table with rows"
    ):
        table(tmp_path, "t,q\n").read(["q"])


def test_columns_of_a_table_without_names_are_numbered(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("# recorded on a Monday\n0.0,1.5,2\n0.1,2.5,3\n")
    source = CsvTable(tmp_path / "a.csv")
    assert source.names == ("[0]", "[1]", "[2]")
    np.testing.assert_array_equal(source.read(["[1]"])["[1]"].values, [1.5, 2.5])


@pytest.mark.parametrize(
    "text",
    [
        't,q,u\n0,"[0.1, 0.2]",5\n1,"[0.3, 0.4]",6\n',
        "t,q,u\n0,[0.1, 0.2],5\n1,[0.3, 0.4],6\n",
        "t;q;u\n0;(0.1 0.2);5\n1;(0.3  0.4);6\n",
        "t q u\n0 [0.1,0.2] 5\n1 [0.3,0.4] 6\n",
    ],
)
def test_entries_of_lists_in_cells_are_columns(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.csv").write_text(text)
    source = CsvTable(tmp_path / "a.csv")
    assert source.names == ("t", "q[0]", "q[1]", "u")
    read = source.read(["q[1]", "u"])
    np.testing.assert_array_equal(read["q[1]"].values, [0.2, 0.4])
    np.testing.assert_array_equal(read["u"].values, [5, 6])


def test_list_of_another_length_is_refused_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text('t,q\n0,"[0.1, 0.2]"\n1,"[0.3]"\n')
    with pytest.raises(InputError, match="line 3 has 2 numbers"):
        CsvTable(tmp_path / "a.csv").read(["t", "q[0]"])


def test_brackets_in_names_are_names(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,q[0],q[1]\n0,1,2\n1,3,4\n")
    assert CsvTable(tmp_path / "a.csv").names == ("t", "q[0]", "q[1]")


@pytest.mark.parametrize(
    ("text", "column", "values"),
    [
        ("t,q,u\n0,,1\n1,2,\n", "q", [np.nan, 2]),
        ("t,q,u\n0,,1\n1,2,\n", "u", [1, np.nan]),
        ("t;q\n0; \n1;NaN\n2;3\n", "q", [np.nan, np.nan, 3]),
        ("0,,1\n1,2,3\n", "[1]", [np.nan, 2]),
        ('t,q,u\n0,"[1, 2]",5\n1,,6\n', "q[1]", [2, np.nan]),
        ('t,q,u\n0,"[1, 2]",5\n1,,6\n', "u", [5, 6]),
    ],
)
def test_an_empty_cell_is_a_value_that_is_not_known(tmp_path: Path, text: str, column: str, values: list) -> None:
    np.testing.assert_array_equal(table(tmp_path, text).read([column])[column].values, values)
