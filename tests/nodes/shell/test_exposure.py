"""Network exposure of a run: settings, and the sockets that processes open."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import psutil  # type: ignore[import-untyped]
import pytest

from flexros.errors import InputError, RunError
from flexros_nodes.shell.exposure import CHOICES, PROFILE, check_exposure, exposure_settings

CHECKOUT = Path(__file__).parents[3]
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SYSTEM_DEFAULT", "FASTRTPS_DEFAULT_PROFILES_FILE": str(PROFILE)}
DOMAIN_5 = 7400 + 250 * 5
COMMAND = "from flexros.cli import main; raise SystemExit(main())"
LEAVING = 0.2
"""Time for which a process sees that a partner has left before it is ended itself [s], see `shell.removal`."""


@pytest.mark.parametrize("given", [{}, {"ROS_DOMAIN_ID": "17"}, {"RMW_IMPLEMENTATION": "rmw_fastrtps_cpp"}])
def test_run_stays_on_this_machine(given: dict[str, str]) -> None:
    assert exposure_settings(given, network=False) == LOCAL


def test_other_middleware_has_discovery_on_this_machine() -> None:
    settings = exposure_settings({"RMW_IMPLEMENTATION": "rmw_cyclonedds_cpp"}, network=False)
    assert settings == {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}


@pytest.mark.parametrize("variable", CHOICES)
def test_what_the_user_has_set_stays(variable: str) -> None:
    assert exposure_settings({variable: "anything"}, network=False) == {}
    assert exposure_settings({variable: "anything"}, network=True) == {}


def test_network_is_asked_for() -> None:
    assert exposure_settings({}, network=True) == {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET"}


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST"),
        ("ROS_AUTOMATIC_DISCOVERY_RANGE", "off"),
        ("ROS_LOCALHOST_ONLY", "1"),
    ],
)
def test_network_that_the_environment_forbids_is_bad_input(variable: str, value: str) -> None:
    with pytest.raises(InputError, match=f"requested, but {variable} is '{value}'; unset the variable"):
        exposure_settings({variable: value}, network=True)


def process_with(folder: Path, address: str, port: int) -> Path:
    """Make what the system shows of a process with one UDP socket."""
    (folder / "fd").mkdir()
    (folder / "fd" / "3").symlink_to("socket:[4711]")
    (folder / "net").mkdir()
    row = f"  1: {address}:{port:04X} 00000000:0000 07 00000000:00000000 00:00000000 00000000 0 0 4711 2 0000 0"
    (folder / "net" / "udp").write_text(f"  sl  local_address rem_address\n{row}\n")
    return folder


def test_open_socket_of_the_domain_is_reported(tmp_path: Path) -> None:
    process = process_with(tmp_path, "00000000", DOMAIN_5 + 10)
    with pytest.raises(RunError, match="has used ROS 2 before with sockets open to the network"):
        check_exposure(LOCAL, 5, process)
    check_exposure({}, 5, process)  # whoever did not ask for the profile may be open


@pytest.mark.parametrize(("address", "port"), [("0100007F", DOMAIN_5 + 10), ("00000000", DOMAIN_5 + 250)])
def test_bound_socket_and_foreign_socket_are_accepted(tmp_path: Path, address: str, port: int) -> None:
    check_exposure(LOCAL, 5, process_with(tmp_path, address, port))


def test_system_without_proc_is_not_checked(tmp_path: Path) -> None:
    check_exposure(LOCAL, 5, tmp_path / "nowhere")


# The sockets themselves.


@contextmanager
def started(*arguments: str, **settings: str) -> Iterator[psutil.Process]:
    """Start a Python process as from a shell without middleware settings, in addition to those given."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "RMW_", "FAST"))}
    environment |= {"PYTHONPATH": str(CHECKOUT), **settings}
    command = [sys.executable, *arguments]
    with subprocess.Popen(
        command, cwd=CHECKOUT, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    ) as process:
        try:
            yield psutil.Process(process.pid)
        finally:
            time.sleep(LEAVING)
            process.terminate()
            try:
                process.wait(30.0)
            except subprocess.TimeoutExpired:
                process.kill()
                if COMMAND in arguments:  # what rclpy does by itself is not in our hands
                    raise


