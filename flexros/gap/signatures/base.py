"""Base class and registry of the pictures of signatures, and reduction of curves to few points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np

from flexros.discovery import members
from flexros.effects import effects

if TYPE_CHECKING:
    from collections.abc import Mapping

    from flexros.arrays import FloatArray
    from flexros.gap.signatures.signature_data import SignatureData

MOST_POINTS = 2000
"""Largest number of points of a curve (chosen)."""


@dataclass(frozen=True, eq=False)
class Curve:
    """One curve of a picture.

    Attributes:
        x: Abscissa [unit of the picture's x_label], shape (k,), at most `MOST_POINTS`.
        y: Ordinate [unit of the picture's y_label], shape (k,); NaN interrupts the curve.
        style: Drawing style.
    """

    x: FloatArray
    y: FloatArray
    style: Literal["line", "points", "bars"] = "line"


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of a signature, as data.

    Attributes:
        title: Title, with the location.
        x_label: Quantity on the abscissa, with unit.
        y_label: Quantity on the ordinate, with unit.
        series: Curves by their names.
        reading: Explanation of the picture, one or two sentences.
        log_x: Whether the abscissa is logarithmic.
        log_y: Whether the ordinate is logarithmic.
    """

    title: str
    x_label: str
    y_label: str
    series: Mapping[str, Curve]
    reading: str
    log_x: bool = False
    log_y: bool = False


class AbstractSignature(ABC):
    """A kind of picture in which effects leave their signature.

    To add a picture, write a class in a file of its own that
    1. sets `name`, by which effects refer to it (`AbstractEffect.signatures`);
    2. implements `picture`, a pure function of the data that returns None where the log cannot show the signature.
    """

    name: ClassVar[str]

    @abstractmethod
    def picture(self, data: SignatureData, location: str) -> Picture | None:
        """Compute the picture.

        Args:
            data: Log, models and their predictions.
            location: Location of the effect: a joint, spring, body, "tool", "base" or "all".

        Returns:
            The picture; None where the log lacks the required signals.
        """


@cache
def signatures() -> Mapping[str, type[AbstractSignature]]:
    """Find all kinds of pictures in this package, by name."""
    return members("flexros.gap.signatures", AbstractSignature)  # type: ignore[type-abstract]


def pictures_for(effect: str) -> tuple[type[AbstractSignature], ...]:
    """Return the pictures that show an effect, the clearest first.

    Args:
        effect: Name of the effect, e.g. "coulomb_friction".
    """
    return tuple(signatures()[name] for name in effects()[effect].signatures)


def thinned(x: FloatArray, y: FloatArray, most: int = MOST_POINTS) -> tuple[FloatArray, FloatArray]:
    """Reduce a curve to the smallest and largest value of each of many equal parts, so that peaks survive.

    Args:
        x: Abscissa, shape (n,).
        y: Ordinate, shape (n,).
        most: Largest number of points.

    Returns:
        Abscissa and ordinate, shape (k,) with k <= most.
    """
    n, parts = len(y), most // 2
    if n <= most:
        return x, y
    length = n // parts + (n % parts > 0)
    whole = n // length * length
    blocks = np.where(np.isfinite(y[:whole]), y[:whole], 0.0).reshape(-1, length)
    first = np.arange(len(blocks)) * length
    rows = np.unique(np.concatenate([first + blocks.argmin(axis=1), first + blocks.argmax(axis=1)]))
    return x[rows], y[rows]


def binned(x: FloatArray, y: FloatArray, n_bins: int, *, least: int = 10) -> tuple[FloatArray, FloatArray]:
    """Average the ordinate over equal parts of the abscissa.

    Args:
        x: Abscissa, shape (n,); samples that are not finite are ignored.
        y: Ordinate, shape (n,).
        n_bins: Number of parts.
        least: Smallest number of samples of a part.

    Returns:
        Mean abscissa and ordinate of the parts with enough samples, shape (k,).
    """
    good = np.isfinite(x) & np.isfinite(y)
    x, y = x[good], y[good]
    if len(x) == 0:
        return x, y
    span = float(np.ptp(x))
    part = np.minimum((n_bins * (x - x.min()) / (span or 1.0)).astype(int), n_bins - 1)
    count = np.bincount(part, minlength=n_bins)
    enough = count >= least
    mean = [np.bincount(part, weights=values, minlength=n_bins)[enough] / count[enough] for values in (x, y)]
    return mean[0], mean[1]
