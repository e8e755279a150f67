"""What lies between a predicted tool path and a tracker's, and is no gap: frames, tool offset, time offset.

The tracker sees p = R (x(t + tau) + Q(t + tau) c) + b with the predicted tool position x and orientation Q, rotation R
and origin b of the base in the tracker's frame, an offset c of the target in the tool's frame and a time offset tau of
the topic. Of these only what the motion shows is estimated: what leaves the path as it is stays zero.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from flexros.errors import InputError
from flexros.gap.tool_path import ToolPath

if TYPE_CHECKING:
    from flexros.arrays import FloatArray, IntArray
    from flexros.gap.record import ToolRecord

LONGEST_OFFSET = 0.1
"""Longest time offset that is looked for [s] (chosen)."""

SEEN = 1e-3
"""Effect of unknowns on the path, over that of those seen best, below which they are not seen (chosen)."""

FEWEST = 20
"""Fewest poses (chosen)."""

_ITERATIONS = 30
_HUBER = 2.5  # residual over its scale beyond which a pose counts less
_TRIED = 41  # time offsets with which the search begins


@dataclass(frozen=True, eq=False)
class ToolFrame:
    """Frames and offsets of a tool measurement.

    Attributes:
        rotation: R, base to tracker, shape (3, 3).
        origin: b, origin of the base in the tracker's frame [m], shape (3,).
        tool_offset: c, target in the tool's frame [m], shape (3,); zero where no orientation is predicted.
        time_offset: tau, by how much later than its stamp the tracker saw the tool [s].
        deviation: Standard deviations of small turns [rad], origin [m], tool offset [m] and time offset [s], shape
            (10,); infinite for what the motion does not show.
    """

    rotation: FloatArray
    origin: FloatArray
    tool_offset: FloatArray
    time_offset: float
    deviation: FloatArray


@dataclass(frozen=True, eq=False)
class CorrectedTool:
    """A tool measurement brought to the frame and the times of the prediction.

    Attributes:
        frame: What was estimated.
        rows: Poses of the tracker that the prediction covers, shape (m,).
        time: Their times in the time of the prediction [s], shape (m,).
        position: Measured positions of the tool in the frame of the prediction [m], shape (m, 3).
        residual: Measured minus predicted positions there [m], shape (m, 3).
        basis: Orthonormal basis of what small errors of the estimates add to the residual, shape (3 m, k); to be
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
        tool: What the tracker saw.
        duration: Time from the first sample of the record to the last [s].

    Returns:
        Largest offset of time that is looked for [s], and the rows of the poses, shape (m,).
    """
    margin = min(LONGEST_OFFSET, 0.1 * duration)
    return margin, np.flatnonzero((tool.time >= margin) & (tool.time <= duration - margin))


def correct_tool(
    tool: ToolRecord, position: FloatArray, sample_time: float, orientation: FloatArray | None = None
) -> CorrectedTool:
    """Estimate frames and offsets of a tool measurement, robustly, and take them off.

    Args:
        tool: What the tracker saw.
        position: Predicted tool positions at the samples of the record [m], shape (n, 3).
        sample_time: Time between two samples [s].
        orientation: Predicted orientations, quaternions x, y, z, w, shape (n, 4); without them no tool offset is told.

    Returns:
        The measurement in the frame of the prediction.

    Raises:
        InputError: There are too few poses within the record.
    """
    path = ToolPath(position, orientation, sample_time)
    margin, rows = usable_poses(tool, (len(position) - 1) * sample_time)
    if len(rows) < FEWEST:
        raise InputError(
            f"{len(rows)} poses of the tool lie within the record, needed are {FEWEST}; record tool_pose throughout"
        )
    measured, time = tool.position[rows], tool.time[rows]
    tau = _first_offset(path, measured, time, margin)
    rotation, origin = _rigid_fit(path.at(time + tau).position, measured)
    unknowns = _Unknowns(rotation, origin, np.zeros(3), tau)
    for _ in range(_ITERATIONS):
        fit = _linearised(path, measured, time, unknowns, orientation is not None)
        step = fit.step()
        unknowns = unknowns.moved(step, margin)
        if np.all(np.abs(step) < 1e-12):
            break
    fit = _linearised(path, measured, time, unknowns, orientation is not None)
    return _result(fit, unknowns, path, measured, time, rows)


@dataclass(frozen=True, eq=False)
class _Unknowns:
    rotation: FloatArray
    origin: FloatArray
    tool_offset: FloatArray
    time_offset: float

    def moved(self, step: FloatArray, margin: float) -> _Unknowns:
        """Add small turns, origin, tool offset and time offset, shape (10,)."""
        return _Unknowns(
            _turn(step[:3]) @ self.rotation,
            self.origin + step[3:6],
            self.tool_offset + step[6:9],
            float(np.clip(self.time_offset + step[9], -margin, margin)),
        )


@dataclass(frozen=True, eq=False)
class _Linearised:
    """Residual in the tracker's frame, shape (m, 3), and its slopes, shape (3 m, 10)."""

    residual: FloatArray
    slopes: FloatArray
    scale: float
    weight: FloatArray

    def step(self) -> FloatArray:
        """Solve for what the motion shows; the rest stays."""
        root = np.repeat(np.sqrt(self.weight), 3)[:, None]
        seen, right = self._seen(root * self.slopes)
        return np.asarray(right @ np.linalg.lstsq(seen, root[:, 0] * self.residual.ravel(), rcond=None)[0])

    def _seen(self, slopes: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return slopes along the combinations that are seen, shape (3 m, k), and these, shape (10, k)."""
        size = self._sizes()
        _, values, right = np.linalg.svd(slopes * size, full_matrices=False)
        kept = (right.T * size[:, None])[:, values > SEEN * values[0]]
        return slopes @ kept, kept

    def _sizes(self) -> FloatArray:
        """Sizes that make the unknowns comparable: each moves the path by about as much as it extends."""
        extent = max(float(np.sqrt(np.mean(self.slopes[:, :3] ** 2))), 1e-12)
        speed = max(float(np.sqrt(np.mean(self.slopes[:, 9] ** 2))), 1e-12)
        return np.concatenate([np.ones(3), np.full(6, extent), [extent / speed]])

    def basis(self) -> FloatArray:
        """Orthonormal basis of what the unknowns do to the residual, shape (3 m, k)."""
        return np.asarray(np.linalg.qr(self._seen(self.slopes)[0])[0])

    def deviation(self) -> FloatArray:
        """Standard deviations of the unknowns, infinite where unseen, shape (10,)."""
        seen, kept = self._seen(self.slopes)
        covariance = kept @ np.linalg.pinv(seen.T @ seen) @ kept.T * self.scale**2
        size = self._sizes()
        hidden = np.eye(10) - (kept / size[:, None]) @ (kept / size[:, None]).T
        deviation = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return np.where(np.diag(hidden) > 0.02, np.inf, deviation)


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
    scale = max(float(np.median(size)) / 1.538, 1e-15)  # median length of three normal numbers
    weight = np.minimum(1.0, _HUBER * scale * np.sqrt(3) / np.maximum(size, 1e-300))
    return _Linearised(residual, slopes.reshape(3 * m, 10), scale, weight)


def _result(
    fit: _Linearised, now: _Unknowns, path: ToolPath, measured: FloatArray, time: FloatArray, rows: IntArray
) -> CorrectedTool:
    """Turn measurement, residual and basis into the frame of the prediction."""
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
    """Try time offsets with the best rotation and origin of each."""
    tried = np.linspace(-margin, margin, _TRIED)
    cost = []
    for tau in tried:
        predicted = path.at(time + tau).position
        rotation, origin = _rigid_fit(predicted, measured)
        cost.append(float(np.median(np.linalg.norm(measured - predicted @ rotation.T - origin, axis=1))))
    best = int(np.argmin(cost))
    return float(tried[best]) if cost[best] < 0.999 * cost[_TRIED // 2] else 0.0


def _rigid_fit(points: FloatArray, measured: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Find rotation and origin of least squares (S. Umeyama, 1991); the least turn where points lie on a line."""
    centre, seen = points.mean(axis=0), measured.mean(axis=0)
    left, values, right = np.linalg.svd((measured - seen).T @ (points - centre))
    if values[0] <= 0:
        return np.eye(3), seen - centre
    if values[1] < SEEN * values[0]:
        rotation = _least_turn(right[0], left[:, 0])
    else:
        rotation = left @ np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))]) @ right
    return np.asarray(rotation), np.asarray(seen - rotation @ centre)


