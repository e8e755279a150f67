"""Frames, tool offset and time offset between a predicted tool path and that of a tracker, which do not count as a gap.

The tracker sees p = R (x(t + tau) + Q(t + tau) c) + b with the predicted tool position x and orientation Q, rotation R
and origin b of the base in the tracker's frame, an offset c of the target in the tool's frame and a time offset tau of
the topic. Offsets that the motion does not show beyond the noise stay at zero, where a wide prior holds them.

The estimate is Gauss-Newton with Huber weights, in which the best frame of every step is solved for exactly. Weights
and scale change in every step, so that there is no single cost that `flexros.prediction.damped_least_squares` could
minimise.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial.transform import Rotation

from flexros.errors import InputError
from flexros.gap.residuals.tool_path import ToolPath

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.record.record import ToolRecord

LONGEST_OFFSET = 0.1
"""Largest time offset that is searched [s] (chosen)."""

PRIOR = 0.3
"""Standard deviation of offsets about zero, in extents of the path, and of steps of the frame (chosen)."""

IDENTIFIABLE = 0.1
"""Standard deviation, in radians or extents of the path, up to which an unknown is identifiable (chosen)."""

HIDDEN = 0.1
"""Effect of an unknown as large as its prior, over the noise, up to which it is not projected out [1] (chosen)."""

STRAIGHT = 1e-9
"""Common variance of two paths across their line, over that along it, below which the turn about it is not identifiable
(chosen)."""

FEWEST = 20
"""Least number of poses (chosen)."""

_ITERATIONS = 30
_HUBER = 2.5  # residual over its scale beyond which a pose has less weight
_TRIED = 41  # initial values of the time offset


@dataclass(frozen=True, eq=False)
class ToolFrame:
    """Frames and offsets of a tool measurement.

    Attributes:
        rotation: R, base to tracker, shape (3, 3).
        origin: b, origin of the base in the tracker's frame [m], shape (3,).
        tool_offset: c, target in the tool's frame [m], shape (3,); zero where no orientation is predicted.
        time_offset: tau, time of the measurement minus its stamp [s].
        deviation: Standard deviations of small turns [rad], origin [m], tool offset [m] and time offset [s], shape
            (10,); infinite for unknowns that the motion does not show.
    """

    rotation: FloatArray
    origin: FloatArray
    tool_offset: FloatArray
    time_offset: float
    deviation: FloatArray


@dataclass(frozen=True, eq=False)
class CorrectedTool:
    """A tool measurement in the frame and the time of the prediction.

    Attributes:
        frame: The estimated frame and offsets.
        rows: Poses of the tracker that the prediction covers, shape (m,).
        time: Their times in the time of the prediction [s], shape (m,).
        position: Measured positions of the tool in the frame of the prediction [m], shape (m, 3).
        residual: Measured minus predicted positions there [m], shape (m, 3).
        basis: Orthonormal basis of the effect of small errors of the estimates on the residual, shape (3 m, k); to be
            projected out where a residual is fitted.
        scale: Robust standard deviation of the residual [m].
    """

    frame: ToolFrame
    rows: IntArray
    time: FloatArray
    position: FloatArray
    residual: FloatArray
    basis: FloatArray
    scale: float


def usable_poses(tool: ToolRecord, duration: float) -> tuple[float, IntArray]:
    """List the poses that stay within a record with any offset of the tracker's clock.

    Args:
        tool: The measurement.
        duration: Time from the first sample of the record to the last [s].

    Returns:
        Largest offset of time that is looked for [s], and the rows of the poses, shape (m,).
    """
    margin = min(LONGEST_OFFSET, 0.1 * duration)
    return margin, np.flatnonzero((tool.time >= margin) & (tool.time <= duration - margin))


def correct_tool(
    tool: ToolRecord, position: FloatArray, sample_time: float, orientation: FloatArray | None = None
) -> CorrectedTool:
    """Estimate frames and offsets of a tool measurement, robustly, and correct the measurement.

    Args:
        tool: The measurement.
        position: Predicted tool positions at the samples of the record [m], shape (n, 3).
        sample_time: Time between two samples [s].
        orientation: Predicted orientations, quaternions x, y, z, w, shape (n, 4); None leaves the tool offset at
            zero.

    Returns:
        The measurement in the frame of the prediction.

    Raises:
        InputError: There are too few poses within the log.
    """
    path = ToolPath(position, orientation, sample_time)
    margin, rows = usable_poses(tool, (len(position) - 1) * sample_time)
    if len(rows) < FEWEST:
        raise InputError(
            f"{len(rows)} poses of the tool are within the log, but {FEWEST} are needed; record tool_pose throughout"
        )
    measured, time = tool.position[rows], tool.time[rows]
    start = _aligned(path, measured, time, np.zeros(3), _first_offset(path, measured, time, margin))
    fits = [
        _settled(path, measured, time, initial, margin, orientation is not None)
        for initial in (start, start.turned_about_line(measured))
    ]
    return _result(*min(fits, key=lambda fit: fit[0].scale), path, measured, time, rows)


def _settled(
    path: ToolPath, measured: FloatArray, time: FloatArray, now: _Unknowns, margin: float, oriented: bool
) -> tuple[_Linearised, _Unknowns]:
    """Iterate to convergence by Gauss-Newton, with the best frame of every step."""
    for _ in range(_ITERATIONS):
        fit = _linearised(path, measured, time, now, oriented)
        step = fit.step(now.offsets)
        late = float(np.clip(now.time_offset + step[9], -margin, margin))
        now = _aligned(path, measured, time, now.tool_offset + step[6:9], late, fit.weight)
        if np.all(np.abs(step) < 1e-9):
            break
    return _linearised(path, measured, time, now, oriented), now


@dataclass(frozen=True, eq=False)
class _Unknowns:
    rotation: FloatArray
    origin: FloatArray
    tool_offset: FloatArray
    time_offset: float

    @property
    def offsets(self) -> FloatArray:
        """Deviations from the prior, shape (10,): the offsets; the frame has none."""
        return np.concatenate([np.zeros(6), self.tool_offset, [self.time_offset]])

    def turned_about_line(self, measured: FloatArray) -> _Unknowns:
        """Turn the frame by half a turn about the line of the path, where an offset may hide this turn."""
        centre = measured.mean(axis=0)
        line = np.linalg.svd(measured - centre, full_matrices=False)[2][0]
        half = 2 * np.outer(line, line) - np.eye(3)
        return replace(self, rotation=half @ self.rotation, origin=half @ (self.origin - centre) + centre)


@dataclass(frozen=True, eq=False)
class _Linearised:
    """Residual in the tracker's frame, shape (m, 3), and its slopes, shape (3 m, 10)."""

    residual: FloatArray
    slopes: FloatArray
    scale: float
    weight: FloatArray

    def step(self, offsets: FloatArray) -> FloatArray:
        """Solve for the step that fits path and prior, shape (10,)."""
        size = self._sizes()
        root = np.repeat(np.sqrt(self.weight), 3) / self.scale
        rows = np.vstack([root[:, None] * self.slopes * size, np.eye(10) / PRIOR])
        aims = np.concatenate([root * self.residual.ravel(), -offsets / size / PRIOR])
        return np.asarray(size * np.linalg.lstsq(rows, aims, rcond=None)[0])

    def _sizes(self) -> FloatArray:
        """Scales of the unknowns: each moves the path by about its extent."""
        extent = max(float(np.sqrt(np.mean(self.slopes[:, :3] ** 2))), 1e-12)
        speed = max(float(np.sqrt(np.mean(self.slopes[:, 9] ** 2))), 1e-12)
        return np.concatenate([np.ones(3), np.full(6, extent), [extent / speed]])

    def basis(self) -> FloatArray:
        """Orthonormal basis of the effect of the unknowns on the residual beyond its noise, shape (3 m, k)."""
        left, values, _ = np.linalg.svd(self.slopes * self._sizes(), full_matrices=False)
        return np.asarray(left[:, PRIOR * values > HIDDEN * self.scale])

    def deviation(self) -> FloatArray:
        """Standard deviations of the unknowns, infinite where they are not identifiable, shape (10,)."""
        size = self._sizes()
        _, values, right = np.linalg.svd(self.slopes * size, full_matrices=False)
        variance = (right.T**2) @ (1 / ((values / self.scale) ** 2 + PRIOR**-2))
        return np.where(variance > IDENTIFIABLE**2, np.inf, size * np.sqrt(variance))


