"""What a diagnosis takes for granted of a log, in one place: where simulated logs and those of real machines differ."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Premises:
    """What a diagnosis takes for granted of a log.

    Attributes:
        floor_is_noise: Whether a right model leaves noise of known size: what is left above it is the rest that is to
            be explained, and a nominal model without tolerances is exact. The floor of a real machine is a tolerance.
            Above it something is always left, so that a further effect is worth its share of the whole gap, and below
            it there may be what is worth a name.
        library_is_complete: Whether every hidden effect is expected in the library: what an explanation leaves shows
            that an effect is missing, or imitated by others, and exchanges, divisions and restarts are worth their
            time. On a real machine simple laws at all joints come first, curves take up what no law explains, and
            effects that fail on held-out data are withdrawn.
        torques_tell: Whether torques and commands begin the search even near the nominal model, as on a real machine,
            which lacks friction and rotors at most joints.
    """

    floor_is_noise: bool
    library_is_complete: bool
    torques_tell: bool


SIMULATED = Premises(floor_is_noise=True, library_is_complete=True, torques_tell=False)
MEASURED = Premises(floor_is_noise=False, library_is_complete=False, torques_tell=True)