def _least_turn(start: FloatArray, end: FloatArray) -> FloatArray:
    """Rotation of least angle from one direction to another."""
    axis, cosine = np.cross(start, end), float(start @ end)
    if np.linalg.norm(axis) < 1e-12:
        return np.eye(3) if cosine > 0 else np.asarray(2 * np.outer(*[_across(start)] * 2) - np.eye(3))
    return _turn(axis / np.linalg.norm(axis) * np.arctan2(np.linalg.norm(axis), cosine))


def _across(direction: FloatArray) -> FloatArray:
    """Return a unit vector across a direction."""
    other = np.cross(direction, np.eye(3)[int(np.argmin(np.abs(direction)))])
    return np.asarray(other / np.linalg.norm(other))


def _skew(vectors: FloatArray) -> FloatArray:
    """Matrices of the vector product, shape (m, 3, 3)."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)


def _turn(vector: FloatArray) -> FloatArray:
    """Rotation matrix of a rotation vector [rad] (Rodrigues)."""
    angle = float(np.linalg.norm(vector))
    K = _skew(vector[None])[0]
    if angle < 1e-12:
        return np.asarray(np.eye(3) + K)
    return np.asarray(np.eye(3) + np.sin(angle) / angle * K + (1 - np.cos(angle)) / angle**2 * K @ K)
