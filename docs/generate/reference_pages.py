"""Write the pages of the reference that follow from the models: files, commands, topics. Run from the checkout."""

from __future__ import annotations

import inspect
import json
import sys
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_args, get_origin

import typer
from pydantic import BaseModel, TypeAdapter
from pydantic_core import PydanticUndefined

import flexros
from flexros.cli.app import EXIT_CODES, app
from flexros.cli.guide import JOBS, guide_of
from flexros.cli.json_output import OUTPUTS
from flexros.config.topics import load_topics
from flexros.control.base import control_laws
from flexros.gap.schema import Diagnosis
from flexros.gap.settings import DiagnosisSettings
from flexros.logs.foreign.mapping import LogMapping
from flexros.robot.specification import RobotSpecification
from flexros.scenario.scenario import Scenario

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import click
    from pydantic.fields import FieldInfo

WRITTEN = "<!-- written by docs/generate/reference_pages.py -->"


def cell(text: object) -> str:
    """Set a text for a cell of a table."""
    return " ".join(str(text).split()).replace("|", "\\|")


def type_name(annotation: Any) -> str:
    """Name the type of a key as a user would: `number`, `text`, `list of ...`, or the section that describes it."""
    simple = {
        float: "number",
        int: "whole number",
        str: "text",
        bool: "true or false",
        type(None): "nothing",
        Any: "any",
    }
    if annotation in simple:
        return simple[annotation]
    if isinstance(annotation, type):
        return (
            f"[{annotation.__name__}](#{annotation.__name__.lower()})" if issubclass(annotation, BaseModel) else "text"
        )
    origin, arguments = get_origin(annotation), [one for one in get_args(annotation) if one is not Ellipsis]
    if origin is None:
        return cell(str(annotation).replace("typing.", ""))
    if getattr(origin, "__name__", "") == "Annotated" or hasattr(annotation, "__metadata__"):
        return type_name(arguments[0])
    if getattr(origin, "__name__", "") == "Literal" or str(annotation).startswith("typing.Literal"):
        return " or ".join(f"`{one}`" for one in arguments)
    if origin in (tuple, list) or getattr(origin, "__name__", "") == "Sequence":
        return "list of " + " and ".join(dict.fromkeys(type_name(one) for one in arguments))
    if origin is dict or getattr(origin, "__name__", "") == "Mapping":
        return f"mapping of {type_name(arguments[0])} to {type_name(arguments[1])}"
    return " or ".join(dict.fromkeys(type_name(one) for one in arguments))


