"""Scenarios of experiments: templates for any robot, positions, time, torque limits, text."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.identify.design.experiment_design import SLOW, DesignSettings, ExperimentDesign, design_experiment
from flexros.robot import load_robot
from flexros.scenario.identification import designed_scenario, scenario_yaml, template_scenario, unknown_names
from flexros.scenario.identification_plan import plan_of_scenario
from flexros.scenario.scenario import load_scenario

pytestmark = pytest.mark.slow

E12 = load_robot("e12")


def designed(most: int | None = 1) -> ExperimentDesign:
    template = template_scenario(E12, "e12")
    assert template.identification is not None
    settings = DesignSettings(positions=3, candidates=30, most=most)
    return design_experiment(E12, unknown_names(E12), template.identification, template.controller, 5e-4, settings)


def test_unknowns_are_those_of_the_file_or_all_springs_and_dampers() -> None:
    six_axis = load_robot("six_axis")
    assert unknown_names(six_axis) == six_axis.spec.unknown_parameters
    assert unknown_names(E12) == tuple(f"body_{n}.ry.{kind}" for n in (1, 2, 3) for kind in ("stiffness", "damping"))
    with pytest.raises(InputError, match="robot emps has neither springs nor dampers"):
        unknown_names(load_robot("emps"))


def test_built_in_scenario_is_the_template_of_its_robot() -> None:
    template = template_scenario(E12, "my/e12.yaml")
    assert template.robot == "my/e12.yaml"
    assert template.controller == load_scenario("identify_e12").controller


def test_robot_without_scenario_gets_a_controller() -> None:
    elbow = load_robot("elbow")
    template = template_scenario(elbow, "elbow")
    assert template.controller.kind == "pid"
    assert plan_of_scenario(template).n_motors == 2


def test_scenario_without_identification_is_no_template() -> None:
    with pytest.raises(InputError, match="scenario circle_pd has no key identification"):
        template_scenario(E12, "e12", "circle_pd")


def test_positions_enter_the_scenario() -> None:
    design = designed()
    scenario, factor = designed_scenario(template_scenario(E12, "e12"), E12, design)
    assert scenario.identification is not None
    assert np.array(scenario.identification.positions) == pytest.approx(design.positions, abs=1e-4)
    assert scenario.identification.blocks == 2
    assert factor == 1.0


def test_description_names_the_candidates_of_the_positions() -> None:
    design = designed()
    some = replace(design, candidates=replace(design.candidates, refused={SLOW: 100, "the rest is not stable": 4}))
    left = len(design.candidates.gears)
    scenario, _ = designed_scenario(template_scenario(E12, "e12"), E12, some)
    told = f"{left} of {left + 100} candidates (in the others the loop settles too slowly) for the 6 unknown parameters"
    assert told in scenario.description
    all_of_them = replace(design, candidates=replace(design.candidates, refused={}))
    assert all_of_them.origin == f"{left} candidates"


def test_single_best_position_is_remarked() -> None:
    design = designed()
    many = replace(design, design=replace(design.design, support=np.array([0, 1])))
    assert many.remark == ""
    alone = replace(design, design=replace(design.design, support=np.array([0])))
    assert alone.remark.startswith("The best experiment has a single position")


def test_repeated_positions_have_more_blocks() -> None:
    design = designed(most=None)
    scenario, _ = designed_scenario(template_scenario(E12, "e12"), E12, design)
    assert scenario.identification is not None
    assert scenario.identification.blocks_per_position == tuple(2 * design.counts)


def test_transient_periods_grow_with_the_time_that_is_left() -> None:
    template, design = template_scenario(E12, "e12"), designed()
    template = template.with_values({"identification.transient_periods": 2})
    assert template.identification is not None
    own = template.identification.transient_periods
    periods = []
    for longest in (0.0, 150.0, 1800.0):
        scenario, _ = designed_scenario(template, E12, design, longest)
        assert scenario.identification is not None
        periods.append(scenario.identification.transient_periods)
        assert plan_of_scenario(scenario).duration <= max(longest, 110.0)
    assert periods[0] == own
    assert own < periods[1] < periods[2]


def test_amplitude_is_lowered_to_what_the_torque_limits_allow() -> None:
    template = template_scenario(E12, "e12").with_values({"controller.torque_limit": 600.0})
    scenario, factor = designed_scenario(template, E12, designed())
    assert template.identification is not None
    assert scenario.identification is not None
    before = np.array(template.identification.excitation.amplitude)
    assert 0 < factor < 1
    assert np.array(scenario.identification.excitation.amplitude) == pytest.approx(factor * before, rel=0.01)


def test_controller_that_does_not_hold_the_robot_is_refused() -> None:
    template = template_scenario(E12, "e12").with_values({"controller.kp": 5e8})
    settings = DesignSettings(positions=2, candidates=10)
    assert template.identification is not None
    design = design_experiment(E12, unknown_names(E12), template.identification, template.controller, 5e-4, settings)
    with pytest.raises(InputError, match="robot e12 is unstable at the gear positions .*; lower the gains"):
        designed_scenario(template, E12, design)


def test_text_is_the_scenario_again(tmp_path: Path) -> None:
    scenario, _ = designed_scenario(template_scenario(E12, "e12"), E12, designed())
    text = scenario_yaml(scenario)
    (tmp_path / "experiment.yaml").write_text(text)
    assert load_scenario(tmp_path / "experiment.yaml") == scenario
    assert "null" not in text
    assert max(map(len, text.splitlines())) <= 120
