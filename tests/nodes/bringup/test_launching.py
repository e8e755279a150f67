"""Launch files; without a full ROS 2 with stand-ins for launch, and nodes started as launch would."""

from __future__ import annotations

import ast
import json
import os
import re
import runpy
import shutil
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from flexros.errors import InputError
from flexros.logs.reader import read_log
from flexros.scenario.closed_loop import closed_loop
from flexros.scenario.experiment import Experiment
from flexros.scenario.scenario import load_scenario, scenario_names
from flexros_nodes.bringup.launch_plan import COMMON_ARGUMENTS, RUN_ARGUMENTS
from flexros_nodes.bringup.run_plan import LEADERS, NODES
from flexros_nodes.protocol.parameters import check_value, node_parameters
from tests.nodes.bringup import launch_stand_in
from tests.nodes.bringup.launch_stand_in import (
    DeclareLaunchArgument,
    LaunchContext,
    LogInfo,
    Node,
    OpaqueFunction,
    Shutdown,
)

CHECKOUT = Path(__file__).parents[3]
FILES = {path.name.split(".")[0]: path for path in sorted((CHECKOUT / "nodes" / "launch").glob("*.launch.py"))}
ONE_ROBOT = sorted(set(FILES) - {"several_robots"})
needs_ros2 = pytest.mark.skipif(
    shutil.which("ros2") is None,
    reason="needs a full ROS 2: ros2cli, launch and launch_ros are not on PyPI; source a distribution or build them",
)


class Launch:
    """A launch file, included with arguments as `ros2 launch` does."""

    def __init__(self, name: str, **given: str) -> None:
        *self.arguments, start = runpy.run_path(str(FILES[name]))["generate_launch_description"]().initial_entities
        assert all(isinstance(argument, DeclareLaunchArgument) for argument in self.arguments)
        assert isinstance(start, OpaqueFunction)
        values = {argument.name: argument.default_value for argument in self.arguments}
        assert set(given) <= set(values)
        self.context = LaunchContext({**values, **given})
        self.tidy, *self.actions = start.execute(self.context)
        self.nodes: list[Node] = [action for action in self.actions if isinstance(action, Node)]

    def close(self) -> None:
        self.tidy.event_handler.on_shutdown(None, self.context)


@pytest.fixture(autouse=True)
def stand_in(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    launch_stand_in.put_in_place(monkeypatch)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))


def entry_points() -> tuple[str, ...]:
    """Names of the executables in setup.py."""
    assignments = [node for node in ast.parse((CHECKOUT / "setup.py").read_text()).body if isinstance(node, ast.Assign)]
    nodes = {getattr(node.targets[0], "id", ""): node.value for node in assignments}["NODES"]
    names: tuple[str, ...] = ast.literal_eval(nodes)
    return names


def short_scenario(folder: Path, name: str, built_in: str) -> str:
    file = folder / f"{name}.yaml"
    file.write_text(json.dumps(load_scenario(built_in).with_values({"duration": 0.05}).settings()))
    return str(file)


def test_there_is_a_launch_file_for_every_experiment() -> None:
    assert list(FILES) == [
        "circle_test",
        "closed_loop",
        "diagnosis",
        "identification",
        "joint_moves",
        "model_based_control",
        "regulator",
        "several_robots",
    ]
    named = {word for path in FILES.values() for word in re.findall(r'"(\w+)"', path.read_text())}
    assert named == set(scenario_names())


@pytest.mark.parametrize("name", ONE_ROBOT)
def test_launch_starts_nodes_that_exist_with_parameters_that_they_have(name: str) -> None:
    launch = Launch(name)
    assert [argument.name for argument in launch.arguments] == ["scenario", *RUN_ARGUMENTS, *COMMON_ARGUMENTS]
    assert all(argument.description for argument in launch.arguments)
    scenario = load_scenario(launch.context.launch_configurations["scenario"])
    leader = "feedforward" if scenario.identification is None else "identification"
    assert [node.name for node in launch.nodes] == [node for node in NODES if node == leader or node not in LEADERS]
    for node in launch.nodes:
        assert (node.package, node.executable, node.namespace) == ("flexros", node.name, None)
        assert node.executable in entry_points()
        for key, value in node.own_parameters().items():
            check_value(node.executable, key, value, node_parameters(node.executable))


