"""The page of a log: playback, magnification and plots beside the arms."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.report.base import FACTORS
from flexros.report.colours import NOMINAL
from flexros.report.theme import run_colour
from flexros.view.drawing import magnification
from flexros.view.page import AbstractPage
from flexros.view.scene import ArmLook, ArmShown, PathShown

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from flexros.arrays import FloatArray
    from flexros.robot import Robot
    from flexros.view.motion import Motion
    from flexros.view.signals import SignalPlot

SPEEDS = {"1/50": 0.02, "1/20": 0.05, "1/10": 0.1, "1/4": 0.25, "1/2": 0.5, "1": 1.0, "2": 2.0, "5": 5.0}
"""Speeds of playback by name, relative to that of the motion."""
_SHORT = 3.0
"""Motions shorter than this are played at a tenth of their speed at first [s] (chosen)."""
_REFRESH = 1 / 30
"""Time between two pictures [s]."""
_PLOTS_EVERY = 5
"""Pictures between two marks of the instant in the plots (chosen)."""
_APART = 0.25
"""Space between arms side by side, relative to their width (chosen)."""
PLOT_HEIGHT = 150
"""Height of a plot [px]."""


@dataclass(frozen=True, eq=False)
class ArmOverTime:
    """An arm to be drawn.

    Attributes:
        name: Its label.
        colour: Its colour, "#rrggbb".
        arm: Arm coordinates at the instants of the motion [rad or m], NaN where there are none, shape (n, N).
    """

    name: str
    colour: str
    arm: FloatArray


@dataclass(frozen=True, eq=False)
class Shown:
    """What the page of a log shows.

    Attributes:
        title: Heading.
        text: What is seen, in Markdown.
        robot: The robot.
        motion: Motion of the robot; all arms share its instants and its stiff arm.
        arms: The arms, side by side.
        path: Path of the tool; None where it is not known.
        plots: Plots beside the scene.
    """

    title: str
    text: str
    robot: Robot
    motion: Motion
    arms: tuple[ArmOverTime, ...]
    path: PathShown | None
    plots: tuple[SignalPlot, ...]


class LogPlayer(AbstractPage):
    """Plays a log in the browser.

    Args:
        shown: What is to be seen.
        host: Address the page listens on.
        port: Port; the next free one is taken where it is in use.
        factor: Magnification of the deflection at first; None to choose it.

    Attributes:
        server: The viser page.
        row: Instant that is shown, as a row of the motion.

    Raises:
        InputError: viser is not installed.
    """

    def __init__(self, shown: Shown, *, host: str = "127.0.0.1", port: int = 8080, factor: int | None = None) -> None:
        super().__init__(shown.title, host, port)
        self.shown, self.row, self._time = shown, 0, shown.motion.time
        self._first_factor = factor
        self._ribbon_colour = NOMINAL if len(shown.arms) == 1 else "#009e73"
        look = ArmLook(shown.robot)
        self._view, self._note = look.view, look.drawing.note
        self._arms = [
            ArmShown(self.server, arm.name, look, arm.colour, arm.arm, shown.motion, ghost=shown.motion.bent)
            for arm in shown.arms
        ]
        ends = self._view.at(shown.motion.stiff).reshape(-1, 3)
        self._low, self._high = look.drawing.grown(ends.min(axis=0), ends.max(axis=0))
        self._extent = float(np.linalg.norm(self._high - self._low)) or 1.0
        self._set_scene()
        self._add_controls()
        self._place()
        self.show(0)
        self._move(self._play)

    def show(self, row: int) -> None:
        """Show one instant.

        Args:
            row: Row of the motion.
        """
        with self._lock, self.server.atomic():
            self.row = int(np.clip(row, 0, len(self._time) - 1))
            for arm in self._arms:
                arm.show(self.row)

    def _chosen_factor(self, others: Sequence[FloatArray]) -> int:
        """Choose the magnification of the largest distance of arm coordinates from those of the robot."""
        step = slice(None, None, max(1, len(self._time) // 300))
        base = self._view.at(self.shown.motion.arm[step])
        apart = [np.linalg.norm(self._view.at(other[step]) - base, axis=-1) for other in others]
        moved = max(float(np.max(np.nan_to_num(distance), initial=0.0)) for distance in apart)
        return magnification(moved, self._extent) if moved > 0 else 1

    def _set_scene(self) -> None:
        server, shown = self.server, self.shown
        size = 4.0 * self._extent + 2.0 * (len(shown.arms) - 1) * self._spacing
        server.scene.add_grid(
            "/floor",
            width=size,
            height=size,
            plane="xy",
            cell_size=size / 40,
            section_size=size / 8,
            position=(0.0, 0.0, min(float(self._low[2]), 0.0) - 0.15 * self._extent),
        )
        middle = 0.5 * (self._low + self._high)
        width = (len(shown.arms) - 1) * self._spacing
        look = middle + np.array([0.5 * width, 0.0, 0.0])
        away = np.array([0.12, -1.0, 0.22]) * (0.85 * self._extent + 0.6 * width)
        self._target, self._away = look, away
        self._aim(look, away)

    @property
    def _spacing(self) -> float:
        return float((1 + _APART) * max(self._high[0] - self._low[0], 0.5 * self._extent))

    def _factor_slider(self, label: str, factor: int, changed: Callable[[], None]) -> Any:
        """Add a slider over `FACTORS`."""
        marks = tuple((index, f"{value:g}") for index, value in enumerate(FACTORS) if f"{value}"[0] == "1")
        place = int(np.argmin([abs(np.log(value / factor)) for value in FACTORS]))
        slider = self.server.gui.add_slider(
            label, min=0, max=len(FACTORS) - 1, step=1, initial_value=place, marks=marks
        )
        slider.on_update(lambda _: changed())
        return slider

    def _add_controls(self) -> None:
        gui, shown = self.server.gui, self.shown
        first, last = float(self._time[0]), float(self._time[-1])
        gui.add_markdown(" ".join(filter(None, (shown.text, self._note))))
        self._playing = gui.add_checkbox("Play", initial_value=True)
        self._speed = gui.add_dropdown(
            "Speed",
            tuple(SPEEDS),
            initial_value="1" if last - first >= _SHORT else "1/10",
            hint="relative to the motion",
        )
        step = max((last - first) / 1000, 1e-6)
        self._slider = gui.add_slider("Time [s]", min=first, max=last, step=step, initial_value=first)
        models = [arm.arm for arm in shown.arms[1:]]
        factor = self._first_factor or (1 if models else self._chosen_factor([shown.motion.stiff]))
        self._deflection = self._factor_slider("Deflection ×", factor, self._magnify)
        if models:
            self._errors = self._factor_slider("Model error ×", self._chosen_factor(models), self._magnify)
            self._beside = gui.add_checkbox("Side by side", initial_value=True)
            self._beside.on_update(lambda _: self._place())
        if shown.path is not None:
            size = float(np.linalg.norm(np.ptp(shown.path.commanded, axis=0)))
            worst = float(np.max(np.linalg.norm(shown.path.deviation, axis=1)))
            self._path = self._factor_slider("Path error ×", magnification(worst, size), self._draw_path)
            look = gui.add_button_group("Look at", ("arm", "path"))
            look.on_click(lambda _: self._look(look.value))
            self._draw_path()
        self._factors_text = gui.add_markdown("")
        self._plots = [self._add_plot(plot) for plot in shown.plots]
        self._slider.on_update(lambda event: self._seek() if event.client is not None else None)
        self._magnify()

    def _add_plot(self, plot: SignalPlot) -> Any:
        colours = [run_colour(index) for index in range(len(plot.names))]
        series: list[dict[str, object]] = [{"label": "time [s]"}]
        series += [{"label": name, "stroke": colour, "width": 1.5} for name, colour in zip(plot.names, colours)]
        series.append({"label": "now", "stroke": "#1b1f24", "width": 1, "scale": "mark"})
        return self.server.gui.add_uplot(
            self._marked(plot), tuple(series), title=plot.title, height=PLOT_HEIGHT,
            scales={"x": {"time": False, "auto": True}, "mark": {"auto": False, "range": (0.01, 0.99)}},
            legend={"show": True}, cursor={"sync": {"key": "time"}},
        )  # fmt: skip

    def _marked(self, plot: SignalPlot) -> tuple[FloatArray, ...]:
        """Return the curves of a plot with a line at the instant that is shown."""
        mark = np.zeros(len(plot.time))
        mark[min(int(np.searchsorted(plot.time, self._time[self.row])), len(mark) - 1)] = 1.0
        return (plot.time, *plot.values, mark)

    def _draw_path(self) -> None:
        assert self.shown.path is not None
        factor = FACTORS[int(self._path.value)]
        self._tell_factors()
        with self._lock, self.server.atomic():
            self.shown.path.draw(self.server, f"/{self.shown.arms[0].name}/path", factor, self._ribbon_colour)

    def _look(self, at: str) -> None:
        """Turn every camera to the arms or to the path."""
        target, away = self._target, self._away
        if at == "path" and self.shown.path is not None:
            points = self.shown.path.commanded
            target = 0.5 * (points.min(axis=0) + points.max(axis=0))
            away = away / np.linalg.norm(away) * 1.2 * float(np.linalg.norm(np.ptp(points, axis=0)))
        for client in self.server.get_clients().values():
            self._aim_one(client, target, away)

    def _magnify(self) -> None:
        errors = FACTORS[int(self._errors.value)] if len(self._arms) > 1 else 1
        with self._lock:
            for arm in self._arms:
                arm.magnify(FACTORS[int(self._deflection.value)], errors)
            self.show(self.row)
        self._tell_factors()

    def _tell_factors(self) -> None:
        """Write the magnifications below their sliders, which show numbers of steps."""
        if not hasattr(self, "_factors_text"):
            return
        factors = [("deflection", self._deflection)]
        factors += [("model error", self._errors)] if len(self._arms) > 1 else []
        factors += [("path error", self._path)] if self.shown.path is not None else []
        texts = (f"{name} **×{FACTORS[int(slider.value)]}**" for name, slider in factors)
        self._factors_text.content = f"Drawn larger than it is: {', '.join(texts)}."

    def _place(self) -> None:
        beside = len(self._arms) > 1 and self._beside.value
        for index, arm in enumerate(self._arms):
            arm.frame.position = (index * self._spacing * beside, 0.0, 0.0)
            arm.label.position = (float(self._low[0]), 0.0, float(self._high[2]) + 0.12 * self._extent)
            arm.label.visible = len(self._arms) > 1

    def _seek(self) -> None:
        """Show the instant that the reader has chosen."""
        self._playing.value = False
        self.show(int(np.searchsorted(self._time, self._slider.value)))
        self._mark()

    def _mark(self) -> None:
        for handle, plot in zip(self._plots, self.shown.plots, strict=True):
            handle.data = self._marked(plot)

    def _play(self) -> None:
        """Advance by the clock until the page is stopped."""
        now, last, pictures = float(self._time[0]), time.monotonic(), 0
        while not self._ended.wait(_REFRESH):
            passed, last = time.monotonic() - last, time.monotonic()
            if not self._playing.value or not self.server.get_clients():
                now = float(self._time[self.row])
                continue
            now += passed * SPEEDS[self._speed.value]
            if now > self._time[-1]:
                now = float(self._time[0])
            self.show(int(np.searchsorted(self._time, now)))
            pictures += 1
            if pictures % _PLOTS_EVERY == 0:
                self._slider.value = now
                self._mark()
