"""The key `identification.excitation`: all kinds of excitation, distinguished by `kind`."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field

from flexros.identify.excitation.burst import Burst
from flexros.identify.excitation.chirp import Chirp
from flexros.identify.excitation.multisine import Multisine

Excitation: TypeAlias = Annotated[Multisine | Chirp | Burst, Field(discriminator="kind")]
"""Any excitation, distinguished by its key `kind`."""
