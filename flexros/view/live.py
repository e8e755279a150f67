"""The page of a running robot: the arm as topics tell it, and the last seconds of its motors."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.report.base import FACTORS
from flexros.report.colours import FLOOR, REPAIRED
from flexros.report.theme import run_colour
from flexros.view.page import FLOOR_BELOW, AbstractPage
from flexros.view.scene import GHOST, ArmLook, rgb

if TYPE_CHECKING:
    from collections.abc import Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.view.scene import AbstractShapes

REFRESH = 0.05
"""Time between two pictures [s] (chosen)."""
KEPT = 400
"""Values of a plot, one for each picture (chosen): the last 20 s."""
_FACTOR = 10
"""Magnification of the deflection at first (chosen)."""


class LivePage(AbstractPage):
    """Shows a running robot in the browser.

    Args:
        robot: The robot.
        host: Address the page listens on.
        port: Port; the next free one is taken where it is in use.

    Attributes:
        server: The viser page.
        drawn: Ends of all bars as drawn last [m], shape (n_bars, 2, 3); None before the first message.
    """

    def __init__(self, robot: Robot, *, host: str = "127.0.0.1", port: int = 8080) -> None:
        super().__init__(f"{robot.name}, live", host, port)
        self.robot = robot
        self.drawn: FloatArray | None = None
        self._look = ArmLook(robot)
        self._view = self._look.view
        self._links: dict[str, AbstractShapes] = {}
        self._motors: tuple[float, FloatArray] | None = None
        self._bars: tuple[FloatArray, FloatArray] | None = None
        self._past: deque[tuple[float, FloatArray]] = deque(maxlen=KEPT)
        gui = self.server.gui
        self._state = gui.add_markdown("Waiting for joint_states.")
        marks = tuple((index, f"{value:g}") for index, value in enumerate(FACTORS) if f"{value}"[0] == "1")
        self._factor = gui.add_slider(
            "Deflection ×", min=0, max=len(FACTORS) - 1, step=1, initial_value=FACTORS.index(_FACTOR), marks=marks
        )
        series: list[dict[str, object]] = [{"label": "time [s]"}]
        series += [{"label": name, "stroke": run_colour(index)} for index, name in enumerate(robot.joint_names)]
        empty = tuple(np.zeros(2) for _ in series)
        self._plot = gui.add_uplot(
            empty, tuple(series), title="motor positions [rad or m]", height=220, scales={"x": {"time": False}}
        )
        ends = self._view.at(np.array([robot.home])).reshape(-1, 3)
        low, high = self._look.drawing.grown(ends.min(axis=0), ends.max(axis=0))
        extent = float(np.linalg.norm(high - low)) or 1.0
        floor = (0.0, 0.0, min(float(low[2]), 0.0) - FLOOR_BELOW * extent)
        self.server.scene.add_grid("/floor", width=4 * extent, height=4 * extent, plane="xy", position=floor)
        self._aim(0.5 * (low + high), np.array([0.12, -1.1, 0.3]) * extent)
        self._move(self._draw_on)

    def take_motors(self, stamp: float, names: Sequence[str], positions: Sequence[float]) -> None:
        """Take over motor positions; messages that lack a motor are skipped.

        Args:
            stamp: Time of the sample [s].
            names: Joint names of the message.
            positions: Their positions [rad or m].
        """
        by_name = dict(zip(names, positions))
        if all(name in by_name for name in self.robot.joint_names):
            values = np.array([by_name[name] for name in self.robot.joint_names], dtype=float)
            with self._lock:
                self._motors = (stamp, values)

    def take_bars(self, true: FloatArray, stiff: FloatArray) -> None:
        """Take over the arm from the markers of a FlexROS plant.

        Args:
            true: Ends of all bars in the base frame [m], shape (n_bars, 2, 3).
            stiff: The same with stiff springs.
        """
        with self._lock:
            self._bars = (true, stiff)

    def _draw_on(self) -> None:
        while not self._ended.wait(REFRESH):
            with self._lock:
                motors, bars = self._motors, self._bars
            if motors is not None and (not self._past or motors[0] != self._past[-1][0]):
                if self._past and motors[0] < self._past[-1][0]:
                    self._past.clear()  # another run
                self._past.append(motors)
                self._tell(motors[0], bars is not None)
            bent = bars is not None
            arm = None if motors is None else np.asarray(self.robot.arm_from_gears(motors[1]), dtype=float)[None]
            if self._look.drawing.meshes and arm is not None:
                self._draw_links(arm, bent)
                if not bent:
                    self.drawn = self._view.at(arm)[0]
                    continue
            if bars is None and arm is not None:
                stiff = self._view.at(arm)[0]
                bars = (stiff, stiff)
            if bars is not None:
                true, stiff = bars
                self._draw(stiff + FACTORS[int(self._factor.value)] * (true - stiff), stiff)

    def _tell(self, now: float, bent: bool) -> None:
        source = (
            f"Deflection from arm_markers, drawn ×{FACTORS[int(self._factor.value)]}."
            if bent
            else "Motor positions with stiff springs: nobody publishes arm_markers."
        )
        self._state.content = f"**{now:.2f} s**. {source}"
        if len(self._past) > 1:
            time = np.array([stamp for stamp, _ in self._past])
            self._plot.data = (time, *np.array([values for _, values in self._past]).T.copy())

    def _draw_links(self, arm: FloatArray, bent: bool) -> None:
        """Draw the links at the motor positions; beside a bent arm, which is drawn as bars, they are a shadow of it."""
        name = "/shadow" if bent else "/links"
        if name not in self._links:
            self.server.scene.remove_by_name("/links")
            looks = (FLOOR, GHOST) if bent else (REPAIRED, 1.0)
            self._links = {name: self._look.made(self.server, name, *looks)}
        self._links[name].move(arm)
        with self.server.atomic():
            self._links[name].show(0)

    def _draw(self, ends: FloatArray, stiff: FloatArray) -> None:
        scene: Any = self.server.scene
        width = 2 * max(self._view.radii)
        with self.server.atomic():
            scene.add_line_segments("/stiff", stiff, rgb(FLOOR), thickness=0.5 * width)
            scene.add_line_segments("/arm", ends, rgb(REPAIRED), thickness=width)
        self.drawn = ends
