from __future__ import annotations

import numpy as np
import pytest

from flexros.robot.beam import clamped_modes, gauss_points


def test_roots_of_the_clamped_beam() -> None:
    """L. Meirovitch, Fundamentals of Vibrations (2001), section 8.4: cosh(b) cos(b) = -1."""
    roots = [mode.root for mode in clamped_modes(4)]
    np.testing.assert_allclose(roots, [1.8751040687, 4.6940911330, 7.8547574382, 10.9955407349], rtol=1e-9)


def test_heavy_tip_mass_gives_the_massless_spring_and_then_a_supported_end() -> None:
    """omega^2 = 3 E I / (M l^3) for the first mode; the roots of clamped-pinned, tan(b) = tanh(b), for the others."""
    first, second = clamped_modes(2, tip_mass=1e4)
    assert first.root**4 == pytest.approx(3 / 1e4, rel=1e-4)
    assert second.root == pytest.approx(3.926602, rel=1e-4)


def test_heavy_tip_inertia_keeps_the_tip_from_turning() -> None:
    """Clamped-guided: tan(b) = -tanh(b), first root 2.365020."""
    modes = clamped_modes(3, tip_inertia=1e3)
    assert modes[1].root == pytest.approx(2.365020, rel=1e-3)


@pytest.mark.parametrize(("mass", "inertia"), [(0.0, 0.0), (0.7, 0.03)])
def test_shapes_are_orthogonal_with_their_load_and_meet_the_ends(mass: float, inertia: float) -> None:
    modes = clamped_modes(4, mass, inertia)
    xi, weights = gauss_points(40)
    end, base = np.ones(1), np.zeros(1)
    shapes = np.array([mode.deflection(xi) for mode in modes])
    tips = np.array([mode.deflection(end)[0] for mode in modes])
    slopes = np.array([mode.slope(end)[0] for mode in modes])
    product = shapes * weights @ shapes.T + mass * np.outer(tips, tips) + inertia * np.outer(slopes, slopes)
    assert np.abs(product - np.diag(np.diag(product))).max() < 1e-9
    for mode in modes:
        assert abs(mode.deflection(base)[0]) < 1e-12
        assert abs(mode.slope(base)[0]) < 1e-12
        assert np.abs(mode.deflection(np.linspace(0, 1, 2001))).max() == pytest.approx(1.0)
        expected = mode.root**4 * inertia * mode.slope(end)[0]
        assert mode.curvature(end)[0] == pytest.approx(expected, abs=1e-7 * mode.root**2)


def test_slope_and_curvature_are_derivatives() -> None:
    (mode,) = clamped_modes(1, 0.5, 0.1)
    xi, h = np.linspace(0.1, 0.9, 5), 1e-5
    np.testing.assert_allclose(mode.slope(xi), (mode.deflection(xi + h) - mode.deflection(xi - h)) / (2 * h), atol=1e-8)
    np.testing.assert_allclose(mode.curvature(xi), (mode.slope(xi + h) - mode.slope(xi - h)) / (2 * h), atol=1e-8)
