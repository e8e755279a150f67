"""Everything that reads what others wrote: one entry each, with what it is given and how it reads it."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import strategies as st
from mcap.records import Schema
from ruamel.yaml import YAML
from typer.testing import CliRunner

from flexros.cli.commands.run import key_and_value, node_parameters
from flexros.cli.options import parse_tolerance
from flexros.config.topics import QosProfile, read_qos, read_topics
from flexros.effects import parse_effect
from flexros.effects.patching.patched_robot import load_model
from flexros.errors import FlexrosError, InputError
from flexros.identify.frf.files.netcdf import load_responses
from flexros.input_limits import LONGEST_SENTENCE
from flexros.logs.foreign.import_log import import_log
from flexros.logs.foreign.mapping import load_mapping
from flexros.logs.foreign.message_numbers import message_numbers
from flexros.logs.messages.diagnostic_array import DiagnosticArrayCodec
from flexros.logs.messages.foreign_definition import decoder
from flexros.logs.messages.joint_state import JointStateView, read_joint_state_layout
from flexros.logs.messages.joint_trajectory import read_joint_trajectory
from flexros.logs.messages.pose_stamped import read_pose_stamped_layout
from flexros.logs.reader import read_log
from flexros.logs.replay.controller_feed import controller_feed
from flexros.logs.replay.source import ReplaySource, read_remaps
from flexros.logs.stamps import stamp_of
from flexros.logs.time_series import Log
from flexros.monitor.calibration import read_calibration
from flexros.robot import load_robot
from flexros.robot.exchange.urdf.robot_import import robot_from_urdf
from flexros.scenario.scenario import load_scenario
from flexros.validation.blind.seal import read_case
from flexros_nodes.bringup.launch_plan import plan_launch, run_arguments
from flexros_nodes.protocol.experiment_state import read_experiment_state
from flexros_nodes.protocol.loop.command_reader import CommandReader
from flexros_nodes.protocol.parameters import read_parameters
from flexros_nodes.protocol.recorder.recording import EventRecording, TopicRecording
from flexros_nodes.protocol.reference.reference_buffer import ReferenceBuffer
from tests.fuzz import samples
from tests.fuzz.damage import as_text, changed, damaged, lines, yaml_texts


@dataclass(frozen=True)
class Reader:
    """One thing that reads.

    Attributes:
        what: What it reads, for the page of results.
        inputs: What it is given.
        read: Reads an input; anything but a FlexrosError is a fault.
    """

    what: str
    inputs: st.SearchStrategy[bytes]
    read: Callable[[bytes], None]


@contextmanager
def folder_with(**files: bytes) -> Iterator[Path]:
    """A folder with files, dots in their names written as __."""
    with tempfile.TemporaryDirectory(prefix="flexros_fuzz_") as folder:
        for name, content in files.items():
            (Path(folder) / name.replace("__", ".")).write_bytes(content)
        yield Path(folder)


def outcome(reader: Reader, data: bytes) -> str:
    """Read an input; "read" or "refused".

    Raises:
        Exception: The reader has a fault.
    """
    try:
        reader.read(data)
    except FlexrosError as error:
        text = str(error)
        assert text.strip(), "a refusal says why"
        assert text.isprintable(), f"a refusal is one line of text: {text!r}"
        assert len(text) <= LONGEST_SENTENCE, f"a refusal has {len(text)} characters: {text[:200]}..."
        return "refused"
    return "read"


def check_log(log: Log) -> None:
    """Invariants of every log that was read."""
    for name in ("joint_states", "joint_commands", "joint_reference", "tool_pose", "tool_reference"):
        series = getattr(log, name)
        if series is not None:
            assert len(series.stamp), name
            assert np.all(series.stamp[1:] > series.stamp[:-1]), name
            assert series.received is None or len(series.received) == len(series.stamp)
    assert len(set(log.joint_states.names)) == len(log.joint_states.names)
    assert all(text.isprintable() and len(text) <= LONGEST_SENTENCE for text in log.warnings), log.warnings
    assert len(log.warnings) < 100


def _log(data: bytes) -> None:
    with folder_with(a__mcap=data) as folder:
        check_log(read_log(folder / "a.mcap"))


def _beside(name: str) -> Callable[[bytes], None]:
    """Read a log in which one file other than the messages is the input."""

    def read(data: bytes) -> None:
        with tempfile.TemporaryDirectory(prefix="flexros_fuzz_") as folder:
            for file, content in {**samples.own_bag(), name: data}.items():
                (Path(folder) / file).write_bytes(content)
            check_log(read_log(folder))

    return read


def _replay(data: bytes) -> None:
    with folder_with(a__mcap=data) as folder:
        source = ReplaySource(folder / "a.mcap")
        times = [message.log_time for message in source.messages()]
        assert times == sorted(times)
        assert all(source.window.first <= time <= source.window.last for time in times)


def _feed(data: bytes) -> None:
    with folder_with(a__mcap=data) as folder:
        for chunk in controller_feed(folder / "a.mcap").chunks:
            read_joint_trajectory(chunk.payload)


def _imported(suffix: str, mapping: Mapping[str, Any]) -> Callable[[bytes], None]:
    def read(data: bytes) -> None:
        with folder_with(**{f"a__{suffix}": data, "m__yaml": as_text(mapping)}) as folder:
            check_log(import_log(load_mapping(folder / "m.yaml"), [folder / f"a.{suffix}"]))

    return read


def _file(suffix: str, load: Callable[[Path], object]) -> Callable[[bytes], None]:
    def read(data: bytes) -> None:
        with folder_with(**{f"a__{suffix}": data}) as folder:
            load(folder / f"a.{suffix}")

    return read


def _case(path: Path) -> None:
    (path.parent / "case.json").write_bytes(path.read_bytes())
    read_case(path.parent)


def _line(read: Callable[[str], object]) -> Callable[[bytes], None]:
    return lambda data: void(read(data.decode(errors="replace")))


def void(_: object) -> None:
    """Drop a result."""


def _definition(data: bytes) -> None:
    """Read a definition, then messages by it: zeros, ones and a count of 4 G in every place."""
    name, encoding, text = data.split(b"\n", 2) if data.count(b"\n") >= 2 else (b"x/msg/X", b"ros2msg", data)
    decode = decoder(
        Schema(id=1, data=text, encoding=encoding.decode(errors="replace"), name=name.decode(errors="replace")),
        "a.mcap",
    )
    for payload in (bytes(4) + bytes(64), b"\0\1\0\0" + b"\1\0\0\0" * 16, b"\0\1\0\0" + b"\xff" * 64, b"\0\1\0\0", b""):
        try:
            message_numbers(decode(payload))
        except FlexrosError:
            continue


def _joint_state(data: bytes) -> None:
    read_joint_state_layout(data)
    sample = JointStateView(samples.NAMES).unpack(data)
    assert all(values is None or len(values) == 2 for values in sample[1:])


def _command(data: bytes) -> None:
    assert np.isfinite(CommandReader(samples.NAMES).read(data, 5)).all()


def _trajectory(data: bytes) -> None:
    chunk = read_joint_trajectory(data).in_order(samples.NAMES)
    for take in ("append", "replace"):
        buffer = ReferenceBuffer(2, 5e-4)
        try:
            getattr(buffer, take)(chunk)
        except FlexrosError:
            continue
        for stamp in (10**9, 10**9 + 500_000, 2 * 10**9):
            row = buffer.take(stamp)
            assert row is None or row.shape == (6,)


class _Sink:
    """Takes what a log can hold."""

    def write(self, topic_id: int, log_time_ns: int, publish_time_ns: int, payload: bytes) -> None:
        assert 0 <= log_time_ns < 2**64
        assert 0 <= publish_time_ns < 2**64


def _recorded(data: bytes) -> None:
    for recording in (TopicRecording(_Sink(), 1), EventRecording(_Sink(), 1), EventRecording(_Sink(), 1, lambda: 5)):
        recording.take(data)


def _launch(data: bytes) -> None:
    given = {name: argument.default for name, argument in run_arguments(["two_mass_step"]).items()}
    parts = data.decode(errors="replace").split(";")
    given |= dict(zip(("effects", "seed", "namespace", "remappings", "robot", "scenario"), parts, strict=False))
    given["record"] = "false"
    scratch = Path(tempfile.mkdtemp(prefix="flexros_fuzz_"))
    try:
        plan_launch(given, scratch)
    finally:
        shutil.rmtree(scratch)


@cache
def load_qos() -> dict[str, QosProfile]:
    """Quality of service that topics may name."""
    return read_qos(samples.CHECKOUT / "msgs_config" / "qos.yaml")


def _command_line(*words: str) -> Callable[[bytes], None]:
    """Run a command on the input; exit code 70 is a fault, and one that refuses leaves no result behind."""

    def read(data: bytes) -> None:
        from flexros.cli.app import app

        with folder_with(a__mcap=data, a__csv=data, m__yaml=as_text(samples.MAPPING)) as folder:
            given = [word.replace("DIR", str(folder)) for word in words]
            ended = CliRunner().invoke(app, given)
            assert ended.exit_code in (0, 2), ended.output
            if ended.exit_code == 2:
                assert sorted(path.name for path in folder.iterdir()) == ["a.csv", "a.mcap", "m.yaml"]
                raise InputError(ended.stderr.strip().removeprefix("flexros: "))

    return read


def _robot(path: Path) -> None:
    robot = load_robot(path)
    assert len(robot.home) == robot.n_arm


_topics, _qos = (YAML(typ="safe").load(samples.CHECKOUT / "msgs_config" / name) for name in ("topics.yaml", "qos.yaml"))
_topics = dict(list(_topics.items())[:4])
_robots = [
    tree for tree in samples.trees_of("flexros/robot/library") if tree["name"] in ("two_mass", "four_mass", "e12")
]
_scenarios = samples.trees_of("flexros/scenario/library")
_mcap = st.deferred(lambda: damaged([samples.own_mcap(), samples.foreign_bag()]) | samples.reassembled())
_definitions = [f"{name}\n{encoding}\n{text}".encode() for name, encoding, text in samples.DEFINITIONS]
_state = json.dumps(samples.EXPERIMENT_STATE)
_parameters = YAML(typ="safe").load(samples.CHECKOUT / "msgs_config" / "recorder.yaml")
_states = changed([samples.EXPERIMENT_STATE]).map(lambda tree: samples.text_message(json.dumps(tree)))
_calibration = {
    "schema_version": 1,
    "model": "abc",
    "robot": "two_mass",
    "log": "a",
    "time": 5.0,
    "accepted": {"motor_1": 1.0},
    "growth": {f"motor_1.{signal}": [0.0, 0.0, 0.0] for signal in ("sudden", "torque")},
    "tails": {f"motor_1.{signal}": [None, None, None] for signal in ("sudden", "torque")},
}
_case_tree = {"name": "case_1", "robot": "e12", "logs": ["a", "b"], "seal": "0" * 64}


def _trees(*trees: Any) -> st.SearchStrategy[bytes]:
    """Changed trees as text, damaged texts and texts that are nearly YAML."""
    return changed(trees).map(as_text) | damaged([as_text(tree) for tree in trees]) | yaml_texts


def _options(*texts: str) -> st.SearchStrategy[bytes]:
    return damaged([text.encode() for text in texts]) | lines


READERS: dict[str, Reader] = {
    "log": Reader("log in MCAP", _mcap, _log),
    "metadata": Reader(
        "metadata.yaml of a log",
        st.deferred(lambda: damaged([samples.own_bag()[samples.METADATA]])) | yaml_texts,
        _beside(samples.METADATA),
    ),
    "provenance": Reader(
        "provenance.json of a log",
        st.deferred(lambda: _trees(json.loads(samples.own_bag()[samples.PROVENANCE]))),
        _beside(samples.PROVENANCE),
    ),
    "replay": Reader("log to be replayed", _mcap, _replay),
    "feed": Reader("log to feed a controller", _mcap, _feed),
    "bag": Reader("bag of another robot, by a mapping", _mcap, _imported("mcap", samples.BAG_MAPPING)),
    "definition": Reader("message definition in a log, with messages", damaged(_definitions), _definition),
    "csv": Reader("CSV table", damaged([samples.csv_table()]), _imported("csv", samples.MAPPING)),
    "matlab": Reader(
        "MATLAB file, versions 4 to 7",
        damaged([samples.matlab_file(), samples.matlab_file(compressed=False), samples.matlab_file("4")]),
        _imported("mat", samples.MAPPING),
    ),
    "hdf5": Reader("MATLAB file, version 7.3", damaged([samples.hdf5_file()]), _imported("mat", samples.MAPPING)),
    "numpy": Reader(
        "NumPy archive", damaged([samples.npz_archive(), samples.npz_archive(False)]), _imported("npz", samples.MAPPING)
    ),
    "mapping": Reader("mapping file", _trees(samples.MAPPING, samples.BAG_MAPPING), _file("yaml", load_mapping)),
    "robot": Reader("robot file", _trees(*_robots), _file("yaml", _robot)),
    "scenario": Reader("scenario file", _trees(*_scenarios), _file("yaml", load_scenario)),
    "patch": Reader("patch of a robot", _trees(samples.PATCH), _file("yaml", load_model)),
    "parameters": Reader("parameter descriptions of a node", _trees(_parameters), _file("yaml", read_parameters)),
    "topics": Reader("topics", _trees(_topics), _file("yaml", lambda path: read_topics(path, load_qos()))),
    "qos": Reader("quality of service of topics", _trees(_qos), _file("yaml", read_qos)),
    "urdf": Reader("URDF", damaged([samples.URDF]), _file("urdf", robot_from_urdf)),
    "responses": Reader(
        "frequency responses in netCDF",
        st.deferred(lambda: damaged([samples.netcdf_file()])),
        _file("nc", load_responses),
    ),
    "calibration": Reader(
        "calibration of the gap monitor",
        _trees(_calibration),
        _file("json", lambda path: read_calibration(path, "abc", ("motor_1",))),
    ),
    "case": Reader("case of a blind check in JSON", _trees(_case_tree), _file("json", _case)),
    "effect": Reader(
        "effect in words",
        _options("payload_error@tool:relative=0.05", "coulomb_friction@motor_1:level=12floors"),
        _line(lambda text: parse_effect(text, "--effect")),
    ),
    "tolerance": Reader("tolerances in words", _options("stiffness=0.03,inertia=0.03"), _line(parse_tolerance)),
    "setting": Reader(
        "setting KEY=VALUE",
        _options("disturbances.0.amplitude=5", "a=[1, {b: 2}]") | yaml_texts.map(b"a=".__add__),
        _line(lambda text: (key_and_value(text, "--set"), node_parameters([text]))),
    ),
    "set": Reader(
        "scenario with a setting",
        _options("disturbances.0.amplitude=5", "plant.values.a=2"),
        _line(lambda text: load_scenario("circle_pd").with_values(dict([key_and_value(text, "--set")]))),
    ),
    "remaps": Reader("new names of topics", _options("joint_states:=measured,a:=b"), _line(read_remaps)),
    "launch": Reader(
        "launch arguments", _options("payload_error@tool:relative=0.05;3;left;a:=b;e12;circle_pd"), _launch
    ),
    "joint_state": Reader(
        "JointState message",
        damaged(
            [
                samples.joint_state(position=(1, 2), effort=(3, 4)),
                samples.joint_state(names=("motor_2", "motor_1"), effort=(3, 4)),
            ]
        ),
        _joint_state,
    ),
    "command": Reader("JointState message as a command", damaged([samples.joint_state(effort=(3, 4))]), _command),
    "trajectory": Reader(
        "JointTrajectory message as a reference",
        damaged([samples.trajectory(), samples.trajectory(velocities=True, effort=True), samples.trajectory(0)]),
        _trajectory,
    ),
    "pose": Reader(
        "PoseStamped message",
        damaged([samples.pose()]),
        lambda data: void((stamp_of(data), read_pose_stamped_layout(data))),
    ),
    "diagnostics": Reader(
        "DiagnosticArray message",
        damaged([samples.diagnostics()]),
        lambda data: void([status.numbers() for status in DiagnosticArrayCodec().read(data)]),
    ),
    "experiment_state": Reader(
        "state of an experiment in a String message",
        damaged([samples.text_message(_state)]) | _states,
        lambda data: void(read_experiment_state(data).sentence()),
    ),
    "import": Reader(
        "flexros import",
        damaged([samples.csv_table()]),
        _command_line("import", "DIR/m.yaml", "DIR/a.csv", "--out", "DIR/log"),
    ),
    "analyze": Reader("flexros analyze", _mcap, _command_line("analyze", "DIR/a.mcap", "--report", "DIR/report.html")),
    "recorded": Reader("message to be recorded", damaged([samples.joint_state(), samples.diagnostics()]), _recorded),
}
"""All readers by a short name."""
