"""Errors of the tool over the position of a motor: kinematic errors, payload, modes of the tool."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from flexros.gap.signatures.base import AbstractSignature, Curve, Picture, thinned

if TYPE_CHECKING:
    from flexros.gap.signatures.signature_data import SignatureData


class ToolError(AbstractSignature):
    """Measured minus predicted tool position over the position of the motor that moves it."""

    name: ClassVar[str] = "tool_error"

    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Show the three components; None where the tool was not measured."""
        tool, error = data.record.tool, data.tool_error
        if tool is None or error is None or not len(error):
            return None
        motor = data.motor_of(location)
        _, unit = data.units(motor)
        time = np.arange(data.record.n_samples) * data.record.sample_time
        position = np.interp(tool.time, time, data.record.position[:, motor])
        order = np.argsort(position, kind="stable")
        series = {
            axis: Curve(*thinned(position[order], 1e3 * error[order, column], 600), style="points")
            for column, axis in enumerate("xyz")
        }
        return Picture(
            title=f"Error of the tool over the position of {data.robot.joint_names[motor]}",
            x_label=f"position of the motor [{unit}]",
            y_label="measured minus predicted position of the tool [mm]",
            series=series,
            reading="A curve that depends on the position alone is an error of lengths or angles; scatter is motion "
            "that the model does not predict.",
        )