def test_arguments_reach_the_nodes(tmp_path: Path) -> None:
    parameters = tmp_path / "p.yaml"
    parameters.write_text("/**: {ros__parameters: {}}")
    launch = Launch(
        "closed_loop",
        scenario="circle_dae",
        robot="e12",
        seed="7",
        effects="coulomb_friction@motor_1:level=150 payload_error@tool:relative=0.05",
        realtime="true",
        out=str(tmp_path / "log"),
        params_file="p.yaml",
        remappings="joint_states:=states joint_commands:=/torques",
        namespace="/cell/arm/",
    )
    nodes = {node.name: node for node in launch.nodes}
    for node in launch.nodes:
        assert node.namespace == "cell/arm"
        assert node.remappings == [("/clock", "clock"), ("joint_states", "states"), ("joint_commands", "/torques")]
        assert list(node.parameters or ())[1:] == [str(parameters)]
        scenario = load_scenario(node.own_parameters()["scenario"])
        assert (scenario.seed, scenario.robot) == (7, "e12")
        assert scenario.plant.effects[0] == "coulomb_friction@motor_1:level=150"
    recorder = nodes["recorder"].own_parameters()
    assert recorder["folder"] == str(tmp_path / "log")
    assert (recorder["real_time"], recorder["niceness"]) == (True, 10)
    assert nodes["plant"].own_parameters()["real_time"] is True
    assert [action.msg for action in launch.actions if isinstance(action, LogInfo)] == [f"log: {tmp_path / 'log'}"]
    launch.close()
    assert not Path(nodes["plant"].own_parameters()["scenario"]).exists()


def test_nothing_is_recorded_where_that_is_wanted() -> None:
    launch = Launch("regulator", record="false")
    assert "recorder" not in [node.name for node in launch.nodes]
    assert all(node.own_parameters()["observers"] == 0 for node in launch.nodes)


def test_a_log_without_a_name_gets_one_of_the_scenario(tmp_path: Path) -> None:
    folder = Path(Launch("circle_test").nodes[0].own_parameters()["folder"])
    assert folder.parent == tmp_path / "bags"
    assert folder.name.startswith("circle_dae_")


def test_gap_monitor_starts_with_a_given_model(tmp_path: Path) -> None:
    model = tmp_path / "model.yaml"
    shutil.copy(CHECKOUT / "flexros" / "robot" / "library" / "two_mass.yaml", model)
    launch = Launch("regulator", scenario="two_mass_step", monitor="model.yaml")
    *others, monitor = launch.nodes
    assert {node.executable for node in others} == {"plant", "controller", "feedforward", "recorder"}
    assert monitor.executable == "gap_monitor"
    assert monitor.own_parameters() == {"model": str(model)}
    assert monitor.on_exit is None
    with pytest.raises(InputError, match="nothing_like_it"):
        Launch("regulator", scenario="two_mass_step", monitor="nothing_like_it")


def test_identification_may_wait_for_its_service(identification_scenario: Path) -> None:
    launch = Launch("identification", scenario=str(identification_scenario), begin_at_once="false")
    assert launch.nodes[1].name == "identification"
    own = launch.nodes[1].own_parameters()
    assert own.pop("run")
    assert own == {"scenario": str(identification_scenario), "begin_at_once": False}


