"""A scenario prepared to run: robots, reference, controller, initial state."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.control.context import LINK_MOTION
from flexros.control.controller import Controller
from flexros.errors import InputError, source_named
from flexros.feedforward.compensation.encoder_reading import position_of_reading
from flexros.feedforward.compensation.uncompensated import uncompensated
from flexros.feedforward.problem import rigid_kinematics
from flexros.feedforward.reference import compute_reference, pre_actuation
from flexros.feedforward.tool_geometry import ToolGeometry
from flexros.identify.experiment.limits import check_limits
from flexros.identify.experiment.reference import identification_reference, moves_of
from flexros.provenance import versions
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.models import ScenarioModels
from flexros.scenario.motion import planned_trajectory
from flexros.simulate.plant import Plant
from flexros.simulate.plant_model import PlantModel
from flexros.simulate.sensor_timing import SensorTiming
from flexros.simulate.signals import plant_signals
from flexros.trajectory import Trajectory, check_reachable, is_reachable

if TYPE_CHECKING:
    import casadi as ca

    from flexros.arrays import FloatArray
    from flexros.control.context import LoopContext
    from flexros.effects import PlacedLaw
    from flexros.feedforward.motion import Reference
    from flexros.identify.experiment.plan import ExperimentPlan
    from flexros.robot import Robot
    from flexros.scenario.scenario import Scenario
    from flexros.simulate.signals import PlantSignals

MOST_BYTES = 4_000_000_000
"""Largest memory for the signals of a run [bytes]; beyond, a mistake in the duration is assumed (chosen)."""


@dataclass(frozen=True, eq=False)
class Experiment:
    """A scenario prepared to run; everything costly is computed on first access.

    Attributes:
        scenario: The scenario.
        models: The nominal robot, that of the feedforward, and the simulated one.
        sample_time: Time between two samples [s].
        trajectory: Desired motion; a hold if the scenario has none, the moves alone for an identification.
        n_samples: Number of samples, the first at 0 and the last at or just before the end.
        plan: Plan of the identification experiment; None for other scenarios.
        pre_actuation: Time for which the motors move before the tool [s]; 0 without stable inversion. The trajectory
            rests at least so long at its start.
        given_reference: Reference in place of the computed one, which starts alike.
    """

    scenario: Scenario
    models: ScenarioModels
    sample_time: float
    trajectory: Trajectory
    n_samples: int
    plan: ExperimentPlan | None = None
    pre_actuation: float = 0.0
    given_reference: Reference | None = None

    @classmethod
    def prepare(cls, scenario: Scenario) -> Experiment:
        """Load the robots and plan the motion.

        Raises:
            InputError: Invalid robot, values, start or trajectory; names scenario and key.
        """
        source = f"scenario {scenario.name}"
        models = ScenarioModels.of(scenario)
        nominal = models.nominal.robot
        sample_time = nominal.sample_time if scenario.sample_time is None else scenario.sample_time
        law = scenario.controller
        if law.follows_link_motion and scenario.identification is not None:
            raise InputError(
                f"{source}: controller {law.kind} follows the motion of the links, which an identification does not "
                "plan; choose a controller of the motor positions, such as pid"
            )
        plan = None if scenario.identification is None else plan_of_scenario(scenario)
        trajectory = planned_trajectory(scenario, models, source, sample_time) if plan is None else moves_of(plan)
        lead = 0.0 if plan is not None else _pre_actuation(scenario, models, trajectory, sample_time)
        if lead > trajectory.rest_before:
            trajectory = trajectory.delayed(lead - trajectory.rest_before)
        duration = trajectory.duration if scenario.duration is None else scenario.duration
        n_samples = int(np.floor(duration / sample_time + 1e-6)) + 1 if plan is None else plan.n_samples
        needed = n_samples * bytes_per_sample(
            nominal, trajectory.n_out, planned=plan is not None, link_motion=law.follows_link_motion
        )
        if needed > MOST_BYTES:
            raise InputError(
                f"{source}: {(n_samples - 1) * sample_time:g} s at a sample time of {sample_time:g} s are {n_samples} "
                f"samples, which need some {needed / 1e9:.2g} GB of memory with robot {nominal.name}, allowed are "
                f"{MOST_BYTES / 1e9:g} GB; shorten the duration or raise the sample time"
            )
        experiment = cls(scenario, models, sample_time, trajectory, n_samples, plan, lead)
        with source_named(source):  # cheap checks come before costly computations
            scenario.controller.check(experiment.loop_context)
            _ = experiment.gains, experiment.signals(scenario.seed), experiment.sensor_timing
        return experiment

    @property
    def nominal(self) -> Robot:
        """The nominal robot, without the laws of a patch."""
        return self.models.nominal.robot

    @property
    def plant(self) -> Robot:
        """The simulated robot, without the laws of its effects."""
        return self.models.plant.robot

    @property
    def laws(self) -> tuple[PlacedLaw, ...]:
        """Laws of effects on the plant."""
        return self.models.plant.laws

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return (self.n_samples - 1) * self.sample_time

    @cached_property
    def start(self) -> FloatArray:
        """Approximate initial arm coordinates [rad or m], shape (N,)."""
        return self.nominal.home if self.scenario.start is None else np.array(self.scenario.start, dtype=float)

    @cached_property
    def reference(self) -> Reference:
        """References and feedforward torques of all samples; the torques are zero without `feedforward_torque`.

        Raises:
            InputError: The path is out of reach, or the nominal robot would exceed a limit of an identification.
        """
        if self.given_reference is not None:
            return self.given_reference
        with source_named(f"scenario {self.scenario.name}"):
            if self.plan is None:
                _check_reachable(self.trajectory, self.nominal, self.start)
                return self._reference(self.duration)
            known = self.models.known
            reference = identification_reference(
                self.plan, known.robot, self.scenario.feedforward, self.start, known.laws
            )
            check_limits(self.plan, self.nominal, self.scenario.controller, reference)
            return self._with_torque(reference)

    @cached_property
    def reference_signal(self) -> FloatArray:
        """References of the controller in the order of `loop_context.references`, shape (n, 3 M or 8 M)."""
        reference = self.reference
        links = {
            name: reference.link_motion[:, order]
            for order, name in enumerate(LINK_MOTION)
            if self.loop_context.link_motion
        }
        return self.loop_context.references.stack(
            {
                "motor_position": reference.motor_position,
                "motor_velocity": reference.motor_velocity,
                "feedforward_torque": reference.torque,
                **links,
            }
        )

    @cached_property
    def start_motor_position(self) -> FloatArray:
        """First reference of the motors [rad or m], shape (M,)."""
        position: FloatArray = self._reference(0.0).motor_position[0]
        return position

    @cached_property
    def start_state(self) -> FloatArray:
        """Initial state of the plant: at rest, with the encoders at their first reference."""
        held = position_of_reading(self.plant, self.laws, self.start_motor_position)
        state = self.plant.equilibrium(self.start, motor_position=held)
        return self.plant_model.rest(state).state if self.plant_model.moves_rest else state

    @cached_property
    def start_torque(self) -> FloatArray:
        """Command that holds the plant at its start [Nm or N], shape (M,); it fills the delay line."""
        model, state = self.plant_model, self.start_state
        torque = model.rest(state).torque if model.moves_rest else self.plant.holding_torque(state)
        return model.command_at_rest(state, torque, np.zeros(0))

    @cached_property
    def plant_model(self) -> PlantModel:
        """The plant with the laws of its effects."""
        return PlantModel(self.plant, self.laws, sensors=self.plant.further_sensors)

    @cached_property
    def loop_context(self) -> LoopContext:
        """Context of the control law: the nominal robot, not the simulated one."""
        return self.scenario.controller.context(self.nominal, self.sample_time)

    @cached_property
    def gains(self) -> FloatArray:
        """Gains of the controller, shape (n_gains,)."""
        return self.scenario.controller.gains(self.loop_context)

    @cached_property
    def sensor_timing(self) -> SensorTiming:
        """Delay and rate of the further sensors in samples."""
        return SensorTiming.of(self.plant.further_sensors, self.sample_time)

    @cached_property
    def control_function(self) -> ca.Function:
        """Update `(c, r, y, g) -> (u, c_next)` of the controller, behind delay and hold of further sensors."""
        return self.sensor_timing.behind(self.scenario.controller.function(self.loop_context), self.nominal.n_motors)

    @cached_property
    def control_state(self) -> FloatArray:
        """Initial state of `control_function`."""
        state = self.scenario.controller.initial_state(self.loop_context)
        return np.concatenate([state, np.zeros(self.sensor_timing.memory_size)])

    def controller(self) -> Controller:
        """Build the controller in its initial state."""
        return Controller(self.scenario.controller, self.loop_context)

    def signals(self, seed: int) -> PlantSignals:
        """Generate sensor noise and disturbances of a seed."""
        scenario = self.scenario
        return plant_signals(
            self.plant, self.sample_time, seed, noise=scenario.noise, disturbances=scenario.disturbances
        )

    def plant_in_time(self) -> Plant:
        """Build the simulated robot at its start, to be stepped sample by sample."""
        return Plant(
            self.plant,
            self.sample_time,
            self.start_state,
            seed=self.scenario.seed,
            noise=self.scenario.noise,
            disturbances=self.scenario.disturbances,
            substeps=self.scenario.substeps,
            torque=self.start_torque,
            laws=self.laws,
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """What the feedforward does otherwise than asked: stable inversion, effects it cannot compensate."""
        known, settings = self.models.known, self.scenario.feedforward
        notes = uncompensated(known.robot, known.laws, settings)
        if self.pre_actuation and settings.method == "dae":
            notes += (
                f"the path is non-minimum phase for robot {known.robot.name}, so the dae feedforward uses stable "
                f"inversion: the motors move {self.pre_actuation:.4g} s before the tool "
                "(feedforward.non_minimum_phase)",
            )
        return notes

    def provenance(self) -> dict[str, Any]:
        """Return the provenance of the run for the log's side-car: scenario, hashes, versions."""
        return {
            "scenario": self.scenario.model_dump(mode="json"),
            "scenario_hash": self.scenario.digest(),
            "seed": self.scenario.seed,
            "sample_time": self.sample_time,
            "n_samples": self.n_samples,
            **self.models.provenance(),
            **({"warnings": list(self.warnings)} if self.warnings else {}),
            "versions": versions(),
        }

    def _reference(self, duration: float) -> Reference:
        scenario = self.scenario
        with source_named(f"scenario {scenario.name}"):
            known = self.models.known
            reference = compute_reference(
                known.robot,
                self.trajectory,
                scenario.feedforward,
                self.sample_time,
                duration,
                self.start,
                known.laws,
                link_motion=self.loop_context.link_motion,
            )
        return self._with_torque(reference)

    def _with_torque(self, reference: Reference) -> Reference:
        """Set the feedforward torque to zero without `feedforward_torque`."""
        if self.scenario.feedforward_torque:
            return reference
        return replace(reference, torque=np.zeros_like(reference.torque))


