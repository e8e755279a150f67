"""Effects of the encoders."""

from flexros.effects.encoders.encoder_eccentricity import EncoderEccentricity
from flexros.effects.encoders.encoder_offset import EncoderOffset
from flexros.effects.encoders.encoder_quantization import EncoderQuantization

__all__ = ["EncoderEccentricity", "EncoderOffset", "EncoderQuantization"]