def _aligned(
    path: ToolPath,
    measured: FloatArray,
    time: FloatArray,
    tool_offset: FloatArray,
    time_offset: float,
    weight: FloatArray | None = None,
) -> _Unknowns:
    """Compute the best frame for given offsets."""
    points = path.at(time + time_offset)
    rotation, origin = _rigid_fit(points.position + points.axes @ tool_offset, measured, weight)
    return _Unknowns(rotation, origin, tool_offset, time_offset)


def _linearised(path: ToolPath, measured: FloatArray, time: FloatArray, now: _Unknowns, oriented: bool) -> _Linearised:
    points = path.at(time + now.time_offset)
    arm = points.position + points.axes @ now.tool_offset
    turned = arm @ now.rotation.T
    residual = measured - turned - now.origin
    m = len(time)
    slopes = np.zeros((m, 3, 10))
    slopes[:, :, :3] = -_skew(turned)
    slopes[:, :, 3:6] = np.eye(3)
    if oriented:
        slopes[:, :, 6:9] = now.rotation @ points.axes
    slopes[:, :, 9] = (points.speed + points.axes_speed @ now.tool_offset) @ now.rotation.T
    size = np.linalg.norm(residual, axis=1)
    least = 1e-9 * float(np.max(np.abs(turned), initial=1e-6))
    scale = max(float(np.median(size)) / 1.538, least)  # median length of three normal numbers
    weight = np.minimum(1.0, _HUBER * scale * np.sqrt(3) / np.maximum(size, 1e-300))
    return _Linearised(residual, slopes.reshape(3 * m, 10), scale, weight)


