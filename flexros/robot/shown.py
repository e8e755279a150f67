"""A robot and its linear model for people: modes, parameters, tables and pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from flexros.report.base import Paragraph, TextTable
from flexros.report.notebook import notebook_html
from flexros.report.number_text import number

if TYPE_CHECKING:
    import pandas as pd

    from flexros.arrays import FloatArray
    from flexros.report.base import Block
    from flexros.robot.linear.linearise import LinearModel
    from flexros.robot.robot import Robot

_AT_REST = 1e-3
"""Poles below this absolute value count as rigid-body motion [1/s] (chosen)."""


def modes(linear: LinearModel) -> FloatArray:
    """Return natural frequency and damping ratio of each oscillating pair of poles.

    Args:
        linear: The linear model.

    Returns:
        Natural frequency |p| / (2 pi) [Hz] and damping ratio -Re p / |p| [1], by frequency, shape (n_modes, 2).
    """
    from flexros.robot.linear.zeros import poles

    found = poles(linear)
    pairs = found[(found.imag > 1e-6 * abs(found)) & (abs(found) > _AT_REST)]
    table = np.column_stack([abs(pairs) / (2 * np.pi), -pairs.real / abs(pairs)])
    return np.asarray(table[np.argsort(table[:, 0])], dtype=float)


def modes_frame(linear: LinearModel) -> pd.DataFrame:
    """Return the modes as a table with the columns frequency_hz and damping_ratio, numbered from 1."""
    import pandas as pd

    frame = pd.DataFrame(modes(linear), columns=["frequency_hz", "damping_ratio"])
    frame.index = pd.RangeIndex(1, len(frame) + 1, name="mode")
    return frame


def parameters_frame(robot: Robot) -> pd.DataFrame:
    """Return the parameters of a robot as a table by name: value [unit], unit, tolerance [1], source."""
    import pandas as pd

    entries = robot.parameters.values()
    columns = ("value", "unit", "tolerance", "source")
    return pd.DataFrame(
        {column: [getattr(entry, column) for entry in entries] for column in columns},
        index=pd.Index([entry.name for entry in entries], name="parameter"),
    )


def linear_html(linear: LinearModel) -> str:
    """Show inputs, outputs and modes of a linear model in a notebook."""
    names = ", ".join(linear.output_names)
    text = f"Torques of {', '.join(linear.input_names)} to motor positions and {names}; {2 * len(linear.mass)} states."
    return notebook_html("Linear model at rest", (Paragraph(text), _modes_table(linear)))


def robot_html(robot: Robot) -> str:
    """Show degrees of freedom, motors and modes of a robot in a notebook."""
    from flexros.errors import InputError
    from flexros.robot.linear.linearise import linear_model

    motors = tuple(
        (
            motor.name,
            "flexible" if motor.flexible else "rigid",
            number(motor.gear_ratio),
            number(motor.torque_limit),
            motor.torque_unit,
        )
        for motor in robot.motors
    )
    text = (
        f"{robot.n_arm} arm coordinates, {robot.n_motors} motor{'s' * (robot.n_motors != 1)}, "
        f"{robot.n_coordinates} degrees of freedom, sample time {1e3 * robot.sample_time:g} ms. "
        f"{robot.spec.description}"
    )
    header = ("Motor", "gear", "ratio", "torque limit", "unit")
    blocks: list[Block] = [Paragraph(text), TextTable(header, motors, "", left=2)]
    try:
        blocks.append(_modes_table(linear_model(robot)))
    except InputError as error:  # no equilibrium at home
        blocks.append(Paragraph(f"No modes at the home pose: {error}", "warning"))
    return notebook_html(f"Robot {robot.name}", blocks)


def _modes_table(linear: LinearModel) -> TextTable:
    rows = tuple(
        (str(index), number(frequency), number(damping, 3))
        for index, (frequency, damping) in enumerate(modes(linear), 1)
    )
    return TextTable(("Mode", "frequency [Hz]", "damping ratio"), rows, f"{len(rows)} modes at this pose.")
