"""Markers of the arm: true shape, shape with magnified deflection, and rigid shape of the motor positions."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from flexros.logs.stamps import NANOSECONDS
from flexros.logs.time_series import BASE_FRAME
from flexros.robot.arm_view import ArmView

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

COLOURS = {
    "true": (0.15, 0.35, 0.75, 1.0),
    "magnified": (0.9, 0.4, 0.1, 1.0),
    "stiff": (0.5, 0.5, 0.5, 0.5),
}
"""Red, green, blue and opacity of each arm; its name is the namespace of the marker."""

WIDTHS = {"true": 2.0, "magnified": 1.0, "stiff": 1.0}
"""Width of the lines in radii of the bars, chosen: a thin arm stays visible within a thick one."""


class ArmMarkers:
    """Fills one message of markers repeatedly.

    Args:
        robot: Robot to show.
    """

    def __init__(self, robot: Robot) -> None:
        self._view = ArmView(robot)
        self._markers = {name: self._marker(name) for name in COLOURS}
        self._message = MarkerArray(markers=list(self._markers.values()))

    def _marker(self, name: str) -> Marker:
        marker = Marker(ns=name, type=Marker.LINE_LIST, action=Marker.ADD)
        marker.header.frame_id = BASE_FRAME
        marker.pose.orientation.w = 1.0
        marker.scale.x = WIDTHS[name] * max(self._view.radii)
        marker.color = ColorRGBA(**dict(zip("rgba", COLOURS[name])))
        marker.points = [Point() for _ in range(2 * len(self._view.radii))]
        return marker

    def fill(self, stamp: int, state: FloatArray, magnification: float) -> MarkerArray:
        """Return the message of a state.

        Args:
            stamp: Simulated time [ns].
            state: State x = [q_a, q_m, rates], shape (2 n_coordinates,).
            magnification: Factor on the deflection [1].

        Returns:
            The message, the same object each time.
        """
        bars = self._view.bars(state, magnification)
        seconds, nanoseconds = divmod(stamp, NANOSECONDS)
        for name, marker in self._markers.items():
            marker.header.stamp.sec, marker.header.stamp.nanosec = seconds, nanoseconds
            for point, end in zip(marker.points, getattr(bars, name).reshape(-1, 3).tolist()):
                point.x, point.y, point.z = end
        return self._message
