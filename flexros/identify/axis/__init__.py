"""One axis with nonlinear gear stiffness and friction, identified in the time domain by prediction errors."""

from flexros.identify.axis.identification import OneAxisIdentification, identify_one_axis
from flexros.identify.axis.structure import AxisStructure

__all__ = ["AxisStructure", "OneAxisIdentification", "identify_one_axis"]
