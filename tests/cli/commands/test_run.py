"""Commands that run and analyse, in this process; the same over topics is tested with the nodes."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from flexros.cli.commands.run import default_folder, print_result
from flexros.errors import RunError
from flexros.scenario.transports import RunResult

pytestmark = pytest.mark.slow

Flexros = Callable[..., "object"]


def test_run_and_analyze(flexros: Flexros, tmp_path: Path) -> None:
    bag, report = tmp_path / "bag", tmp_path / "report.html"
    ended = flexros("run", "circle_dae", "--transport", "direct", "--out", str(bag), "--json")
    assert ended.code == 0
    assert json.loads(ended.out)["samples"] == 762
    ended = flexros("analyze", str(bag), "--json", "--report", str(report))
    assert ended.code == 0
    content = json.loads(ended.out)
    assert content["path"]["path_error_m"]["max"] == pytest.approx(0.329e-3, rel=0.01)
    assert report.stat().st_size > 1_000_000


def test_set_seed_model_and_effect_reach_the_run(flexros: Flexros, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    ended = flexros(
        "run", "circle_dae", "--transport", "direct", "--out", str(bag), "--seed", "7", "--json",
        "--set", "sample_time=0.001", "--effect", "payload_error@tool:relative=0.05",
    )  # fmt: skip
    assert ended.code == 0, ended.err
    provenance = json.loads((bag / "provenance.json").read_text())
    assert provenance["seed"] == 7
    assert provenance["sample_time"] == 0.001
    assert provenance["scenario"]["plant"] == {"values": {}, "effects": ["payload_error@tool:relative=0.05"]}
    assert provenance["plant_hash"] != provenance["model_hash"]


def test_effects_of_the_command_line_come_after_those_of_the_scenario(flexros: Flexros, tmp_path: Path) -> None:
    bag, both = tmp_path / "bag", ["payload_error@tool:relative=0.05", "delay@all:time=0.0002"]
    ended = flexros(
        "run", "circle_pd", "--transport", "direct", "--out", str(bag), "--json",
        "--set", f"plant.effects=[{both[0]!r}]", "--effect", both[1],
    )  # fmt: skip
    assert ended.code == 0, ended.err
    assert json.loads((bag / "provenance.json").read_text())["scenario"]["plant"]["effects"] == both


def test_a_patch_is_a_model_and_what_the_feedforward_believes_in(flexros: Flexros, tmp_path: Path) -> None:
    patch = tmp_path / "patch.yaml"
    patch.write_text("robot: e12\neffects: [{effect: payload_error, location: tool, parameters: {relative: 0.05}}]\n")
    hidden = ("--effect", "payload_error@tool:relative=0.05")
    worst = {}
    for name, options in {
        "hidden": hidden,
        "known": (*hidden, "--set", f"feedforward_model={patch}"),
        "model": ("--model", str(patch)),
        "nominal": (),
    }.items():
        bag = tmp_path / name
        ended = flexros("run", "smooth_dae2", "--transport", "direct", "--out", str(bag), *options)
        assert ended.code == 0, ended.err
        analysed = json.loads(flexros("analyze", str(bag), "--json").out)
        worst[name] = 1e3 * analysed["path"]["path_error_m"]["max"]
    assert worst["hidden"] > 1.0
    assert max(worst["known"], worst["model"], worst["nominal"]) < 0.01


def test_what_the_feedforward_cannot_make_up_for_is_said(flexros: Flexros, tmp_path: Path) -> None:
    patch, bag = tmp_path / "patch.yaml", tmp_path / "bag"
    patch.write_text("robot: e12\neffects: [{effect: extra_mode, location: tool, parameters: {ratio: 0.01}}]\n")
    options = ("--transport", "direct", "--out", str(bag), "--set", f"feedforward_model={patch}")
    ended = flexros("run", "smooth_dae2", *options)
    assert ended.code == 0
    (warning,) = json.loads((bag / "provenance.json").read_text())["warnings"]
    assert "extra_mode@tool" in warning
    assert "not compensated" in warning
    assert ended.err.splitlines()[0] == f"flexros: {warning}"
    assert f"Next: flexros analyze {bag}" in ended.err


def test_scenarios_are_listed(flexros: Flexros) -> None:
    names = {row["name"] for row in json.loads(flexros("scenarios", "--json").out)}
    assert {"circle_pd", "circle_fj", "circle_dae", "circle_dae2"} <= names


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["circle_pt"], "unknown scenario 'circle_pt'"),
        (["circle_pd", "--transport", "udp"], "unknown transport 'udp'"),
        (["circle_pd", "--set", "sample_tme=1"], "did you mean 'sample_time'"),
        (["circle_pd", "--set", "sample_time"], "must be key=value"),
        (["circle_pd", "--set", "sample_time=.nan"], "finite"),
        (["circle_pd", "--set", "plant.values.body_3.mass=-1"], "must be at least 0 kg"),
        (["circle_pd", "--set", "plant.values.body_3.mass=.nan"], "finite"),
        (
            ["circle_dae", "--set", "trajectory.path.centre_from_start=[0.5, 0]"],
            "the trajectory is out of reach at t = ",
        ),
        (
            ["circle_pd", "--effect", "payload_error@arm:relative=1"],
            "scenario circle_pd, key plant.effects: unknown location of payload_error on robot e12 'arm'",
        ),
        (["circle_pd", "--effect", "payload_error"], "--effect: key 'plant.effects[0]': effect is 'payload_error'"),
        (["circle_pd", "--model", "e21"], "unknown robot 'e21'"),
        (["circle_pd", "--realtime"], "belong to the ROS nodes"),
    ],
)
def test_bad_input_is_one_sentence_and_code_2(
    flexros: Flexros, tmp_path: Path, arguments: list[str], message: str
) -> None:
    options = [] if "--transport" in arguments else ["--transport", "direct"]
    ended = flexros("run", *arguments, *options, "--out", str(tmp_path / "bag"))
    assert ended.code == 2
    assert message in ended.err
    assert len(ended.told) == 1
    assert not (tmp_path / "bag").exists()


def test_non_minimum_phase_feedforward_is_refused(flexros: Flexros, tmp_path: Path) -> None:
    ended = flexros(
        "run", "circle_dae", "--transport", "direct", "--out", str(tmp_path / "bag"),
        "--set", "model.values.body_3.length.x=1.0", "--set", "model.values.body_3.inertia.yy=5.0",
        "--set", "feedforward.non_minimum_phase=refuse",
    )  # fmt: skip
    assert ended.code == 2
    assert "minimum phase" in ended.err.replace("-", " ")
    assert ended.err.count("scenario circle_dae") == 1


def test_unstable_loop_ends_with_code_3_and_a_log(flexros: Flexros, tmp_path: Path) -> None:
    bag = tmp_path / "bag"
    ended = flexros("run", "circle_pd", "--transport", "direct", "--out", str(bag), "--set", "controller.kd=9e6")
    assert ended.code == 3
    assert "the simulated state is not finite at sample 12" in ended.err
    assert flexros("analyze", str(bag), "--json").code == 0


def test_existing_folder_is_kept(flexros: Flexros, tmp_path: Path) -> None:
    (tmp_path / "precious").write_text("data")
    ended = flexros("run", "circle_pd", "--transport", "direct", "--out", str(tmp_path))
    assert ended.code == 2
    assert "exists already" in ended.err
    assert (tmp_path / "precious").read_text() == "data"


def test_analyze_names_a_missing_log(flexros: Flexros, tmp_path: Path) -> None:
    ended = flexros("analyze", str(tmp_path / "nothing"))
    assert ended.code == 2
    assert "nothing" in ended.err


@pytest.mark.parametrize("name", ["[/b]", "[red]x", ":warning:"])
def test_brackets_in_a_path_are_printed_as_they_are(
    flexros: Flexros, tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "80")
    folder = Path("logs") / name
    folder.parent.mkdir(parents=True)
    ended = flexros("run", "circle_pd", "--transport", "direct", "--out", str(folder))
    assert ended.code == 0
    assert f"Log: {folder}\n" in ended.out
    ended = flexros("analyze", str(folder), str(folder))
    assert ended.code == 0
    assert ended.out.splitlines()[0].split() == ["figure", "unit", str(folder), str(folder)]


def test_samples_times_sample_time_is_the_simulated_time(flexros: Flexros, tmp_path: Path) -> None:
    ended = flexros("run", "circle_pd", "--transport", "direct", "--out", str(tmp_path / "bag"), "--json")
    content = json.loads(ended.out)
    assert content["simulated_time_s"] == pytest.approx(content["samples"] * 5e-4, rel=1e-12)


def test_figures_are_named_in_words_with_their_units(capsys: pytest.CaptureFixture[str]) -> None:
    figures = {"period_p50_us": 500.25, "samples_per_second": 2000.0, "real_time_priority": False, "new_figure": 3}
    print_result("circle_pd", RunResult(0, "", "ros, composed", Path("a b"), 762, 0.381, 0.4, figures))
    printed = capsys.readouterr().out
    rows = {cells[1].strip(): cells[2].strip() for line in printed.splitlines() if len(cells := line.split("│")) == 4}
    assert rows["period, median"] == "500.25 µs"
    assert rows["speed of the loop"] == "2000 samples/s"
    assert rows["real-time priority"] == "no"
    assert rows["new figure"] == "3"
    assert printed.endswith("Log: a b\n")


def test_identification_that_was_stopped_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    message = "stopped by the service stop at sample 900: 3 of 8 experiments are complete"
    print_result("identify_e12", RunResult(0, message, "ros, composed", Path("a"), 950, 0.475, 0.4))
    printed = capsys.readouterr().out
    assert f"\n{message.capitalize()}.\nLog: a\n" in printed


def test_a_slash_in_the_name_makes_no_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = default_folder("../a/b", "direct")
    assert folder.parent == Path("bags")
    assert folder.name.startswith(".._a_b_direct_")


def test_logs_of_the_same_name_are_told_apart(
    flexros: Flexros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")
    for folder in ("a", "b"):
        Path(folder).mkdir()
        assert flexros("run", "circle_pd", "--transport", "direct", "--out", f"{folder}/log", "--json").code == 0
    headings = flexros("analyze", "a/log", "b/log").out.splitlines()[0].split()
    assert headings == ["figure", "unit", "a/log", "b/log"]


@pytest.mark.parametrize(
    ("folder", "model", "message"),
    [(".", "e12", "the log folder . exists already"), ("log", "e21", "unknown robot 'e21'")],
)
def test_bad_input_is_refused_before_any_node_starts(
    flexros: Flexros, monkeypatch: pytest.MonkeyPatch, folder: str, model: str, message: str
) -> None:
    started = []
    monkeypatch.setattr(
        "flexros.scenario.transports.ros_runner", lambda: (lambda *given, **more: started.append(given), "")
    )
    ended = flexros("run", "circle_pd", "--transport", "ros", "--out", folder, "--model", model)
    assert (ended.code, started) == (2, [])
    assert message in ended.err


@pytest.mark.parametrize(
    ("options", "warning"),
    [
        ((), ""),
        (
            ("--network",),
            "flexros: --network: any host that can reach this machine can subscribe to and command these nodes\n",
        ),
    ],
)
def test_run_on_the_network_is_asked_for_and_said(
    flexros: Flexros, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, options: tuple[str, ...], warning: str
) -> None:
    given = {}

    def runner(*_: object, **more: object) -> None:
        given.update(more)
        raise RunError("no nodes here")

    monkeypatch.setattr("flexros.scenario.transports.ros_runner", lambda: (runner, ""))
    ended = flexros("run", "circle_pd", "--transport", "ros", "--out", str(tmp_path / "log"), *options)
    assert (given["network"], ended.err) == (bool(options), f"{warning}flexros: no nodes here\n")


def test_a_report_into_a_folder_is_refused(flexros: Flexros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert flexros("run", "circle_pd", "--transport", "direct", "--out", "log", "--json").code == 0
    ended = flexros("analyze", "log", "--report", ".")
    assert (ended.code, ended.told) == (
        2,
        ["flexros: the report cannot be written to '.', which is a folder; give a file"],
    )


def test_view_gives_the_run_a_page_and_turns_it_to_the_log(
    flexros: Flexros, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown: list[tuple[Path, int | None]] = []

    class Page:
        port = 8123

        def __init__(self, model: str) -> None:
            assert model == "e12"

    def run_ros(*_: object, beside: object, **__: object) -> RunResult:
        assert isinstance(beside, Page)
        return RunResult(0, "", "ros, composed", tmp_path / "topics", 1, 0.1, 0.1)

    pytest.importorskip("viser", reason="the viewer is not installed: pip install 'flexros[view]'")
    monkeypatch.setattr("flexros.cli.commands.run.PageBeside", Page)
    monkeypatch.setattr("flexros.cli.commands.run.choose_transport", lambda given, quiet: given)
    monkeypatch.setattr("flexros.scenario.transports.run_ros", run_ros)
    monkeypatch.setattr("flexros.cli.commands.run.show_log", lambda path, port: shown.append((path, port)))
    for transport in ("ros", "direct"):
        ended = flexros("run", "circle_fj", "--transport", transport, "--view", "--out", str(tmp_path / transport))
        assert ended.code == 0, ended.err
    assert shown == [(tmp_path / "ros", 8123), (tmp_path / "direct", None)]