def test_the_launch_ends_with_the_last_plant(tmp_path: Path) -> None:
    launch = Launch("several_robots", robots="left=circle_dae, right=two_mass_step", out=str(tmp_path / "logs"))
    assert [node.namespace for node in launch.nodes] == ["left"] * 4 + ["right"] * 4
    assert all(node.remappings == [("/clock", "clock")] for node in launch.nodes)
    folders = [node.own_parameters()["folder"] for node in launch.nodes if node.name == "recorder"]
    assert folders == [str(tmp_path / "logs" / side) for side in ("left", "right")]
    runs = [node.own_parameters()["run"] for node in launch.nodes]
    assert len(set(runs[:4])) == len(set(runs[4:])) == 1 != len(set(runs))  # each robot is a run of its own
    left, right = (node for node in launch.nodes if node.on_exit)
    assert (left.name, right.name) == ("plant", "plant")
    assert left.ended(launch.context) == []
    assert [type(action) for action in right.ended(launch.context)] == [Shutdown]


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("closed_loop", {"scenario": "circl_pd"}, "unknown scenario 'circl_pd': did you mean 'circle_pd'"),
        ("closed_loop", {"robot": "e13"}, "unknown robot 'e13': did you mean 'e12'"),
        ("closed_loop", {"seed": "two"}, "seed is 'two', but must be a whole number, e.g. 2"),
        ("closed_loop", {"effects": "friction"}, "launch arguments: key 'plant.effects"),
        ("closed_loop", {"namespace": "a b"}, "namespace is 'a b', but must be letters, digits and _ between slashes"),
        ("closed_loop", {"remappings": "a b"}, "remappings is 'a b', but must be FROM:=TO separated by spaces"),
        ("closed_loop", {"params_file": "no.yaml"}, "params_file is 'no.yaml', but there is no such file; give the"),
        ("closed_loop", {"out": "."}, r"the log folder .* exists already; choose another one with out:=FOLDER"),
        ("several_robots", {"robots": "left"}, "robots is 'left', but must be NAMESPACE=SCENARIO separated by commas"),
        ("several_robots", {"robots": "a=circle_pd, a=circle_pd"}, "each once; e.g. left=circle_dae, right=circle_pd"),
    ],
)
def test_what_cannot_be_is_said_before_anything_starts(name: str, given: dict[str, str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Launch(name, **given)


def started(node: Node) -> subprocess.Popen[bytes]:
    """Start a node as launch_ros does, by our own executables."""
    arguments = ["-r", f"__node:={node.name}"]
    arguments += ["-r", f"__ns:=/{node.namespace}"] if node.namespace else []
    for origin, target in node.remappings or ():
        arguments += ["-r", f"{origin}:={target}"]
    for name, value in node.own_parameters().items():
        arguments += ["-p", f"{name}:={str(value).lower() if isinstance(value, bool) else value}"]
    command = [sys.executable, "-m", f"flexros_nodes.{node.executable}", "--ros-args", *arguments]
    environment = {**os.environ, "PYTHONPATH": str(CHECKOUT)}
    with Path(f"{node.namespace}_{node.name}.said").open("w") as said:
        return subprocess.Popen(command, env=environment, stderr=said)


@pytest.mark.usefixtures("ros_domain")
def test_robots_side_by_side_do_not_hear_each_other(tmp_path: Path, log_differences: Any) -> None:
    """Two robots in one domain, one with topics of other names, give the samples that each of them gives alone."""
    robots = {
        side: short_scenario(tmp_path, side, name) for side, name in (("left", "circle_dae"), ("right", "circle_pd"))
    }
    given = ", ".join(f"{side}={file}" for side, file in robots.items())
    launch = Launch("several_robots", robots=given, out="logs", remappings="joint_commands:=torques")
    processes = [started(node) for node in launch.nodes]
    plants = [process for node, process in zip(launch.nodes, processes) if node.name == "plant"]
    try:
        for plant in plants:
            plant.wait(60)
    finally:
        for process in processes:
            process.send_signal(signal.SIGINT)
        ends = [(process.args[2], process.wait(20)) for process in processes]
    said = "\n".join(path.read_text() for path in tmp_path.glob("*.said"))
    assert {code for _, code in ends} == {0}, f"{ends}\n{said}"
    for side, file in robots.items():
        run = read_log(tmp_path / "logs" / side)
        alone = closed_loop(Experiment.prepare(load_scenario(file)))
        # where discovery takes seconds, the loop does not wait for the first samples of partners
        partners = {"joint_commands", "joint_reference", "tool_reference"}
        assert {name.split(".")[0] for name in log_differences(run, alone)} <= partners
        assert np.isin(run.joint_commands.stamp, alone.joint_commands.stamp).all()
        recorded = np.isin(alone.joint_commands.stamp, run.joint_commands.stamp)
        np.testing.assert_array_equal(run.joint_commands.effort, alone.joint_commands.effort[recorded])


@needs_ros2
@pytest.mark.parametrize("name", FILES)
def test_ros2_launch_shows_the_arguments(name: str) -> None:
    command = ["ros2", "launch", str(FILES[name]), "--show-args"]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "'realtime'" in run.stdout


def needs_flexros_in_workspace() -> None:
    found = subprocess.run(["ros2", "pkg", "prefix", "flexros"], capture_output=True, text=True, check=False)
    if found.returncode:
        pytest.skip("needs flexros in a sourced workspace: ros2 pkg prefix flexros finds none")


@needs_ros2
@pytest.mark.parametrize("name", entry_points())
def test_ros2_run_finds_the_node(name: str) -> None:
    needs_flexros_in_workspace()
    nothing = [word for what in ("scenario", "model", "bag") for word in ("-p", f"{what}:=none")]
    command = ["ros2", "run", "flexros", name, "--ros-args", *nothing]
    run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert run.returncode == 2
    assert "'none'" in run.stderr or "at none" in run.stderr


@needs_ros2
@pytest.mark.usefixtures("ros_domain")
def test_ros2_run_runs_the_loop(tmp_path: Path) -> None:
    needs_flexros_in_workspace()
    scenario = short_scenario(tmp_path, "short", "circle_dae")
    own = {"recorder": ["-p", f"folder:={tmp_path / 'log'}"]}
    nodes = {}
    for name in ("controller", "feedforward", "recorder", "plant"):
        command = ["ros2", "run", "flexros", name, "--ros-args", "-p", f"scenario:={scenario}", *own.get(name, [])]
        nodes[name] = subprocess.Popen(command, start_new_session=True)
    try:
        assert nodes["plant"].wait(60) == 0
    finally:
        for node in nodes.values():
            if node.poll() is None:
                os.killpg(node.pid, signal.SIGINT)  # ros2 run and the node that it has started
        for node in nodes.values():
            node.wait(30)
    assert len(read_log(tmp_path / "log").joint_states.stamp) == 101


@needs_ros2
def test_ros2_bag_reads_the_log() -> None:
    sample = Path(__file__).parents[3] / "bags" / "sample_circle_dae"
    run = subprocess.run(["ros2", "bag", "info", str(sample)], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "/joint_states" in run.stdout


@needs_ros2
@pytest.mark.usefixtures("ros_domain")
def test_ros2_launch_runs_and_records(tmp_path: Path) -> None:
    needs_flexros_in_workspace()
    scenario = short_scenario(tmp_path, "short", "circle_dae")
    command = ["ros2", "launch", "flexros", "closed_loop.launch.py", f"scenario:={scenario}", "out:=log"]
    subprocess.run(command, check=True, timeout=120)
    assert len(read_log(tmp_path / "log").joint_states.stamp) == 101
