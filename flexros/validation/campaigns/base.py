"""The contract of a campaign, and the campaigns by name."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, ClassVar

from flexros.discovery import members
from flexros.errors import unknown_name

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping
    from pathlib import Path

    from distributed import Client


def tell_nobody(what: str, done: int, whole: int) -> None:
    """Ignore a report of progress."""


@dataclass(frozen=True, eq=False)
class CampaignRequest:
    """Request to run a campaign.

    Attributes:
        work: Folder of this campaign alone, which exists: finished parts are kept here, and a campaign that is started
            again continues from them.
        client: Dask client to whose workers the parts are submitted.
        repetitions: Number of repetitions, initial values or cases; None for the default of the campaign.
        progress: Called with the current step, the amount done and the amount in all.
    """

    work: Path
    client: Client
    repetitions: int | None = None
    progress: Callable[[str, int, int], None] = tell_nobody


@dataclass(frozen=True, eq=False)
class CampaignResult:
    """Result of a campaign.

    Attributes:
        files: Text by path: the page of results, its pictures in `figures` and its numbers in `data`.
        record: The figures as nested dicts, lists and numbers for JSON.
        summary: The result in sentences, one per line of the terminal.
    """

    files: Mapping[str, str]
    record: Mapping[str, Any]
    summary: tuple[str, ...] = field(default=())


class AbstractCampaign(ABC):
    """A long computation that is repeated before a release, and its page of results.

    How to add a campaign: write a folder in this package whose `__init__` imports one final subclass. It is then
    found by its name in `flexros campaign` and `make campaign`. It provides:

    1. `name`, a class variable: the name by which the command line chooses it.
    2. `question`, a class variable: what it answers, one sentence.
    3. `run`: computes the result; it keeps finished parts in the folder it is given, so that an aborted
       campaign continues (`parts.finished_parts` does so), and is a function of its request alone.

    Robots, experiments and estimators belong into their own rooms; the folder holds what the question adds to them.
    """

    name: ClassVar[str]
    question: ClassVar[str]

    @abstractmethod
    def run(self, request: CampaignRequest) -> CampaignResult:
        """Run the campaign, or what is left of it.

        Args:
            request: How.

        Returns:
            What was found.

        Raises:
            InputError: The folder holds parts of another campaign.
        """


@cache
def campaigns() -> Mapping[str, type[AbstractCampaign]]:
    """Find all campaigns in this package, by name."""
    return members("flexros.validation.campaigns", AbstractCampaign)  # type: ignore[type-abstract]


def campaign_named(name: str, source: str = "") -> AbstractCampaign:
    """Return a campaign.

    Args:
        name: Its name.
        source: Where the name came from; part of the error text.

    Raises:
        InputError: There is no such campaign.
    """
    if name not in campaigns():
        raise unknown_name("campaign", name, campaigns(), source)
    return campaigns()[name]()
