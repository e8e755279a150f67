"""Linear loops of any control law about rest, with all sensors that it uses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from flexros.control.context import LINK_MOTION
from flexros.control.design.margins import loop_margins
from flexros.control.linear_controller import linear_controller
from flexros.errors import InputError
from flexros.simulate.plant_model import PlantModel
from flexros.simulate.sensor_timing import SensorTiming

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.control.base import AbstractControlLaw
    from flexros.control.context import LoopContext
    from flexros.control.design.margins import LoopMargins
    from flexros.control.design.methods.base import DesignProblem
    from flexros.control.design.plants import SampledPlants
    from flexros.control.linear_controller import LinearController


@dataclass(frozen=True, eq=False)
class ControlLoop:
    """A linear controller with the plants for which it is the same.

    Attributes:
        plants: Sampled plants; measurements are those that the controller uses, after the motor positions.
        controller: The controller about rest.
    """

    plants: SampledPlants
    controller: LinearController

    @cached_property
    def margins(self) -> tuple[LoopMargins, ...]:
        """Margins of every plant and motor, the other loops closed."""
        return loop_margins(self.plants, self.controller)


def control_loops(law: AbstractControlLaw, problem: DesignProblem) -> tuple[ControlLoop, ...]:
    """Linearise a control law and its robot about rest in every pose.

    A sensor with a delay is late by it; one with a lower rate than the loop by the largest age of its held value too,
    which is on the safe side.

    Args:
        law: The law.
        problem: The robot over its spring range and poses.

    Returns:
        One loop with all poses for a law that is the same in all, as linear ones are, else one loop per pose.

    Raises:
        InputError: The law does not fit the robot, or uses a sensor that shows the torques of the motors at once.
    """
    context = law.context(problem.robot, problem.sample_time)
    law.check(context)
    sensors = _FurtherSensors(context)
    whole = [linear_controller(law, context, sensors.rest(pose)) for pose in problem.poses]
    channels = sensors.used_by(whole)
    columns = [*range(context.n_motors), *(context.n_motors + channel for channel in channels)]
    controllers = [
        replace(one, from_measured=one.from_measured[:, columns], state_measured=one.state_measured[:, columns])
        for one in whole
    ]
    plants = sensors.plants(problem, channels) if channels else problem.sampled
    if all(_same(controllers[0], other) for other in controllers[1:]):
        return (ControlLoop(plants, controllers[0]),)
    each = len(plants) // len(controllers)
    return tuple(
        ControlLoop(plants.part(each * place, each * (place + 1)), controller)
        for place, controller in enumerate(controllers)
    )


def rest_signals(context: LoopContext, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return references and measurements of the robot at rest.

    Args:
        context: Robot and signals of the loop.
        pose: Arm coordinates [rad or m], shape (N,).

    Returns:
        References, shape (context.references.size,), and measurements, shape (context.measurements.size,).
    """
    return _FurtherSensors(context).rest(pose)


class _FurtherSensors:
    """The sensors of a robot beside its motor encoders, one channel after the other."""

    def __init__(self, context: LoopContext) -> None:
        self._context, self._robot = context, context.robot
        self._sensors = context.robot.further_sensors

    @cached_property
    def _values(self) -> ca.Function:
        """Values of all channels from (x, p); x ends with torques and wrench that act, where a sensor feels them."""
        return PlantModel(self._robot, sensors=self._sensors).further

    def rest(self, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return references and measurements at rest; see `rest_signals`."""
        robot, context = self._robot, self._context
        state = robot.equilibrium(np.asarray(pose, dtype=float))
        torque = np.asarray(robot.holding_torque(state), dtype=float)
        motors = np.asarray(robot.model.encoder(state[: robot.n_coordinates]), dtype=float).ravel()
        reference = {name: np.zeros(size) for name, size in context.references.sizes.items()}
        reference |= {"motor_position": motors, "feedforward_torque": torque}
        if context.link_motion:
            reference[LINK_MOTION[0]] = state[list(robot.gear_rows)]
        measured = [motors]
        if self._sensors:
            held = np.zeros(self._values.numel_in(0) - len(state))
            held[: len(torque)] = torque[: len(held)]
            measured.append(np.asarray(self._values(np.concatenate([state, held]), []), dtype=float).ravel())
        return context.references.stack(reference), np.concatenate(measured)

    def used_by(self, controllers: Sequence[LinearController]) -> list[int]:
        """Return the numbers of the channels that controllers use."""
        whole = np.vstack([part for one in controllers for part in (one.from_measured, one.state_measured)])
        return [int(channel) for channel in np.flatnonzero(np.any(whole[:, self._robot.n_motors :], axis=0))]

    def plants(self, problem: DesignProblem, channels: Sequence[int]) -> SampledPlants:
        """Return the sampled plants with channels as further measurements, at the age at which they are used.

        Raises:
            InputError: A channel shows the torques of the motors at once.
        """
        names = [sensor.measurement for sensor in self._sensors for _ in sensor.indices]
        x, p = self._values.sx_in()
        values = self._values(x, p)[list(channels)]
        torques = ca.vertsplit(x)[2 * self._robot.n_coordinates :][: self._robot.n_motors]
        if ca.jacobian(values, ca.vertcat(ca.SX(0, 1), *torques)).nnz():
            shown = ", ".join(sorted({names[channel] for channel in channels}))
            raise InputError(
                f"the linear loop is not known, because a sensor that the controller uses ({shown}) shows the torques "
                f"of rigid motors of robot {self._robot.name} at once; choose a controller or robot without it"
            )
        timing = SensorTiming.of(self._sensors, problem.sample_time)
        ages = [timing.delay[channel] + timing.period[channel] - 1 for channel in channels]
        chosen = ca.Function("further", [x, p], [ca.densify(values)])
        return problem.sampled_with(chosen).measured_late([0] * self._robot.n_motors + ages)


def _same(one: LinearController, other: LinearController) -> bool:
    parts = ("from_state", "from_measured", "state_step", "state_measured", "from_reference", "state_reference")
    return all(np.allclose(getattr(one, part), getattr(other, part), rtol=1e-9, atol=1e-12) for part in parts)