def bytes_per_sample(robot: Robot, n_out: int, *, planned: bool = False, link_motion: bool = False) -> int:
    """Return the memory per sample of a run [bytes], as all signals are held at once.

    It holds the reference (its parts and the whole), the signal to the controller, the motion with its derivatives
    from which the reference is computed, and the log.

    Args:
        robot: The robot, with M motors.
        n_out: Number of coordinates of the trajectory.
        planned: Whether it is an identification, whose reference is computed in place.
        link_motion: Whether the controller follows the motion of the links.
    """
    m = robot.n_motors
    further = 2 * sum(sensor.size for sensor in robot.further_sensors) + (10 * m if link_motion else 0)
    reference, signal, derivatives, log = 8 + 3 * m + n_out, 3 * m, 5 * (m + n_out), 7 + 2 * m
    return 8 * (reference + signal + log + further + (1 if planned else reference + derivatives))


def _pre_actuation(scenario: Scenario, models: ScenarioModels, trajectory: Trajectory, sample_time: float) -> float:
    """Return the time for which the motors move before the tool [s]."""
    known = models.known
    near = None if scenario.start is None else np.array(scenario.start, dtype=float)
    try:
        return pre_actuation(known.robot, trajectory, scenario.feedforward, sample_time, near, known.laws)
    except InputError:
        return 0.0  # the reference reports it, after a path out of reach, whose message names the point


def _check_reachable(trajectory: Trajectory, robot: Robot, near: FloatArray) -> None:
    """Refuse a tool path that leaves the reach of the rigid arm or passes a singularity; names the point."""
    if trajectory.joints or not robot.spec.outputs[trajectory.output].pose:
        return
    gears = list(robot.gear_rows)
    if is_reachable(trajectory, rigid_kinematics(ToolGeometry.of(robot), trajectory.output), near[gears]):
        return
    slope, arm = robot.model.output_with_slope(trajectory.output), robot.arm_from_gears
    check_reachable(
        trajectory,
        lambda target, close: robot.inverse_kinematics(target, arm(close), trajectory.output)[gears],
        lambda joints: np.asarray(slope(arm(joints))[1], dtype=float),
        near[gears],
    )
