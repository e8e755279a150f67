"""Nulls with rounded encoders: is a robot without deviation called one without gap?"""

from flexros.validation.campaigns.quantized_nulls.campaign import QuantizedNulls

__all__ = ["QuantizedNulls"]