def models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """List the models that a type speaks of."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from models_in(part)


def default_of(field: FieldInfo) -> str:
    """Write the default of a key; "required" where it has none."""
    if field.is_required():
        return "required"
    if field.default_factory_takes_validated_data:
        return "from other keys"
    value = field.get_default(call_default_factory=True) if field.default is PydanticUndefined else field.default
    if isinstance(value, BaseModel):
        return "its defaults"
    return "" if value is None else f"`{cell(value)}`"


def paragraph(text: str) -> str:
    """Wrap a text, with links and options unbroken."""
    return textwrap.fill(" ".join(text.split()), 120, break_long_words=False, break_on_hyphens=False)


def section(model: type[BaseModel]) -> str:
    """Write the section of one model: its summary, and a row for each key."""
    rows = []
    for name, field in model.model_fields.items():
        key, value, meaning = field.alias or name, type_name(field.annotation), cell(field.description or "")
        rows.append(f"| `{key}` | {value} | {default_of(field)} | {meaning} |")
    summary = (model.__doc__ or "").strip().split("\n\n")[0]
    table = ["| key | value | default | meaning |", "|---|---|---|---|", *rows] if rows else []
    return "\n".join([f"## {model.__name__}", "", paragraph(summary), "", *table, ""])


def file_page(title: str, introduction: str, model: type[BaseModel], more: Sequence[type[BaseModel]] = ()) -> str:
    """Write the page of a file: its keys, then those of every section it consists of."""
    known: list[type[BaseModel]] = [model, *more]
    for part_model in known:  # grows during the iteration
        for field in part_model.model_fields.values():
            known += [part for part in dict.fromkeys(models_in(field.annotation)) if part not in known]
    return "\n".join([WRITTEN, "", f"# {title}", "", paragraph(introduction), "", *(section(one) for one in known)])


def commands(command: click.Command, path: str) -> Iterator[str]:
    """Write the section of a command and of those below it."""
    subcommands = getattr(command, "commands", None)
    level = "###" if path.count(" ") < 2 else "####"
    yield f"{level} {path}\n\n{paragraph((command.help or '').split('Args:')[0])}\n"
    if subcommands:
        for name in subcommands:
            yield from commands(subcommands[name], f"{path} {name}")
        return
    words = path.removeprefix("flexros ")
    if examples := guide_of(words).examples:
        yield "\n".join(["```bash", *examples, "```", ""])
    rows = []
    for parameter in command.params:
        if parameter.name == "help":
            continue
        names = ", ".join(f"`{one}`" for one in (*parameter.opts, *parameter.secondary_opts)) or f"`{parameter.name}`"
        default = (
            "required" if parameter.required else cell(parameter.default) if parameter.default not in (None, "") else ""
        )
        meaning = cell(getattr(parameter, "help", "") or "")
        if "--json" in parameter.opts and words in OUTPUTS:
            meaning += f" [Keys](json.md#{next(models_in(OUTPUTS[words])).__name__.lower()})"
        rows.append(f"| {names} | {meaning} | {default} |")
    if rows:
        yield "\n".join(["| option or argument | meaning | default |", "|---|---|---|", *rows, ""])


def commands_page() -> str:
    """Write the page of the command line."""
    root = typer.main.get_command(app)
    known = root.commands  # type: ignore[attr-defined]
    parts = []
    for job in JOBS:
        named = [name for name in known if guide_of(name).job == job]
        parts += [f"## {job}\n"] if named else []
        parts += [part for name in named for part in commands(known[name], f"flexros {name}")]
    return "\n".join([WRITTEN, "", "# Commands", "", paragraph(EXIT_CODES), "", *parts])


def json_pages() -> dict[str, str]:
    """Write the page of the JSON outputs, and a JSON schema for each command."""
    lead = (
        "What commands print with `--json`, on standard output; progress, warnings and next steps are on standard "
        "error. Numbers that are not finite are `null`. Each schema is a file of its own "
        "([JSON Schema](https://json-schema.org), draft 2020-12)."
    )
    lines = [WRITTEN, "", "# JSON output", "", paragraph(lead), "", "| command | prints | schema |", "|---|---|---|"]
    written: dict[str, str] = {}
    known: list[type[BaseModel]] = []
    for command, output in OUTPUTS.items():
        file = f"json/{command.replace(' ', '_')}.schema.json"
        schema = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": f"flexros {command} --json"}
        schema |= {**TypeAdapter(output).json_schema(), "title": schema["title"]}
        written[file] = json.dumps(schema, indent=1, ensure_ascii=False)
        lines.append(f"| `flexros {command}` | {type_name(output)} | [file]({file}) |")
        known += [model for model in dict.fromkeys(models_in(output)) if model not in known]
    lines += ["", "Every key of these, and no other:", ""]
    for model in known:  # grows during the iteration
        for field in model.model_fields.values():
            known += [part for part in dict.fromkeys(models_in(field.annotation)) if part not in known]
    lines += [section(model) for model in known]
    return {"json.md": "\n".join(lines), **written}


def topics_page() -> str:
    """Write the page of the topics."""
    rows = []
    for name, topic in load_topics().items():
        rate = "on demand" if topic.rate is None else f"{topic.rate:g} Hz"
        rows += [
            f"## {name}",
            "",
            paragraph(topic.description),
            "",
            f"`{topic.type}`, {rate}, from {topic.producer}",
            "",
        ]
        if topic.fields:
            rows += ["| field | unit | meaning |", "|---|---|---|"]
            rows += [f"| {field} | {cell(one.unit)} | {cell(one.meaning)} |" for field, one in topic.fields.items()]
            rows.append("")
    lead = (
        "Names are relative: a namespace can be put before them. `msgs_config/topics.yaml` is where they are defined."
    )
    return "\n".join([WRITTEN, "", "# Topics", "", lead, "", *rows])


PYTHON = {
    "Robots": ("load_robot", "robot_names", "load_model", "linear_model", "Robot", "LinearModel"),
    "Runs and logs": (
        "run", "analyze", "read_log", "write_log", "load_scenario", "scenario_names", "Run", "Log", "Analysis",
        "Scenario",
    ),
    "Identification": (
        "frequency_responses", "identify_robot", "FrequencyResponses", "FrequencyResponse", "IdentificationResult",
    ),
    "Diagnosis": ("diagnose", "measure_gap", "Diagnosis", "MeasuredGap"),
    "Controllers": (
        "design", "benchmark_controllers", "controller_names", "ControllerDesign", "BenchmarkResults",
        "BenchmarkResult",
    ),
    "Errors": ("FlexrosError", "InputError", "RunError"),
}  # fmt: skip
"""Names of `import flexros` by job."""


def python_pages() -> dict[str, str]:
    """Write the overview of `import flexros`, and a page for each of its names from its docstring."""
    lead = (
        "What `import flexros` offers. Each name is loaded when it is used first. Results show themselves in a "
        "notebook, draw themselves with `plot()` (a Plotly figure), and go on with `to_pandas()`, `to_xarray()` and "
        "`to_control()` where these apply. The [notebooks](../../notebooks/overview.md) use them. Everything else is "
        "in the rooms of the API."
    )
    lines = [WRITTEN, "", "# Python", "", paragraph(lead), ""]
    written = {}
    for job, names in PYTHON.items():
        lines += [f"## {job}", "", "| name | what it is |", "|---|---|"]
        for name in names:
            value = getattr(flexros, name)
            page = (
                f"{name}_class.md" if inspect.isclass(value) else f"{name}.md"
            )  # Run and run are one file on some disks
            lines.append(f"| [{name}]({page}) | {cell((inspect.getdoc(value) or '').splitlines()[0])} |")
            written[f"python/{page}"] = f"{WRITTEN}\n\n::: flexros.{name}\n    options:\n      heading_level: 1\n"
        lines.append("")
    return {"python/index.md": "\n".join(lines), **written}


def pages() -> dict[str, str]:
    """Write all pages, by file name."""
    laws = tuple(control_laws().values())
    scenario = (
        "A scenario determines one run. Built-in scenarios are listed by `flexros scenarios`; `--set key=value` "
        "changes one key."
    )
    robot = (
        "A robot is one YAML file; `flexros/robot/library` holds the built-in ones. A quantity is a number with unit, "
        "or a mapping of value, unit, source and tolerance (one standard deviation)."
    )
    mapping = (
        "A mapping file assigns the columns of a foreign log to quantities of joints: "
        "`flexros import MAPPING FILE... --out BAG`."
    )
    answer = "The answer of `flexros diagnose`, as DIR/diagnosis.json."
    settings = "Settings of the diagnosis, with their reasons; the values used are in the provenance of diagnosis.json."
    return {
        "scenario.md": file_page("Scenario files", scenario, Scenario, laws),
        "robot.md": file_page("Robot files", robot, RobotSpecification),
        "mapping.md": file_page("Mapping files", mapping, LogMapping),
        "diagnosis.md": file_page("diagnosis.json", answer, Diagnosis),
        "diagnosis_settings.md": file_page("Settings of the diagnosis", settings, DiagnosisSettings),
        "commands.md": commands_page(),
        "topics.md": topics_page(),
        **python_pages(),
        **json_pages(),
    }


def main(folder: Path) -> None:
    """Write the pages into a folder."""
    for part in ("python", "json"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        (folder / name).write_text(text.rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parents[1] / "reference")
