"""The page of a robot: a slider for every motor, and its modes in motion."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from flexros.report.colours import FLOOR, REPAIRED
from flexros.robot.linear.linearise import linear_model
from flexros.view.page import FLOOR_BELOW, AbstractPage
from flexros.view.scene import GHOST, ArmLook

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.robot import Robot

STILL = "none"
AMPLITUDE = 0.06
"""Largest motion of a bar in a mode, relative to the arm (chosen)."""
PERIOD = 1.5
"""Time of one oscillation of a mode as drawn [s] (chosen)."""
STEPS = 60
"""Instants of one oscillation (chosen)."""
_SLOWEST = 0.05
"""Modes below this frequency are motions without a spring [Hz] (chosen)."""


def modes(robot: Robot, pose: FloatArray) -> list[tuple[float, FloatArray]]:
    """Return the oscillating modes of a robot at rest with free motors.

    Args:
        robot: The robot.
        pose: Arm coordinates [rad or m], shape (N,).

    Returns:
        Frequency [Hz] and arm coordinates of each, complex and of any size, shape (N,); increasing by frequency.
    """
    A, _, _, _ = linear_model(robot, pose).matrices()
    values, vectors = np.linalg.eig(A)
    found = [
        (float(abs(value) / (2 * np.pi)), vectors[: robot.n_arm, index])
        for index, value in enumerate(values)
        if value.imag > 2 * np.pi * _SLOWEST
    ]
    return sorted(found, key=lambda mode: mode[0])


class RobotPage(AbstractPage):
    """Shows a robot in the browser.

    Args:
        robot: The robot.
        host: Address the page listens on.
        port: Port; the next free one is taken where it is in use.

    Attributes:
        server: The viser page.

    Raises:
        InputError: viser is not installed.
    """

    def __init__(self, robot: Robot, *, host: str = "127.0.0.1", port: int = 8080) -> None:
        super().__init__(f"Robot {robot.name}", host, port)
        self.robot = robot
        self._look = ArmLook(robot)
        self._view = self._look.view
        gears = np.array(robot.home)[list(robot.gear_rows)]
        self._arm = self._look.made(self.server, f"/{robot.name}/arm", REPAIRED)
        self._still = self._look.made(self.server, f"/{robot.name}/still", FLOOR, GHOST)
        self._set_scene()
        gui = self.server.gui
        gui.add_markdown(" ".join(filter(None, (robot.spec.description, self._look.drawing.note))))
        self._motors = []
        for name, motor, value in zip(robot.joint_names, robot.motors, gears, strict=True):
            reach = np.pi if motor.rotary else 1.0
            slider = gui.add_slider(
                f"{name} [{motor.position_unit}]", min=float(value - reach), max=float(value + reach), step=0.001,
                initial_value=float(value),
            )  # fmt: skip
            slider.on_update(lambda _: self._pose())
            self._motors.append(slider)
        self._mode = gui.add_dropdown("Mode", (STILL,), initial_value=STILL)
        self._mode.on_update(lambda _: self._pose(new_modes=False))
        gui.add_markdown("Modes are those at this pose, with free motors; their size is chosen to be seen.")
        self._pose()
        self._move(self._play)

    def _set_scene(self) -> None:
        server = self.server
        ends = self._view.at(np.array([self.robot.home])).reshape(-1, 3)
        low, high = self._look.drawing.grown(ends.min(axis=0), ends.max(axis=0))
        self._extent = float(np.linalg.norm(high - low)) or 1.0
        size = 4.0 * self._extent
        server.scene.add_grid(
            "/floor", width=size, height=size, plane="xy", cell_size=size / 40, section_size=size / 8,
            position=(0.0, 0.0, min(float(low[2]), 0.0) - FLOOR_BELOW * self._extent),
        )  # fmt: skip
        look = 0.5 * (low + high)
        self._aim(look, np.array([0.5, -1.2, 0.5]) * self._extent)

    def _pose(self, new_modes: bool = True) -> None:
        """Take over the sliders: another pose, with its modes."""
        with self._lock:
            gears = np.array([slider.value for slider in self._motors])
            home = np.array(self.robot.arm_from_gears(gears), dtype=float)
            if new_modes:
                self._modes = modes(self.robot, home)
                names = tuple(f"{index}: {hz:.2f} Hz" for index, (hz, _) in enumerate(self._modes, start=1))
                chosen = self._mode.value.partition(":")[0]
                self._mode.options = (STILL, *names)
                self._mode.value = next((name for name in names if name.partition(":")[0] == chosen), STILL)
            number = 0 if self._mode.value == STILL else int(self._mode.value.partition(":")[0])
            arm = np.tile(home, (STEPS, 1))
            if number:
                arm = arm + self._oscillation(home, self._modes[number - 1][1])
            self._arm.move(arm)
            self._still.move(home[None] if number else np.full((1, len(home)), np.nan))
            with self.server.atomic():
                self._arm.show(0)
                self._still.show(0)

    def _oscillation(self, home: FloatArray, shape: FloatArray) -> FloatArray:
        """Return the arm coordinates of one oscillation about a pose, of a size that is seen, shape (STEPS, N)."""
        turn = np.exp(2j * np.pi * np.arange(STEPS) / STEPS)
        small = 1e-4 * np.real(turn[:, None] * shape / np.max(np.abs(shape)))
        moved = self._view.at(home + small) - self._view.at(home[None])
        size = float(np.max(np.linalg.norm(moved, axis=-1)))
        return np.asarray(small * AMPLITUDE * self._extent / max(size, 1e-12))

    def _play(self) -> None:
        while not self._ended.wait(PERIOD / STEPS):
            if self._mode.value != STILL and self.server.get_clients():
                with self._lock, self.server.atomic():
                    self._arm.show(int(time.monotonic() / PERIOD * STEPS) % STEPS)
