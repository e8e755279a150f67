"""Short identification experiments, and identifications of E12 from computed responses with known noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from flexros.control.context import LoopContext
from flexros.identify.design.closed_loop_input import input_spectrum, output_error
from flexros.identify.design.experiment_design import DesignSettings, design_experiment
from flexros.identify.design.position_information import experiment_conditions
from flexros.identify.experiment.closed_loop_response import controller_response
from flexros.identify.experiment.plan import ExperimentPlan
from flexros.identify.frf.distortion import Distortion
from flexros.identify.frf.frequency_response import FrequencyResponse
from flexros.identify.graybox.frequency_model import FrequencyModel
from flexros.identify.graybox.search import SearchSettings, search
from flexros.identify.result import ExperimentFacts, IdentificationResult, identification_result
from flexros.robot import load_robot
from flexros.robot.linear.positions import linearise_positions
from flexros.scenario.identification import template_scenario
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import Scenario

ROBOT = load_robot("e12")
NAMES = tuple(name for name in ROBOT.parameters if name.endswith((".stiffness", ".damping")))
TRUTH = {name: ROBOT.parameters[name].value * (1.2 if name.endswith("stiffness") else 0.8) for name in NAMES}
FACTS = ExperimentFacts(400.0, 3, 6, 12, 2, 2.0, "multisine", "log", "direct")


def distortion(frequency: np.ndarray, response: np.ndarray, odd: float = 1e-3) -> Distortion:
    """Levels with odd distortion at the second motor, as a share of its output; noise is 0.1 %."""
    output = np.abs(response).sum(axis=2)
    flat = np.full(output.shape, 1e-3) * output
    between = frequency[:-1] + 0.5
    levels = np.stack([np.interp(between, frequency, output[:, motor]) for motor in range(2)], axis=1)
    return Distortion(
        frequency=frequency, output=output, noise=flat, total=3 * flat, time_variation=np.full(output.shape, np.nan),
        odd_frequency=between, odd=levels * [1e-3, odd], odd_noise=1e-3 * levels,
        even_frequency=np.array([]), even=np.zeros((0, 2)), even_noise=np.zeros((0, 2)),
    )  # fmt: skip


def make_result(noise: float, levels: bool = True, known: bool = True) -> IdentificationResult:
    """Identify E12 from responses whose encoder noise is multiplied; without covariance where it is not known."""
    template = template_scenario(ROBOT, "e12")
    specification = template.identification
    assert specification is not None
    law, T = template.controller, ROBOT.sample_time
    design = design_experiment(ROBOT, NAMES, specification, law, T, DesignSettings(3, 60))
    conditions = experiment_conditions(specification, ROBOT, T, 1, most_lines=30)
    plant = ROBOT.with_values(TRUTH)
    motors = design.candidates.motor_positions[design.chosen]
    linear = linearise_positions(plant, NAMES, motors)
    exact = FrequencyModel(linear, conditions.frequency, T, ROBOT.delay).response(linear.values)
    controller = controller_response(law, LoopContext(ROBOT, T), conditions.frequency)
    U = input_spectrum(exact, conditions, controller)
    variance = noise**2 * output_error(exact, U, conditions)
    generator, responses = np.random.default_rng(1), []
    for place, G in enumerate(exact):
        inverse = np.linalg.inv(U[place] @ U[place].conj().swapaxes(1, 2)) / 2
        normal = generator.normal(size=(*G.shape, 2)) @ [1, 1j] / np.sqrt(2)
        error = np.sqrt(variance[place])[:, :, None] * normal @ np.linalg.cholesky(inverse).conj().swapaxes(1, 2)
        responses.append(
            FrequencyResponse(
                frequency=conditions.frequency, response=G + error, noise_error=None,
                total_error=variance[place][:, :, None] * np.eye(2) + 0j if known else None,
                input_inverse=inverse, degrees_of_freedom=30.0,
                input_names=ROBOT.joint_names, output_names=ROBOT.joint_names,
                input_units=("Nm", "Nm"), coordinate_units=("rad", "rad"),
                gears=design.positions[place], motor_position=motors[place], sample_time=T, n_periods=2, n_blocks=2,
                distortion=distortion(conditions.frequency, G) if levels else None,
                warnings=(f"position {place + 1}: a gap of {place + 2} samples",),
            )
        )  # fmt: skip
    found = search(ROBOT, responses, NAMES, SearchSettings(weights="user", starts=4))
    return identification_result(
        found.problem, found.fit, found.searched, design=design, facts=FACTS, truth=TRUTH,
        warnings=("amplitudes were lowered",), provenance={"scenario": {"robot": "e12", "seed": 7}},
    )  # fmt: skip


@pytest.fixture(scope="session")
def make() -> Callable[..., IdentificationResult]:
    """Return the maker of results."""
    return make_result


@pytest.fixture(scope="session")
def clear() -> IdentificationResult:
    """An identification with ten times the nominal noise: all parameters are determined."""
    return make_result(10.0)


@pytest.fixture(scope="session")
def distorted(clear: IdentificationResult) -> IdentificationResult:
    """The same identification with odd distortion of 5 % at the second motor."""
    responses = tuple(
        replace(response, distortion=distortion(response.frequency, response.response, 0.05))
        for response in clear.problem.responses
    )
    return replace(clear, problem=replace(clear.problem, responses=responses))


@pytest.fixture(scope="session")
def noisy() -> IdentificationResult:
    """An identification with so much noise that dampers are not determined."""
    return make_result(1500.0)


def _scenario(**identification: object) -> Scenario:
    """Make a scenario on E12 whose experiments take 2.1 s each; the keys of `identification` replace those here."""
    given = {
        "positions": [[0.0, 0.3], [0.1, 0.4]],
        "blocks": 1,
        "periods": 2,
        "transient_periods": 1,
        "fade": 0.3,
        "settle": 0.1,
        "move": {"speed": 0.3, "acceleration": 0.3},
        "excitation": {"kind": "multisine", "period": 0.5, "lowest": 3.0, "highest": 40.0, "amplitude": 0.05},
    }
    return Scenario.model_validate(
        {
            "name": "mine",
            "robot": "e12",
            "feedforward": {"method": "flexible_joint"},
            "controller": {"kind": "pid", "kp": 1.35e5, "kd": 9000, "derivative_filter": 1e-3},
            "identification": {**given, **identification},
        }
    )


@pytest.fixture
def scenario_of() -> Callable[..., Scenario]:
    """Give a maker of scenarios, see `_scenario`."""
    return _scenario


@pytest.fixture
def plan_of() -> Callable[..., ExperimentPlan]:
    """Give a maker of plans of such scenarios."""
    return lambda **identification: plan_of_scenario(_scenario(**identification))
