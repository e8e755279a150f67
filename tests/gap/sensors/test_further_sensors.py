"""Gap and diagnosis of logs with further sensors, simulated and measured."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from flexros.effects import RobotWithEffects
from flexros.gap.checked_log import checked_log
from flexros.gap.diagnose import diagnose
from flexros.gap.fit.initial_values import initial_values
from flexros.gap.fit.least_squares import fit
from flexros.gap.fit.sum_of_squares import chi2_of
from flexros.gap.measure_gap import measure_gap
from flexros.gap.residuals.fit_data import FitData
from flexros.gap.residuals.prepare_fit_data import fit_data
from flexros.gap.settings import DiagnosisSettings
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.record.record import Record
from flexros.robot import load_robot
from tests.gap.diagnosis_logs import FEW_EFFECTS, MODEL, candidates_of, predictor_of, settings_of
from tests.gap.sensors.sensor_logs import sensed, sensed_data, truth_of

STIFFNESS = "stiffness_error@body_1.rz:relative=0.02"
KNEE = "nonlinear_stiffness@body_1.rz:relative=0.05,knee=0.05"
REALDATA = os.environ.get("FLEXROS_REALDATA", "")


@pytest.mark.parametrize("sensor", ["link position", "joint torque", "tool acceleration"])
def test_without_a_gap_none_is_found(sensor: str) -> None:
    measured = measure_gap(sensed(sensors=(sensor,), seed=2), MODEL)
    assert not measured.significant
    assert measured.numbers.before == pytest.approx(1.0, abs=0.2)


def fitted(effect: str, sensors: tuple[str, ...]) -> tuple[dict[str, float], np.ndarray]:
    """Fit one effect to a log that has it; return its parameters and their standard deviations."""
    record = sensed(effect, sensors=sensors) if sensors else truth_of(effect).record
    data, candidate = sensed_data(record), candidates_of()[effect.partition(":")[0]]
    predictor = predictor_of(candidate)
    starts = initial_values(predictor)
    best = starts[:, int(np.argmin(chi2_of(predictor, data, starts)))]
    found = fit(predictor, data, best, 20)
    deviation = np.sqrt(np.diag(np.linalg.inv(found.information))) * predictor.slopes(found.theta)
    return predictor.values(found.theta)[0], deviation


@pytest.mark.slow
def test_an_error_of_stiffness_is_known_better_with_a_link_side_encoder() -> None:
    (plain, wide), (values, narrow) = (fitted(STIFFNESS, sensors) for sensors in ((), ("link position",)))
    assert narrow[0] < 0.75 * wide[0]
    assert values["relative"] == pytest.approx(0.02, abs=4 * narrow[0])
    assert plain["relative"] == pytest.approx(0.02, abs=4 * wide[0])


@pytest.mark.slow
def test_a_nonlinear_spring_is_found_with_a_link_side_encoder() -> None:
    logs = [sensed(KNEE, seed=seed) for seed in (1, 2)]
    settings = settings_of(*FEW_EFFECTS, "nonlinear_stiffness")
    found = diagnose(logs[0], MODEL, holdout=logs[1], settings=settings).diagnosis
    assert found.verdict == "explained"
    assert [(cause.effect, cause.location) for cause in found.causes] == [("nonlinear_stiffness", "body_1.rz")]
    assert found.gap.closed_fraction == pytest.approx(1.0, abs=0.02)


@pytest.mark.slow
def test_a_sensor_of_wrong_sign_is_no_cause() -> None:
    records = []
    for seed in (1, 2):
        record = sensed(sensors=("joint torque",), seed=seed)
        sensor = record.sensors[0]
        records.append(replace(record, sensors=(replace(sensor, values=-sensor.values),)))
    found = diagnose(records[0], MODEL, holdout=records[1], settings=settings_of(*FEW_EFFECTS)).diagnosis
    assert found.verdict == "no_gap"
    assert any("joint torque of motor_1" in text and "sign" in text for text in found.warnings)


SERIAL_LINKS = Path(REALDATA) / "quanser_2dsfl"
measured = pytest.mark.skipif(
    not REALDATA or not SERIAL_LINKS.is_dir(),
    reason="FLEXROS_REALDATA is unset or names no folder with quanser_2dsfl/, the measured flexible links",
)
MAPPING = """
name: stage1
time: {column: t, unit: s}
columns:
  - {column: th11, quantity: position, joint: motor_1, unit: deg}
  - {column: im1, quantity: torque_command, joint: motor_1, unit: A, scale: {value: 8.925, unit: Nm/A}}
  - {column: th12, quantity: link_deflection, joint: motor_1, unit: deg}
