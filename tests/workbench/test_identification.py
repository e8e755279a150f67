"""From the log of an experiment to the identified robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexros
from flexros.errors import InputError

TRUE = 5e4


@pytest.fixture(scope="module")
def responses() -> flexros.FrequencyResponses:
    run = flexros.run("identify_two_mass", settings={"plant.values.body_1.rz.stiffness": TRUE})
    return flexros.frequency_responses(run)


@pytest.fixture(scope="module")
def found(responses: flexros.FrequencyResponses) -> flexros.IdentificationResult:
    return flexros.identify_robot(responses, "two_mass", starts=2)


def test_stiffness_of_the_plant_is_found(found: flexros.IdentificationResult) -> None:
    row = found.to_pandas().loc["body_1.rz.stiffness"]
    assert row["low"] < TRUE < row["high"]
    assert row["unit"] == "Nm/rad"
    assert found.robot.parameters["body_1.rz.stiffness"].value == pytest.approx(TRUE, rel=0.01)


def test_identification_shows_plots_and_writes_itself(found: flexros.IdentificationResult, tmp_path: Path) -> None:
    assert "body_1.rz.damping" in found._repr_html_()
    assert found.plot().data
    assert found.plot("responses").data
    found.write(tmp_path / "found")
    assert flexros.load_robot(tmp_path / "found" / "identified.yaml").n_motors == 1
    with pytest.raises(InputError, match="parameters, responses"):
        found.plot("poles")


def test_response_goes_to_python_control_and_pandas(responses: flexros.FrequencyResponses) -> None:
    (response,) = responses
    frd = response.to_control()
    assert frd.omega[0] == pytest.approx(2 * np.pi * response.frequency[0])
    assert frd.frdata[0, 0, 5] == response.response[5, 0, 0]
    frame = responses.to_pandas()
    row = frame.loc[(1, response.frequency[5], "motor_1", "motor_1")]
    assert row["magnitude"] == pytest.approx(abs(response.response[5, 0, 0]))
    assert row["std"] > 0
    assert response.to_xarray().sizes["frequency"] == len(frame)


def test_responses_are_a_file_and_back(responses: flexros.FrequencyResponses, tmp_path: Path) -> None:
    responses.save(tmp_path / "frf.nc")
    again = flexros.FrequencyResponses.load(tmp_path / "frf.nc")
    assert np.array_equal(again[0].response, responses[0].response)
    assert len(again[:1]) == 1
    assert "lines" in responses._repr_html_()


def test_log_without_an_experiment_is_refused() -> None:
    with pytest.raises(InputError, match="identification"):
        flexros.frequency_responses(Path(__file__).parents[2] / "bags" / "sample_circle_dae")
