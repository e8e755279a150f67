"""Desired motion: path geometry, time laws, limits and reachability."""

from flexros.trajectory.arc import Arc, circle
from flexros.trajectory.bang_bang_snap import SnapProfile, bang_bang_snap, snap_profile
from flexros.trajectory.joint_derivatives import OutputDerivatives, joint_derivatives
from flexros.trajectory.limits import Limits, check_limits, joint_limits
from flexros.trajectory.line import JointMove, Line
from flexros.trajectory.orientation import Extended, RollPitchYaw
from flexros.trajectory.path import AbstractPath
from flexros.trajectory.polynomial import ninth_degree, quintic
from flexros.trajectory.reachability import Reachability, check_reachable, is_reachable
from flexros.trajectory.rest_path import Rest
from flexros.trajectory.sequence import Sequence
from flexros.trajectory.specification import TrajectorySpecification, build_trajectory
from flexros.trajectory.time_law import TimeLaw, concatenated
from flexros.trajectory.trajectory import JOINTS, Move, PathPoint, Trajectory

__all__ = [
    "JOINTS",
    "AbstractPath",
    "Arc",
    "Extended",
    "JointMove",
    "Limits",
    "Line",
    "Move",
    "OutputDerivatives",
    "PathPoint",
    "Reachability",
    "Rest",
    "RollPitchYaw",
    "Sequence",
    "SnapProfile",
    "TimeLaw",
    "Trajectory",
    "TrajectorySpecification",
    "bang_bang_snap",
    "build_trajectory",
    "check_limits",
    "check_reachable",
    "circle",
    "concatenated",
    "is_reachable",
    "joint_derivatives",
    "joint_limits",
    "ninth_degree",
    "quintic",
    "snap_profile",
]
