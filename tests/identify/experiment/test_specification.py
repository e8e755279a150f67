"""Valid and invalid settings under the key `identification`."""

from __future__ import annotations

import pytest
from pydantic import BaseModel, ValidationError

from flexros.config.settings import validate
from flexros.errors import InputError
from flexros.identify.excitation.burst import Burst
from flexros.identify.excitation.chirp import Chirp
from flexros.identify.excitation.multisine import Multisine
from flexros.identify.experiment.slow_motion import ConstantSpeed, NoSlowMotion, SlowSine
from flexros.identify.experiment.specification import IdentificationSpecification, LimitSettings, MoveSettings


@pytest.mark.parametrize(
    "model",
    [
        IdentificationSpecification,
        LimitSettings,
        MoveSettings,
        Multisine,
        Chirp,
        Burst,
        NoSlowMotion,
        ConstantSpeed,
        SlowSine,
    ],
)
def test_every_key_is_described(model: type[BaseModel]) -> None:
    assert [name for name, field in model.model_fields.items() if not field.description] == []


def test_blocks_are_one_number_or_one_per_position() -> None:
    positions = [[0.0], [1.0]]
    assert IdentificationSpecification(positions=positions, blocks=3).blocks_per_position == (3, 3)
    assert IdentificationSpecification(positions=positions, blocks=(3, 0)).blocks_per_position == (3, 0)
    with pytest.raises(ValidationError, match="there are 3 numbers of blocks for 2 positions, allowed is one number"):
        IdentificationSpecification(positions=positions, blocks=(1, 1, 1))
    with pytest.raises(ValidationError, match="no position has a block, allowed is at least one; raise blocks"):
        IdentificationSpecification(positions=positions, blocks=0)


def test_position_limits_hold_something() -> None:
    with pytest.raises(ValidationError, match=r"the position limits \[1, 1\] hold nothing, allowed is low below high"):
        LimitSettings(position=((1.0, 1.0),))


def test_unknown_excitation_and_misspelt_key_are_named() -> None:
    given = {"positions": [[0.0]], "excitation": {"kind": "multisine", "amplitud": 1.0}}
    with pytest.raises(InputError, match=r"unknown key 'excitation\.amplitud': did you mean 'amplitude'\?"):
        validate(IdentificationSpecification, given, "mine")
    with pytest.raises(InputError, match="excitation.*'multisine', 'chirp', 'burst'"):
        validate(IdentificationSpecification, {"positions": [[0.0]], "excitation": {"kind": "square"}}, "mine")