"""


@cache
def gauge_record(folder: Path, name: str, sign: str = "") -> Record:
    """Read stage 1 with the strain gauge of its link."""
    mapping = folder / "mapping.yaml"
    mapping.write_text(MAPPING.replace("link_deflection,", f"link_deflection, {sign}"))
    log = import_log(load_mapping(str(mapping)), [SERIAL_LINKS / name])
    return checked_log(log, load_robot(str(SERIAL_LINKS / "robot_stage1.yaml")), name=name)


@cache
def gauge_data(folder: Path, name: str) -> FitData:
    robot = load_robot(str(SERIAL_LINKS / "robot_stage1.yaml"))
    return fit_data(gauge_record(folder, name), RobotWithEffects(robot, ()), DiagnosisSettings())


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("gauge")


@measured
@pytest.mark.parametrize("name", ["lqr.csv", "fsf.csv"])
def test_a_measured_strain_gauge_is_compared_as_a_deflection(folder: Path, name: str) -> None:
    data = gauge_data(folder, name)
    assert data.sensors is not None
    (channel,) = data.sensors.channels
    assert channel.deflection
    assert 5e-3 < np.std(channel.measured) < 1e-2
    assert channel.noise == pytest.approx(0.05 * np.std(channel.measured), rel=1e-2)


@measured
def test_a_link_that_the_model_describes_badly_is_told(folder: Path) -> None:
    """Nominal damping is zero, and a second link hangs on the first one."""
    text = [text for text in gauge_data(folder, "lqr.csv").record.warnings if "link position" in text]
    assert len(text) == 1
    assert "hardly follows" in text[0]


@measured
@pytest.mark.parametrize("name", ["lqr.csv", "fsf.csv"])
def test_a_measured_strain_gauge_of_wrong_sign_is_told(folder: Path, name: str) -> None:
    robot = load_robot(str(SERIAL_LINKS / "robot_stage1.yaml"))
    data = fit_data(gauge_record(folder, name, "sign: -1,"), RobotWithEffects(robot, ()), DiagnosisSettings())
    assert data.sensors is None
    assert any("opposite" in text and "sign" in text for text in data.record.warnings)


@measured
@pytest.mark.slow
def test_the_gauge_tells_the_inertia_of_the_drive(folder: Path) -> None:
    """Least squares on both stages gives 0.54 kg m2, the maker 0.0635; without the gauge the diagnosis found 0.12."""
    robot = load_robot(str(SERIAL_LINKS / "robot_stage1.yaml"))
    logs = [gauge_record(folder, name) for name in ("lqr.csv", "fsf.csv")]
    settings = settings_of("coulomb_friction", "hysteresis", "motor_inertia_error", "torque_gain_error")
    found = diagnose(logs[0], robot, holdout=logs[1], settings=settings).diagnosis
    inertia = {one.name: one.value for one in found.model_numbers}["motor_1.inertia"]
    assert inertia == pytest.approx(0.54, abs=0.15)
    assert found.gap.closed_fraction is not None
    assert found.gap.closed_fraction > 0.5
    assert any(cause.effect == "coulomb_friction" for cause in found.causes)


@measured
def test_the_gap_of_measured_links_counts_the_gauge(folder: Path) -> None:
    robot = load_robot(str(SERIAL_LINKS / "robot_stage1.yaml"))
    record = gauge_record(folder, "lqr.csv")
    model = RobotWithEffects(robot, ())
    both, motor = (measure_gap(one, model).numbers.before for one in (record, replace(record, sensors=())))
    assert both != pytest.approx(motor, rel=0.1)
    assert min(both, motor) > 100
