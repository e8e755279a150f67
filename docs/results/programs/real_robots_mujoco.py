"""System identification with the toolbox of MuJoCo (mujoco.sysid), for comparison on the page real_robots.md."""

from __future__ import annotations

import contextlib
import importlib
import io
import time
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.signal import savgol_filter

from flexros.effects.patching.export import export_model
from flexros.effects.patching.patched_robot import load_patched

if TYPE_CHECKING:
    from flexros.arrays import FloatArray
    from flexros.record.record import Record

WINDOW, WINDOWS, MOST_STEPS = 0.5, 40, 20
"""Duration of the simulated windows [s], their largest number, spread over the log, and most steps of the search."""
LONGEST_STEP = 2e-3
"""Longest step of the simulation [s]."""
LARGEST = 20.0
"""Largest value of a parameter, over its scale [1]."""
START = 0.1
"""Value of a parameter that the search starts at, over its scale [1]."""
SMOOTHING = 11
"""Samples that speeds are computed from where they were not measured."""


ABSENT = ("MuJoCo is not installed", "the packages of mujoco[sysid] are not installed")
"""Reasons to skip it that an installation removes."""


def identified(record: Record, robot: str) -> dict[str, Any]:
    """Identify damping, dry friction and armature of all joints, from windows that begin in the measured state.

    Args:
        record: The log.
        robot: Built-in robot, or robot file: rigid, stated at the joints.

    Returns:
        `numbers` by name of the parameter of the robot and `effects`, as texts, which together state the result, and
        `seconds`; or `skipped`, the reason why there is none.
    """
    try:
        mujoco, sysid = importlib.import_module("mujoco"), importlib.import_module("mujoco.sysid")
    except ImportError:
        return {"skipped": ABSENT[0]}
    if not hasattr(sysid, "optimize"):
        return {"skipped": ABSENT[1]}
    began = time.monotonic()
    spec = mujoco.MjSpec.from_string(export_model(load_patched(robot), "mjcf").text)
    spec.option.timestep = record.sample_time / np.ceil(record.sample_time / LONGEST_STEP)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST  # stable with any damping
    joints = [f"motor_{index}" for index in range(1, record.position.shape[1] + 1)]
    for joint in joints:
        spec.add_sensor(
            type=mujoco.mjtSensor.mjSENS_JOINTPOS, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname=joint, name=joint
        )
    scales = _scales(record)
    parameters = sysid.ParameterDict()
    for column, joint in enumerate(joints):
        for name, scale in scales.items():
            parameters.add(
                sysid.Parameter(f"{joint}.{name}", START, 0.0, LARGEST, modifier=_setter(joint, name, scale[column]))
            )
    residuals = sysid.build_residual_fn(
        models_sequences=[_windows(record, spec, sysid)], modify_residual=_errors(record, sysid)
    )
    with contextlib.redirect_stdout(io.StringIO()):
        best, _ = sysid.optimize(parameters, residuals, optimizer="mujoco", verbose=False, max_iters=MOST_STEPS)
    values = {
        name: [float(best[f"{joint}.{name}"].value[0] * scale[column]) for column, joint in enumerate(joints)]
        for name, scale in scales.items()
    }
    return {
        "numbers": {
            **{f"{joint}.viscous_friction": value for joint, value in zip(joints, values["damping"])},
            **{f"{joint}.inertia": value for joint, value in zip(joints, values["armature"])},
        },
        "effects": [
            f"coulomb_friction@{joint}:level={value:.6g}" for joint, value in zip(joints, values["frictionloss"])
        ],
        "seconds": time.monotonic() - began,
    }


def speeds(record: Record) -> FloatArray:
    """Return measured speeds, or those of a local parabola [rad/s or m/s], shape (n, M)."""
    if record.velocity is not None:
        return record.velocity
    smooth: FloatArray = savgol_filter(record.position, SMOOTHING, 2, deriv=1, delta=record.sample_time, axis=0)
    return smooth


def _scales(record: Record) -> dict[str, FloatArray]:
    """Scales of the parameters by their name in MuJoCo, each of shape (M,)."""
    speed = speeds(record)
    acceleration = savgol_filter(speed, SMOOTHING, 2, deriv=1, delta=record.sample_time, axis=0)
    torque, fast, faster = (np.sqrt(np.mean(each**2, axis=0)) for each in (record.torque, speed, acceleration))
    return {"damping": torque / fast, "frictionloss": torque, "armature": torque / faster}


def _setter(joint: str, name: str, scale: float) -> Any:
    def set_on(spec: Any, parameter: Any) -> None:
        value = float(parameter.value[0]) * scale
        before = np.ravel(getattr(spec.joint(joint), name))  # damping has further powers of the speed, here unused
        setattr(spec.joint(joint), name, value if len(before) == 1 else np.array([value, *before[1:]]))

    return set_on


def _windows(record: Record, spec: Any, sysid: Any) -> Any:
    """Cut the log into windows without lost samples."""
    model, n = spec.compile(), round(WINDOW / record.sample_time)
    starts = np.arange(0, record.n_samples - n - 1, n)
    starts = np.array([start for start in starts if record.valid[start : start + n + 1].all()])
    starts = starts[np.unique(np.linspace(0, len(starts) - 1, min(WINDOWS, len(starts))).astype(int))]
    speed, times = speeds(record), record.sample_time * np.arange(n + 1)
    of_windows = [slice(start, start + n + 1) for start in starts]
    return sysid.ModelSequences(
        "robot",
        spec,
        [f"window {index}" for index in range(len(starts))],
        [sysid.create_initial_state(model, record.position[at], speed[at]) for at in starts],
        [sysid.TimeSeries.from_control_names(times, record.torque[at], model) for at in of_windows],
        [sysid.TimeSeries.from_names(times, record.position[at], model) for at in of_windows],
    )


def _errors(record: Record, sysid: Any) -> Any:
    """Errors of the positions of a window over their spread in the log."""
    spread = record.position.std(axis=0)

    def errors(_parameters: Any, _predicted: Any, measured: Any, model: Any, _all: bool, *, state: FloatArray) -> Any:
        at = np.column_stack([np.interp(measured.times, state[:, 0], state[:, 1 + joint]) for joint in range(model.nq)])
        predicted = sysid.TimeSeries(measured.times, at, measured.signal_mapping)
        return (measured.data - at) / spread, predicted, measured

    return errors