def addresses(process: psutil.Process, n_processes: int) -> set[str]:
    """Give the addresses that a process and its children are bound to, once all of them have sockets of DDS."""
    deadline = time.monotonic() + 40.0
    while time.monotonic() < deadline:
        found = []
        with suppress(psutil.NoSuchProcess):
            for one in (process, *process.children(recursive=True)):
                bound = [row.laddr.ip for row in one.net_connections("inet") if row.laddr.port >= 7400]
                found += [set(bound)] if len(bound) >= 3 else []  # for discovery, for data, for sending
        if len(found) == n_processes:
            return set().union(*found)
        time.sleep(0.05)
    raise AssertionError(f"{len(found)} of {n_processes} processes have opened sockets")


@pytest.mark.usefixtures("ros_domain")
@pytest.mark.parametrize(("layout", "n_processes"), [("composed", 1), ("processes", 5)])
def test_run_is_bound_to_this_machine(layout: str, n_processes: int, tmp_path: Path, long_scenario: Path) -> None:
    arguments = ("run", str(long_scenario), "--realtime", "--layout", layout, "--out", str(tmp_path / "log"))
    with started("-c", COMMAND, *arguments) as process:
        assert addresses(process, n_processes) == {"127.0.0.1"}


@pytest.mark.usefixtures("ros_domain")
def test_run_on_the_network_is_open(tmp_path: Path, long_scenario: Path) -> None:
    arguments = ("run", str(long_scenario), "--realtime", "--network", "--out", str(tmp_path / "log"))
    with started("-c", COMMAND, *arguments) as process:
        assert "0.0.0.0" in addresses(process, 1)


@pytest.mark.parametrize(
    "settings", [{}, {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}], ids=["nothing set", "LOCALHOST"]
)
def test_node_by_itself_keeps_the_middleware_as_the_user_has_it(ros_domain: int, settings: dict[str, str]) -> None:
    with started("-m", "flexros_nodes.plant", ROS_DOMAIN_ID=str(ros_domain), **settings) as process:
        assert "0.0.0.0" in addresses(process, 1)


def test_node_of_the_user_finds_a_run_that_is_bound(ros_domain: int, tmp_path: Path, long_scenario: Path) -> None:
    listener = (
        "import rclpy; from sensor_msgs.msg import JointState; rclpy.init(); node = rclpy.create_node('mine')\n"
        "got = []; node.create_subscription(JointState, 'joint_states', got.append, 10);\n"
        "for _ in range(400):\n    rclpy.spin_once(node, timeout_sec=0.1)\n"
        "    if got: raise SystemExit(0)\nraise SystemExit(1)"
    )
    domain = {"ROS_DOMAIN_ID": str(ros_domain)}
    arguments = ("run", str(long_scenario), "--realtime", "--out", str(tmp_path / "log"))
    with started("-c", listener, **domain) as listening, started("-c", COMMAND, *arguments, **domain):
        assert listening.wait(60.0) == 0


def test_messages_of_a_run_are_confirmed_soon(ros_domain: int) -> None:
    """Fast DDS by itself waits for 3 s, or for hundreds of messages, and then removes all of them at once."""
    reader = (
        "import rclpy; from std_msgs.msg import Header; rclpy.init(); node = rclpy.create_node('reader')\n"
        "node.create_subscription(Header, 'words', lambda _: None, 10); rclpy.spin(node)"
    )
    writer = (
        "import time, rclpy; from rclpy.duration import Duration; from std_msgs.msg import Header; rclpy.init()\n"
        "writer = rclpy.create_node('writer').create_publisher(Header, 'words', 10)\n"
        "while not writer.get_subscription_count(): time.sleep(0.01)\n"
        "for _ in range(5):\n    writer.publish(Header())\n"
        "    if not writer.wait_for_all_acked(Duration(seconds=1)): raise SystemExit(1)"
    )
    settings = {**LOCAL, "ROS_DOMAIN_ID": str(ros_domain)}
    with started("-c", reader, **settings), started("-c", writer, **settings) as writing:
        assert writing.wait(60.0) == 0


def test_process_that_was_open_before_is_refused(ros_domain: int) -> None:
    code = (
        "import json, rclpy; rclpy.init(); node = rclpy.create_node('earlier')\n"
        "from flexros.errors import RunError\nfrom flexros_nodes.bringup.run import run_scenario\n"
        "try: run_scenario('circle_dae', None)\nexcept RunError as error: print(json.dumps(str(error)))"
    )
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("ROS_", "RMW_", "FAST"))}
    environment |= {"PYTHONPATH": str(CHECKOUT), "ROS_DOMAIN_ID": str(ros_domain)}
    output = subprocess.check_output([sys.executable, "-c", code], env=environment, text=True)
    assert json.loads(output).endswith("start the run in a process of its own, or request network access")
