"""A proposed mapping as a file."""

from __future__ import annotations

from pathlib import Path

from flexros.logs.foreign.mapping import LogMapping, MappedColumn, Scale, load_mapping
from flexros.record.proposal.assumption import Assumption
from flexros.record.proposal.text import mapping_text


def test_file_is_the_mapping_with_its_assumptions(tmp_path: Path) -> None:
    columns = (
        MappedColumn(column="/s.position[a b]", quantity="position", joint="motor_1", sign=-1, unit="rad", period=25.0),
        MappedColumn(
            column="/s.effort[a b]",
            quantity="measured_torque",
            joint="motor_1",
            unit="A",
            scale=Scale(value=9.5, unit="Nm/A"),
        ),
    )
    mapping = LogMapping(name="log", description="Proposed: from a bag.", columns=columns)
    text = mapping_text(mapping, [Assumption("effort", "a current", "the weights say so", False)])
    (tmp_path / "log.yaml").write_text(text)
    assert load_mapping(str(tmp_path / "log.yaml")) == mapping
    assert "# effort: a current. The weights say so. NOT CHECKED." in text
