from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from flexros.analysis import analyse
from flexros.analysis.report.path import FACTORS, PathSection, magnification, path_picture

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("error", "factor"), [(3e-4, 20), (9e-3, 1), (4e-5, 200), (1.0, 1), (0.0, FACTORS[-1])])
def test_magnification_draws_the_error_as_a_small_part_of_the_path(error, factor):
    assert magnification(error, 0.07) == factor


def test_attained_path_is_drawn_at_the_factor(make_run):
    analysis = analyse(make_run(error=3e-4))
    picture = path_picture([analysis])
    curve = picture.magnified[0]
    drawn = np.column_stack([picture.figure.data[curve.trace].x, picture.figure.data[curve.trace].y])
    centre = np.array([2121.403786951, -354.624247994])
    excess = np.max(np.abs(np.linalg.norm(drawn - centre, axis=1) - 25.0))
    assert excess == pytest.approx(1e3 * picture.factor * analysis.path.path.maximum, rel=1e-4)
    np.testing.assert_allclose(curve.base + picture.factor * curve.deviation, drawn, rtol=1e-6)


def test_no_line_reaches_the_frame_at_any_magnification(make_run):
    picture = path_picture([analyse(make_run(error=3e-4))])
    *lines, room = picture.magnified
    for factor in FACTORS:
        reach = room.base[:, 0] + factor * room.deviation[:, 0]
        for line in lines:
            drawn = line.base[:, 0] + factor * line.deviation[:, 0]
            assert reach.min() < drawn.min() <= drawn.max() < reach.max()


def test_a_common_reference_is_drawn_once_and_dotted(make_run):
    picture = path_picture([analyse(make_run()), analyse(make_run(error=1e-4), label="other")])
    commanded = [trace for trace in picture.figure.data if trace.name == "commanded"]
    assert [trace.line.dash for trace in commanded] == ["dot"]


def test_both_axes_have_the_same_scale_and_a_unit(make_run):
    layout = path_picture([analyse(make_run())]).figure.layout
    assert layout.yaxis.scaleanchor == "x"
    assert (layout.xaxis.title.text, layout.yaxis.title.text) == ("x [mm]", "z [mm]")


@pytest.mark.parametrize(
    ("columns", "titles"), [("xy", ("y [mm]", "x [mm]")), ("yx", ("x [mm]", "y [mm]")), ("xz", ("x [mm]", "z [mm]"))]
)
def test_a_path_higher_than_wide_is_drawn_on_its_side_unless_it_is_upright(make_run, columns, titles):
    log = make_run()

    def ellipse(series):
        position = np.zeros_like(series.position)
        position[:, "xyz".index(columns[0])] = series.position[:, 0]
        position[:, "xyz".index(columns[1])] = 3.0 * series.position[:, 2]
        return replace(series, position=position)

    changed = replace(log, tool_pose=ellipse(log.tool_pose), tool_reference=ellipse(log.tool_reference))
    layout = path_picture([analyse(changed)]).figure.layout
    assert (layout.xaxis.title.text, layout.yaxis.title.text) == titles


def test_repeatability_is_drawn_only_where_there_are_cycles(make_run):
    assert len(PathSection().blocks([analyse(make_run())])) == 1
    assert len(PathSection().blocks([analyse(make_run(cycles=3))])) == 2
