"""Mass, centre and inertia of bodies of an MJCF: read from its model, and written into the file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from flexros.robot.exchange.body_inertia import BodyInertia
from flexros.robot.exchange.mjcf.mujoco_model import mujoco_package
from flexros.robot.exchange.number_text import number, numbers_text

if TYPE_CHECKING:
    from flexros.robot.exchange.xml_text import XmlElement

_ORIENTATIONS = ("quat", "axisangle", "xyaxes", "zaxis", "euler", "diaginertia")
"""Attributes of <inertial> that full inertias replace."""
_ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))


def write_inertia(body: BodyInertia, element: XmlElement) -> None:
    """Write mass, centre and inertia of a body into its element <body>."""
    attributes = {
        "pos": numbers_text(body.center),
        "mass": number(body.mass),
        "fullinertia": numbers_text(float(body.inertia[entry]) for entry in _ENTRIES),
    }
    inertial = element.find("inertial")
    if inertial is None:
        element.add("inertial", attributes)
        return
    for name in _ORIENTATIONS:
        inertial.remove(name)
    for name, value in attributes.items():
        inertial.set(name, value)


def inertia_of(model: Any, body: int) -> BodyInertia:
    """Return the numbers of a body of a compiled model, in its frame."""
    turn = np.zeros(9)
    mujoco_package().mju_quat2Mat(turn, model.body_iquat[body])
    axes = turn.reshape(3, 3)
    inertia = axes @ np.diag(model.body_inertia[body]) @ axes.T
    return BodyInertia(float(model.body_mass[body]), np.array(model.body_ipos[body]), inertia)
