"""Tables with a row for each message of several topics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.logs.foreign.message_rows import message_rows
from flexros.record.proposal.propose import propose_mapping

MAPPING = """
name: messages
time: {column: stamp, unit: s}
columns:
  - {column: q, quantity: position, joint: motor_1, unit: rad}
  - {column: dq, quantity: velocity, joint: motor_1, unit: rad/s}
  - {column: tau, quantity: torque_command, joint: motor_1, unit: Nm, time: {column: t, unit: s}}
"""


def columns() -> dict[str, np.ndarray]:
    """Positions and torques of 100 Hz in turn, in rows of their own; only rows of positions have a stamp."""
    time = 0.005 * np.arange(1000)
    state = np.arange(1000) % 2 == 0
    values = {"stamp": time - 0.001, "q": np.sin(time), "dq": np.cos(time), "tau": 3 * time}
    rows = {name: np.where(state == (name != "tau"), own, np.nan) for name, own in values.items()}
    return {"t": time, **rows}


def written(folder: Path, table: dict[str, np.ndarray]) -> Path:
    """Write a table, empty where a value is NaN."""
    lines = [",".join("" if np.isnan(value) else f"{value:.9g}" for value in row) for row in zip(*table.values())]
    (folder / "run.csv").write_text("\n".join([",".join(table), *lines]) + "\n")
    return folder / "run.csv"


def test_each_column_has_the_rows_of_its_message(tmp_path: Path) -> None:
    (tmp_path / "map.yaml").write_text(MAPPING)
    table = columns()
    table["q"][10] = np.nan  # lost
    log = import_log(load_mapping(str(tmp_path / "map.yaml")), [written(tmp_path, table)])
    assert log.joint_commands is not None
    assert (len(log.joint_states.stamp), len(log.joint_commands.stamp)) == (500, 500)
    assert np.diff(log.joint_states.stamp) == pytest.approx(1e7)
    assert log.joint_commands.stamp[0] - log.joint_states.stamp[0] == pytest.approx(6e6)
    assert np.flatnonzero(np.isnan(log.joint_states.position[:, 0])).tolist() == [5]
    np.testing.assert_allclose(log.joint_states.velocity[:, 0], table["dq"][::2], rtol=1e-8)
    assert any("has a row for each message" in text for text in log.warnings)


def test_rows_of_others_come_between_also_where_no_column_of_theirs_is_read() -> None:
    q = np.concatenate([columns()["q"], np.full(300, np.nan)])
    np.testing.assert_array_equal(message_rows({"q": q})["q"], np.isfinite(q))


def test_a_mapping_is_proposed(tmp_path: Path) -> None:
    table = {name: values for name, values in columns().items() if name != "stamp"}
    found = propose_mapping(written(tmp_path, table), None)
    assert [one.quantity for one in found.mapping.columns] == ["position", "velocity", "measured_torque"]
    assert len(found.log.joint_states.stamp) == pytest.approx(500, abs=1)


def test_lost_values_and_slower_quantities_have_no_rows_of_their_own(tmp_path: Path) -> None:
    """A value that is empty while others of the same rows are there, is lost."""
    table = columns()
    q, slow = np.sin(table["t"]), np.where(np.arange(1000) % 4 == 0, 1.0, np.nan)
    assert message_rows({"q": q, "slow": slow}) == {}
    assert message_rows({"q": np.where(table["t"] < 2.0, q, np.nan)}) == {}
    (tmp_path / "map.yaml").write_text(MAPPING.replace("stamp", "t"))
    whole = table | {"q": q, "dq": np.cos(table["t"])}
    with pytest.raises(InputError, match="a quantity of a lower rate needs a file of its own"):
        import_log(load_mapping(str(tmp_path / "map.yaml")), [written(tmp_path, whole)])
