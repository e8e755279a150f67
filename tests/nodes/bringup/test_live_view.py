from __future__ import annotations

import contextlib
import importlib.util
import os
import socket
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.robot import load_robot
from flexros.robot.arm_view import ArmView
from flexros.robot.body_placement import BodyPlacements
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf
from tests.browser import opened_browser, wait
from tests.program import CHECKOUT


class Page:
    """Stands for the page in the browser."""

    def __init__(self) -> None:
        self.motors: list[tuple[float, list[str], list[float]]] = []
        self.bars: list[tuple[np.ndarray, np.ndarray]] = []

    def take_motors(self, stamp: float, names: Any, positions: Any) -> None:
        self.motors.append((stamp, list(names), list(positions)))

    def take_bars(self, true: np.ndarray, stiff: np.ndarray) -> None:
        self.bars.append((true, stiff))


def test_topics_reach_the_page(ros_domain: int) -> None:
    import rclpy
    from rclpy.context import Context
    from sensor_msgs.msg import JointState

    from flexros_nodes.bringup.live_view import view_topics
    from flexros_nodes.plant.arm_markers import ArmMarkers

    robot, page, end = load_robot("e12"), Page(), threading.Event()
    state = robot.equilibrium(np.array([0.1, 0.2, 0.01]))
    thread = threading.Thread(target=lambda: view_topics(page, namespace="cell", ended=end.is_set))  # type: ignore[arg-type]
    thread.start()
    context = Context()
    rclpy.init(context=context, args=[])
    node = rclpy.create_node("source", context=context, namespace="cell")
    try:
        from visualization_msgs.msg import MarkerArray

        states = node.create_publisher(JointState, "joint_states", 5)
        markers = node.create_publisher(MarkerArray, "arm_markers", 5)
        message = JointState(name=["motor_1", "motor_2"], position=[0.3, 0.4])
        message.header.stamp.sec = 2
        shown = ArmMarkers(robot).fill(2_000_000_000, state, 1.0)

        def arrived() -> bool:
            states.publish(message)
            markers.publish(shown)
            return bool(page.motors and page.bars)

        wait(arrived, 30, "the topics")
    finally:
        end.set()
        thread.join(10)
        node.destroy_node()
        rclpy.try_shutdown(context=context)
    assert page.motors[0] == (2.0, ["motor_1", "motor_2"], [0.3, 0.4])
    np.testing.assert_allclose(page.bars[0][0], ArmView(robot).bars(state, 1.0).true)


@pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="needs viser: pip install 'flexros[view]'")
def test_page_draws_magnified_bars_or_stiff_motors() -> None:
    from flexros.view.live import LivePage

    robot = load_robot("e12")
    page = LivePage(robot, port=18460)
    try:
        page.take_motors(1.0, ["gripper", "motor_2", "motor_1"], [9.0, 0.4, 0.3])
        wait(lambda: page.drawn is not None, 10, "the first picture")
        expected = ArmView(robot).at(np.array([robot.arm_from_gears(np.array([0.3, 0.4]))]))[0]
        np.testing.assert_allclose(page.drawn, expected)
        stiff = expected
        true = stiff + 0.001
        page.take_bars(true, stiff)
        wait(lambda: abs(float(page.drawn[0, 0, 0] - stiff[0, 0, 0]) - 0.01) < 1e-9, 10, "the deflection x 10")
    finally:
        page.stop()


@pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="needs viser: pip install 'flexros[view]'")
def test_links_stand_at_the_motors_and_are_a_shadow_beside_a_bent_arm(tmp_path: Path) -> None:
    from flexros.view.live import LivePage
    from flexros.view.scene import Links

    file = tmp_path / "ur5e.yaml"
    file.write_text(robot_from_urdf(CHECKOUT / "docs/examples/ur5e.urdf", folder=tmp_path).text)
    robot, q = load_robot(file), np.array([0.3, -1.0, 0.5, 0.1, 0.2, 0.4])
    page = LivePage(robot, port=18470)
    try:
        page.take_motors(1.0, robot.joint_names, q.tolist())
        wait(lambda: "/links" in page._links, 10, "the links")
        links = page._links["/links"]
        assert isinstance(links, Links)
        wait(lambda: links._meshes[-1][1].visible, 10, "the links to be placed")
        origins, _ = BodyPlacements(robot).at(np.array([robot.arm_from_gears(q)]))
        for body, mesh in links._meshes:
            np.testing.assert_allclose(mesh.position, origins[0, body] if body >= 0 else np.zeros(3), atol=1e-6)
        stiff = ArmView(robot).at(np.array([robot.arm_from_gears(q)]))[0]
        page.take_bars(stiff + 0.001, stiff)
        wait(lambda: "/shadow" in page._links, 10, "the shadow of the bent arm")
        wait(lambda: abs(float(page.drawn[0, 0, 0] - stiff[0, 0, 0]) - 0.01) < 1e-6, 10, "the deflection x 10")
    finally:
        page.stop()


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("viser") is None, reason="needs viser: pip install 'flexros[view]'")
def test_page_beside_a_run_shows_its_topics_and_ends_with_it(ros_domain: int) -> None:
    import rclpy
    from rclpy.context import Context
    from sensor_msgs.msg import JointState

    from flexros.cli.commands.view import PageBeside

    def refused(port: int) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", port)) != 0

    context = Context()
    with PageBeside("e12") as page, opened_browser() as browser:
        assert page.port is not None
        rclpy.init(context=context, args=[])
        node = rclpy.create_node("source", context=context)
        try:
            publisher = node.create_publisher(JointState, "joint_states", 5)
            message = JointState(name=["motor_1", "motor_2"], position=[0.3, 0.4])
            message.header.stamp.sec = 7
            browser.open(f"http://127.0.0.1:{page.port}")

            def shown() -> bool:
                publisher.publish(message)
                text = browser.value("document.body.innerText")
                return "7.00 s" in text and "e12, live" in text

            wait(shown, 60, "the stamp of the topics on the page")
        finally:
            node.destroy_node()
            rclpy.try_shutdown(context=context)
    wait(lambda: refused(page.port or 0), 10, "the page to end with the run")


def test_what_is_beside_a_run_is_in_its_domain_from_before_its_start_to_its_end(
    ros_domain: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from flexros_nodes.bringup.run import run_scenario

    monkeypatch.delenv("ROS_DOMAIN_ID")
    seen: list[str] = []

    @contextlib.contextmanager
    def beside() -> Iterator[None]:
        assert not (tmp_path / "log").exists()
        seen.append(os.environ["ROS_DOMAIN_ID"])
        yield
        assert (tmp_path / "log" / "provenance.json").is_file()

    summary = run_scenario("circle_fj", tmp_path / "log", beside=beside())
    assert summary.exit_code == 0, summary.message
    assert seen == [str(summary.domain_id)]
