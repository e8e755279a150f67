"""Design of controllers, and their cost on the benchmark."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import flexros
from flexros.errors import InputError


@pytest.fixture(scope="module")
def lqg() -> flexros.ControllerDesign:
    return flexros.design("lqg", "four_mass")


def test_design_is_stable_with_every_spring_segment(lqg: flexros.ControllerDesign) -> None:
    frame = lqg.to_pandas()
    assert lqg.stable
    assert len(frame) == 5
    assert frame["largest_eigenvalue"].max() < 1


def test_controller_of_python_control_is_the_law(lqg: flexros.ControllerDesign) -> None:
    system = lqg.to_control()
    assert system.dt == 0.0005
    assert np.array_equal(system.A, np.array(lqg.law.A))


def test_choices_are_checked() -> None:
    with pytest.raises(InputError, match="torque_weights"):
        flexros.design("lqg", "four_mass", torque_weights=1.0)
    with pytest.raises(InputError, match="lqg"):
        flexros.design("lqr", "four_mass")


def test_design_shows_plots_and_writes_itself(lqg: flexros.ControllerDesign, tmp_path: Path) -> None:
    assert "Gain margin" in lqg._repr_html_()
    for what in ("bode", "nyquist", "step"):
        assert lqg.plot(what).data
    with pytest.raises(InputError, match="0 to 0"):
        lqg.plot(motor=1)
    run = flexros.run("four_mass_lqg", settings={"controller": lqg.law, "duration": 0.05})
    assert run.scenario.controller == lqg.law
    assert "flexros.design('lqg', 'four_mass')" in lqg.write(tmp_path / "lqg.yaml").read_text(encoding="utf-8")


@pytest.mark.slow
def test_benchmark_puts_controllers_side_by_side(lqg: flexros.ControllerDesign) -> None:
    results = flexros.benchmark_controllers(lqg, "pid_check", noise=0.0, seeds=[1])
    frame = results.to_pandas()
    assert frame.loc[("all", "V", "1"), "pid_check"] == pytest.approx(results[1].cost)
    assert sum(sum(bar.x) for bar in results.plot().data) == pytest.approx(sum(one.cost for one in results))
    assert "pid_check" in results._repr_html_()
    assert results[0].to_pandas().shape[1] == 1


def test_two_controllers_of_one_name_are_refused() -> None:
    with pytest.raises(InputError, match="names of their own"):
        flexros.benchmark_controllers("lqg", "lqg")
    with pytest.raises(InputError, match="no controller"):
        flexros.benchmark_controllers()
