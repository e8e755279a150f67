"""Help of a group of commands: listed by job, plain text that needs no colours and no wide terminal."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

from flexros.cli.guide import JOBS


class JobGroup(TyperGroup):
    """A group whose help lists its commands by their panel."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write a section for each job with its commands."""
        shown = {name: command for name in self.list_commands(ctx) if (command := self.get_command(ctx, name))}
        width = max(map(len, shown), default=0)
        by_job: dict[str, list[tuple[str, str]]] = {}
        for name, command in shown.items():
            job = getattr(command, "rich_help_panel", None)
            job = job if isinstance(job, str) else "Commands"
            text = command.get_short_help_str(formatter.width - width - 6)
            by_job.setdefault(job, []).append((name.ljust(width), text))
        for job in (*JOBS, *(other for other in by_job if other not in JOBS)):
            if job in by_job:
                with formatter.section(job):
                    formatter.write_dl(by_job[job])