def _result(
    fit: _Linearised, now: _Unknowns, path: ToolPath, measured: FloatArray, time: FloatArray, rows: IntArray
) -> CorrectedTool:
    """Transform measurement, residual and basis to the frame of the prediction."""
    points = path.at(time + now.time_offset)
    position = (measured - now.origin) @ now.rotation - points.axes @ now.tool_offset
    m = len(time)
    basis = np.einsum("ji,mjk->mik", now.rotation, fit.basis().reshape(m, 3, -1)).reshape(3 * m, -1)
    return CorrectedTool(
        frame=ToolFrame(now.rotation, now.origin, now.tool_offset, now.time_offset, fit.deviation()),
        rows=rows,
        time=time + now.time_offset,
        position=position,
        residual=position - points.position,
        basis=basis,
        scale=fit.scale,
    )


def _first_offset(path: ToolPath, measured: FloatArray, time: FloatArray, margin: float) -> float:
    """Return the best of several time offsets, each with its best rotation and origin."""
    tried = np.linspace(-margin, margin, _TRIED)
    cost = []
    for tau in tried:
        predicted = path.position_at(time + tau)
        rotation, origin = _rigid_fit(predicted, measured)
        cost.append(float(np.median(np.linalg.norm(measured - predicted @ rotation.T - origin, axis=1))))
    best = int(np.argmin(cost))
    return float(tried[best]) if cost[best] < 0.999 * cost[_TRIED // 2] else 0.0


def _rigid_fit(
    points: FloatArray, measured: FloatArray, weight: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Compute rotation and origin by least squares (Umeyama 1991); the smallest turn where points are on a line."""
    centre, seen = (np.average(each, axis=0, weights=weight) for each in (points, measured))
    share = np.ones(len(points)) if weight is None else weight
    left, values, right = np.linalg.svd((share[:, None] * (measured - seen)).T @ (points - centre))
    if values[0] <= 0:
        return np.eye(3), seen - centre
    if values[1] < STRAIGHT * values[0]:
        rotation = Rotation.align_vectors(left[:, :1].T, right[:1])[0].as_matrix()
    else:
        rotation = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return np.asarray(rotation), np.asarray(seen - rotation @ centre)


def _skew(vectors: FloatArray) -> FloatArray:
    """Matrices of the vector product, shape (m, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
