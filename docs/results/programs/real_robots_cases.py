"""The measured robots of real_robots.md: where their data are from, and what is known of their gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

from real_robots_case import Case, Known

if TYPE_CHECKING:
    from collections.abc import Sequence


def _csv(*names: str) -> dict[str, tuple[str, ...]]:
    return {name: (f"{name}.csv",) for name in names}


def _coulomb(joint: int, low: float, high: float | None = None) -> Known:
    return Known("Coulomb friction", f"motor_{joint}", low, low if high is None else high, "Nm")


def _viscous(joint: int, value: float) -> Known:
    return Known("viscous friction", f"motor_{joint}", value, value, "Nm s/rad")


def _frictions(
    coulomb: Sequence[tuple[float, ...]], viscous: Sequence[tuple[float, float]], nominal: float = 0.0
) -> tuple[Known, ...]:
    """Return both frictions of every joint; `nominal` is the viscous friction in the robot file."""
    return tuple(
        one
        for joint, (dry, wet) in enumerate(zip(coulomb, viscous, strict=True), start=1)
        for one in (_coulomb(joint, *dry), Known("viscous friction", f"motor_{joint}", *wet, "Nm s/rad", nominal))
    )


_SECOND_STATE = (
    "it simulates windows of the log from their full state, and that of the link behind the spring was not measured"
)
_NO_TORQUE = "our wrapper of it needs torques, and the log has positions alone"
_UR = (
    "Innopolis University, [github.com/shamilmamedov/dynamic_calibration](https://github.com/shamilmamedov/"
    "dynamic_calibration), no licence stated: fetched by `fetch_real_robots.py`."
)
_TX40_COULOMB = ((7.14,), (8.26,), (6.34,), (2.48,), (3.03, 4.98), (2.232,))
_TX40_VISCOUS = ((8.05, 8.05), (5.53, 5.53), (1.97, 1.97), (1.11, 1.11), (1.86, 2.476), (1.266, 1.266))
_UR_FRICTION = ((21.256, 12.548), (20.221, 13.266), (10.378, 4.994), (3.575, 1.998), (2.491, 2.690), (3.026, 2.298))
"""Published viscous and Coulomb friction of the six joints [Nm s/rad, Nm]."""
_PANDA_FRICTION = (
    (0.244, 0.273),
    (0.181, 0.436),
    (0.222, 0.320),
    (0.442, 0.640),
    (0.286, 0.420),
    (0.135, 0.152),
    (0.240, 0.282),
)
"""Coulomb friction of the seven joints: by least squares of the log, and published (Gaz 2019, supplement) [Nm]."""
_LWR_COULOMB = (
    (0.308, 0.611),
    (0.131, 0.363),
    (0.304, 0.491),
    (0.289, 0.473),
    (0.595, 1.007),
    (0.132, 0.214),
    (0.038, 0.168),
)
"""Coulomb friction of the seven joints by least squares of each log, and published: smallest and largest [Nm]."""
_LWR_BY_HAND = (
    (0.6107, 1.0690),
    (0.3633, 0.9583),
    (0.3040, 0.2233),
    (0.4728, 0.6886),
    (0.5950, 0.0650),
    (0.1596, 0.2519),
    (0.0379, 0.0759),
)
"""Coulomb and viscous friction of the seven joints as in the tutorial of its authors [Nm, Nm s/rad]."""
_MED7_COULOMB = ((0.171, 0.635), (0.147, 0.172), (0.281, 0.353), (0.127, 0.164), (0.094, 0.126), (0.122, 0.132))
"""Coulomb friction of joints 2 to 7 by two least squares of the log, which differ in filter and weights [Nm]."""
_XMATE_COULOMB = (
    (0.872, 1.094),
    (0.248, 1.454),
    (0.592, 0.659),
    (0.735, 1.052),
    (0.513, 0.561),
    (0.247, 0.456),
    (0.330, 0.417),
)
"""Coulomb friction of the seven joints by least squares of each of the three logs, smallest and largest [Nm]."""
_KR300_COULOMB = ((333, 355), (242, 472), (294, 406), (50, 111), (47, 134), (76, 91))
_KR300_VISCOUS = ((1978, 2088), (1992, 2307), (1584, 2024), (238, 454), (534, 1000), (391, 459))
"""Friction of the six joints, smallest and largest of four numbers: published, and by least squares of each log."""
_SIX_AXIS_COULOMB = ((10.8, 12.1), (18.3, 20.1), (6.63, 7.02), (3.54, 4.00), (2.28, 2.43), (2.85, 2.98))
_SIX_AXIS_VISCOUS = ((6.65, 7.39), (10.7, 13.5), (3.99, 4.36), (2.72, 3.24), (2.02, 2.38), (0.82, 1.04))
"""Friction of six joints by least squares of each of five logs and of all, smallest and largest [Nm, Nm s/rad]."""
_GEN3 = "pyDynaMapp/data/kinova"
_KR300_LOG = "data/recorded_trajectories/2020-10-21 10s FF {} 08ms/data.mat"
_UR_LOGS = "dataset_ur10e/identification_data"
_TIAGO_FRICTION = ((1.50, 32.5), (4.85, 13.9), (2.73, 5.50), (1.65, 7.43))
"""Coulomb and viscous friction of four joints by least squares [Nm, Nm s/rad]."""
_UR10_FRICTION = ((12.8, 19.1), (14.3, 23.8), (8.39, 8.62), (2.85, 3.27), (2.35, 3.17), (2.53, 3.30))
"""Coulomb and viscous friction of six joints by least squares [Nm, Nm s/rad]."""
_GEN3_COULOMB = ((1.41, 2.71), (2.96, 10.0), (1.59, 4.48), (1.35, 4.76), (1.64, 1.99), (1.20, 1.53), (1.20, 1.40))
"""Coulomb friction of the seven joints by least squares of each of the three logs, smallest and largest [Nm]."""
_GEN3_VISCOUS = ((3.79, 4.31), (1.67, 10.2), (1.40, 3.23), (2.50, 5.28), (1.73, 4.87), (0.77, 1.56), (1.03, 1.74))
"""Their viscous friction [Nm s/rad]."""

_AR5_COULOMB = (
    (0.274, 0.287),
    (0.150, 0.284),
    (0.263, 0.284),
    (0.496, 0.498),
    (0.154, 0.167),
    (0.440, 0.478),
    (0.102, 0.112),
)
"""Coulomb friction of the seven joints: by least squares of the log, and published, smallest and largest [Nm]."""

_GO2_FREE_RUNS = (
    ((0.2087, 0.2622), (0.1556, 0.2666), (0.0045, 0.0112)),
    ((0.1475, 0.2018), (0.1905, 0.2615), (0.0110, 0.0150)),
    ((0.1467, 0.2142), (0.5438, 1.2714), (0.0282, 0.0328)),
)
"""Viscous friction [Nm s/rad], Coulomb friction [Nm] and rotor [kg m2] of hip, thigh and calf, of four legs."""

_SO101_FREE_RUNS = {
    2: ((9.37, 10.2), (0.337, 0.369)),
    3: ((8.30, 10.8), (0.347, 0.433)),
    4: ((11.6, 13.3), (0.148, 0.210)),
}
"""Stiffness of the servo [Nm/rad] and dry friction [Nm] of the joints that carry weight."""


def _so101(motion: str) -> tuple[str, ...]:
    """Return the files of a motion of the SO-101."""
    return tuple(f"output/real/so101/custom/{motion}/{name}.csv" for name in ("state_motor", "control"))


def _six_axis(log: str) -> tuple[str, ...]:
    """Return the files of a log of the six-axis arm of unnamed make."""
    return tuple(f"data/{log}/{name}.mat" for name in ("joint", "torque"))


def _go2(leg: str, place: str) -> Case:
    """Return the case of a leg of the Go2."""
    return Case(
        name=f"go2_{place.replace(' ', '_')}_leg",
        title=f"Leg of a Unitree Go2 under position commands, {place}",
        about="DLS Lab, Istituto Italiano di Tecnologia, [github.com/iit-DLSLab/sim2real-robot-identification]"
        "(https://github.com/iit-DLSLab/sim2real-robot-identification), BSD-3-Clause: fetched by "
        "`fetch_real_robots.py`. 200 Hz, 23 s; the body hangs fixed, commanded positions go to and fro ever faster, "
        "in steps of 30 ms at first. Nominal: the leg in the MJCF of its authors by `flexros import-mjcf`, with the "
        "gains of their configuration (20 Nm/rad, 1.5 Nm s/rad) and without its dry friction of 0.2 Nm, tolerance 3 %. "
        "The instants of the file are even: the positions were taken about 1 ms rms off them. A single log: its last, "
        "fastest third is not fitted, but it decides what is withdrawn, which was one effect at each of the rear legs.",
        folder="sim2real-robot-identification",
        robot=f"{leg}.xml",
        mapping="go2_leg.yaml",
        fitted=(f"{leg}.csv",),
        known=tuple(
            one
            for joint, (viscous, coulomb, rotor) in enumerate(_GO2_FREE_RUNS, start=1)
            for one in (
                Known("viscous friction", f"motor_{joint}", *viscous, "Nm s/rad", 0.6),
                _coulomb(joint, *coulomb),
                Known("inertia", f"motor_{joint}", *rotor, "kg m2", 0.01),
            )
        ),
        source="least squares of free runs of MuJoCo through the whole log of each of the four legs, smallest and "
        "largest, by `python docs/results/programs/measured/quadruped_free_runs.py fetched`; they leave 5 to 10 of 14 "
        "to 21 mrad rms, and no delay above 0.6 ms",
        by_mujoco=_NO_TORQUE,
        fetched=True,
    )


CASES = (
    Case(
        name="dfki_double_pendulum",
        title="Double pendulum with two quasi-direct drives",
        about="DFKI, design C.1, 500 Hz, 10 s per log, BSD-3-Clause. The nominal model is the published rigid one "
        "without its friction; its stated tolerance is 5 %. The two logs of design A.0 are of another robot. In "
        "C_143906 joint 1 alone is driven; C_143704 lacks one command.",
        folder="dfki_double_pendulum",
        robot="robot_without_friction.yaml",
        mapping="mapping.yaml",
        fitted=("C_143601.csv",),
        further=_csv("C_143339", "C_143524", "C_143906", "C_144115", "C_143704"),
        known=(_coulomb(1, 0.16, 0.313), _coulomb(2, 0.11, 0.185)),
        source="published 0.16 to 0.175 and 0.11 to 0.12 Nm; least squares of the fitted log 0.196 and 0.185 Nm; the "
        "hand-made patch, which closes more than the published one, 0.313 and 0.12 Nm. The range below holds all three",
        by_hand=("coulomb_friction@motor_1:level=0.313", "coulomb_friction@motor_2:level=0.12"),
        cutoff=10.0,
    ),
    Case(
        name="simple_pendulum",
        title="Pendulum with a quasi-direct drive",
        about="DFKI, [github.com/dfki-ric-underactuated-lab/torque_limited_simple_pendulum](https://github.com/"
        "dfki-ric-underactuated-lab/torque_limited_simple_pendulum), BSD-3-Clause: fetched by `fetch_real_robots.py`. "
        "Swing-ups of 3.5 to 6 s at 300 to 500 Hz, encoder steps of 3 mrad. Nominal: its URDF, without friction, "
        "tolerance 3 %. By least squares below 10 Hz inertia and weight are 1.27 and 1.18 times those of the URDF; "
        "below 20 Hz the inertia is half of that, so the arm bends. Of the torques of the third log a quarter goes "
        "with nothing that moves.",
        folder="torque_limited_simple_pendulum",
        robot="data/urdf/dfki_simple_pendulum.urdf",
        mapping="pendulum.yaml",
        fitted=("results/control_method_ddp/data_measured.csv",),
        further={
            "direct_collocation": ("results/control_method_direct_collocation/data_measured.csv",),
            "system_identification": ("results/control_method_pd/system_identification/data_measured.csv",),
        },
        known=(_coulomb(1, 0.173, 0.208),),
        source="least squares of the torque of the fitted log and of the second one below 10 Hz; published 0.184 Nm "
        "times the arctangent of a hundred times the speed",
        fetched=True,
    ),
    Case(
        name="quanser_stage_1",
        title="Harmonic drive with a flexible link, stage 1",
        about="Quanser 2DSFL, [github.com/basta/quanser-2-dof-serial-flexible-link]"
        "(https://github.com/basta/quanser-2-dof-serial-flexible-link), 500 Hz, 20 s, MIT; two logs with two "
        "controllers. Nominal: numbers of the maker, tolerance 10 %. The two stages are coupled, their models are not.",
        folder="quanser_2dsfl",
        robot="robot_stage1.yaml",
        mapping="mapping_stage1.yaml",
        fitted=("lqr.csv",),
        further=_csv("fsf"),
        known=(
            _coulomb(1, 1.1, 1.87),
            Known("inertia", "motor_1", 0.17, 0.54, "kg m2", 0.06353616),
        ),
        source="least squares of the torque of lqr with the strain gauge, positions low-passed at 10 Hz: 0.54 kg"
        " m2 and 1.2 Nm, where the stiffness comes out as -52 instead of 40 Nm/rad; with the stiffness of"
        " the maker 0.17 kg m2 and 1.87 Nm. As patches the two close the same share of the gap (95.8 and "
        "97.0 % of lqr, 90.3 and 90.4 % of fsf), so these logs hardly separate the inertia from the "
        "spring",
        by_hand=("coulomb_friction@motor_1:level=1.2",),
        numbers_by_hand={"motor_1.inertia": 0.54, "motor_1.viscous_friction": 3.3},
        by_mujoco=_SECOND_STATE,
    ),
    Case(
        name="quanser_stage_2",
        title="Harmonic drive with a flexible link, stage 2",
        about="As stage 1, which carries it: the base of stage 2 moves, and the torque of that is in neither model.",
        folder="quanser_2dsfl",
        robot="robot_stage2.yaml",
        mapping="mapping_stage2.yaml",
        fitted=("lqr.csv",),
        further=_csv("fsf"),
        known=(
            _coulomb(1, 0.042),
            Known("viscous friction", "motor_1", 0.164, 0.164, "Nm s/rad", 1.5),
            Known("inertia", "motor_1", 0.0128, 0.0128, "kg m2", 0.00301955),
        ),
        source="least squares as for stage 1, which leaves 48 % of the torque of lqr; in fsf it finds 0.14 Nm, 0.42 "
        "Nm s/rad and 0.0086 kg m2 and leaves 57 %, so these numbers are no more than orders of magnitude",
        by_mujoco=_SECOND_STATE,
    ),
    Case(
        name="emps",
        title="Linear drive EMPS",
        about="Janot, Gautier and Brunot (2019), 1 kHz, 25 s; in the second log pulses of force are added to the "
        "command. Nominal: mass and viscous friction as published, no tolerance. [More on it](emps.md).",
        folder="emps",
        robot="emps",
        mapping="emps",
        fitted=("DATA_EMPS.mat",),
        further={"DATA_EMPS_PULSES": ("DATA_EMPS_PULSES.mat",)},
        known=(
            Known("Coulomb friction", "motor_1", 20.14, 20.63, "N"),
            Known("asymmetric viscous friction", "motor_1", -0.362, -0.362, "1"),
        ),
        source="published by the authors: forward 166.7 N s/m and 20.14 N, backward 240.4 N s/m and 20.63 N",
        by_hand=(
            "coulomb_friction@motor_1:level=20.386,asymmetry=-0.0237",
            "viscous_friction@motor_1:asymmetry=-0.362",
        ),
    ),
    Case(
        name="ur10e_base_joint",
        title="Base joint of a UR10e",
        about=f"{_UR} 100 Hz nearly, 63 s; the other joints stand still, the arm is upright. Nominal: published "
        "inertia, tolerance 5 %, no friction. A single log: its last third is not fitted.",
        folder="dynamic_calibration",
        robot="ur10e_base_joint_robot.yaml",
        mapping="ur10e_base_joint.yaml",
        fitted=("dataset_ur10e/jointwise_motion/ur-20_01_22-joint_1.csv",),
        known=(_viscous(1, _UR_FRICTION[0][0]), _coulomb(1, _UR_FRICTION[0][1])),
        source="published in UR10E_parameters.txt",
        by_hand=("viscous_friction@motor_1:coefficient=23.1", "coulomb_friction@motor_1:level=12.8"),
        fetched=True,
    ),
    Case(
        name="ur10e",
        title="Six axes of a UR10e",
        about=f"{_UR} 100 Hz nearly, 49 s. Nominal: its URDF by `flexros import-urdf`, tolerance 3 %, without "
        "rotor inertia and friction. That import turns the axis of wrist 2 round, so joint 5 has the "
        "opposite sign in the mapping: with it the torques of the robot file are those of the URDF, and "
        "after friction 0.43 instead of 0.55 Nm rms of the torque of joint 5 are left. The published "
        "model has more inertia than the URDF, by 4.4, 6.8, 1.3, 0.21, 0.36 and 0.47 kg m2 on average "
        "over postures, and another gravity, by 9 Nm rms at joint 2.",
        folder="dynamic_calibration",
        robot="URe/urdf/ur10e.urdf",
        mapping="ur10e.yaml",
        fitted=(f"{_UR_LOGS}/ur-20_02_12-40sec_12harm.csv",),
        further={
            name: (f"{_UR_LOGS}/ur-20_02_{name}.csv",)
            for name in ("10-30sec_12harm", "12-50sec_12harm", "06-20sec_10harm")
        },
        known=tuple(
            one
            for joint, (viscous, level) in enumerate(_UR_FRICTION, start=1)
            for one in (_viscous(joint, viscous), _coulomb(joint, level))
        ),
        source="published in UR10E_parameters.txt; by hand also the missing inertia",
        by_hand=tuple(
            text
            for joint, (viscous, level) in enumerate(_UR_FRICTION, start=1)
            for text in (
                f"viscous_friction@motor_{joint}:coefficient={viscous}",
                f"coulomb_friction@motor_{joint}:level={level}",
            )
        ),
        numbers_by_hand={
            f"motor_{joint}.inertia": value
            for joint, value in enumerate((4.36, 6.79, 1.28, 0.206, 0.356, 0.472), start=1)
        },
        fetched=True,
    ),
    Case(
        name="panda",
        title="Seven axes of a Franka Emika Panda",
        about="Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca (2019), [github.com/marcocognetti/"
        "FrankaEmikaPandaDynModel](https://github.com/marcocognetti/FrankaEmikaPandaDynModel), GPL-3: fetched by "
        "`fetch_real_robots.py`. 1 kHz, 21 s, torques by the joint sensors; the recorder polled the controller. "
        "Nominal: the published rigid model without its friction, tolerance 3 %. A single log: its last third is not "
        "fitted.",
        folder="FrankaEmikaPandaDynModel",
        robot="panda_robot.yaml",
        mapping="panda.yaml",
        fitted=("panda.csv",),
        known=tuple(_coulomb(joint, low, high) for joint, (low, high) in enumerate(_PANDA_FRICTION, start=1)),
        source="least squares of the torque of this log, with viscous friction beside it, and half of the step of the "
        "published sigmoids, which have none",
        by_hand=tuple(
            f"coulomb_friction@motor_{joint}:level={high}" for joint, (_, high) in enumerate(_PANDA_FRICTION, start=1)
        ),
        fetched=True,
    ),
    Case(
        name="lwr4",
        title="Seven axes of a KUKA LWR4+",
        about="Advanced Robotics, Istituto Italiano di Tecnologia, [github.com/kjyv/FloBaRoID]"
        "(https://github.com/kjyv/FloBaRoID), LGPL-3: fetched by `fetch_real_robots.py`. 200 Hz, 25 s per log, torques "
        "by the joint sensors, all signals low-passed without phase. Nominal: the URDF of the repository, with rough "
        "masses and viscous friction, tolerance 3 %, by `flexros import-urdf`, without its dry friction. Log 2 is the "
        "same motion again, log 3 another one at twice the speed. The fit by MuJoCo ends with armatures of 2 to 807 kg "
        "m2, which predict so slow a motion by its speed alone: its shares say nothing of the robot. That errors and "
        "offsets of torques count was developed on this log and on that of the xMate.",
        folder="FloBaRoID",
        robot="model/kuka_lwr4.urdf",
        mapping="kuka_lwr4.yaml",
        fitted=("data/KUKA/HW/measurements_1.npz",),
        further={f"measurements_{number}": (f"data/KUKA/HW/measurements_{number}.npz",) for number in (2, 3)},
        known=tuple(_coulomb(joint, low, high) for joint, (low, high) in enumerate(_LWR_COULOMB, start=1)),
        source="least squares of the torque of each log, with viscous friction and offsets beside it, and the tutorial "
        "of the repository",
        by_hand=tuple(
            f"coulomb_friction@motor_{joint}:level={level}" for joint, (level, _) in enumerate(_LWR_BY_HAND, start=1)
        ),
        numbers_by_hand={
            f"motor_{joint}.viscous_friction": viscous for joint, (_, viscous) in enumerate(_LWR_BY_HAND, start=1)
        },
        fetched=True,
    ),
    Case(
        name="tx40",
        title="Six axes of a Staubli TX40",
        about="The example of FIGAROH, [github.com/thanhndv212/figaroh-examples](https://github.com/thanhndv212/"
        "figaroh-examples), no licence stated: fetched by `fetch_real_robots.py`. 5 kHz, 9 s, torques by currents; "
        "the wrist is coupled: motor 6 turns by the sum of joints 5 and 6, as does its friction. Nominal: its URDF, "
        "without friction and rotors, tolerance 3 %. A single log: its last third is not fitted. Without the coupling, "
        "which the library does not have, least squares with free bodies finds 6.7 and 3.2 Nm, 1.3 and 0.57 Nm s/rad "
        "at joints 5 and 6 as well; with it 2.7 and 2.4 Nm, 1.3 and 0.63 Nm s/rad, that of joint and motor 6 added.",
        folder="figaroh-examples",
        robot="examples/staubli_TX40/urdf/tx40_mdh_modified.urdf",
        mapping="tx40.yaml",
        fitted=("tx40.csv",),
        known=(
            *(_coulomb(joint, *sizes) for joint, sizes in enumerate(_TX40_COULOMB, start=1)),
            *(Known("viscous friction", f"motor_{k}", *sizes, "Nm s/rad") for k, sizes in enumerate(_TX40_VISCOUS, 1)),
        ),
        source="the configuration of the example; at joint 5 without to with the friction of motor 6, at joint 6 that "
        "of the joint and of the motor",
        fetched=True,
    ),
    Case(
        name="xmate7p",
        title="Seven axes of a Rokae xMate 7 Pro",
        about="[github.com/NKU-ZiXuan/xMate7p_dyn_ident](https://github.com/NKU-ZiXuan/xMate7p_dyn_ident), CC BY-NC-SA "
        "4.0: fetched by `fetch_real_robots.py`. 50 Hz, three logs of 20 s. Nominal: its URDF, without friction and "
        "rotors, tolerance 3 %; by least squares the real arm has first moments about 1.3 times as large. With all "
        "tolerances free, predictions alone determine the Coulomb friction of joints 1, 2, 3 and 5 to 0.3, 2.3, 1 and "
        "0.4 Nm only (standard deviations). That errors and offsets of torques count was developed on this log and on "
        "that of the LWR4+, that bodies may be off by more than their tolerance on this one.",
        folder="xMate7p_dyn_ident",
        robot="data/robotparams/XM7p/urdf/XM7p.urdf",
        mapping="xmate7p.yaml",
        fitted=("data/recdata/xMate7p_traj1_results.csv",),
        further={f"traj{log}": (f"data/recdata/xMate7p_traj{log}_results.csv",) for log in (2, 3)},
        known=tuple(_coulomb(joint, low, high) for joint, (low, high) in enumerate(_XMATE_COULOMB, start=1)),
        source="least squares of the torque of each of the three logs, with viscous friction beside it, which is zero "
        "within its deviation at most joints",
        fetched=True,
    ),
    Case(
        name="med7",
        title="Seven axes of a KUKA LBR Med7",
        about="[github.com/lbr-stack/dynamic_parameter_identification](https://github.com/lbr-stack/"
        "dynamic_parameter_identification), MIT by its package.xml: fetched by `fetch_real_robots.py`. One log of 16 "
        "s, 100 Hz as in its programs; its positions have no noise, a fifth of them stands still, and its torques, of "
        "sensors behind the gears, count the other way round at every joint, which the proposed mapping says. Nominal: "
        "its URDF with the damping of 10 Nm s/rad that it has at every joint, which `flexros diagnose` replaces by "
        "zero and says so, tolerance 3 %. By least squares the weight at joints 2, 4 and 6 is 1.2, 1.3 and 1.9 times "
        "that of the URDF. In its first run the program prescribed the motion of joint 7 for that damping, and the "
        "verdict was `unknown_effect`: that was mended with this robot in view. A single log: its last third is not "
        "fitted.",
        folder="dynamic_parameter_identification",
        robot="urdf/med/med7dock.urdf",
        mapping="med7.yaml",
        fitted=("src/test/measurements.csv",),
        known=tuple(_coulomb(joint, low, high) for joint, (low, high) in enumerate(_MED7_COULOMB, start=2)),
        source="least squares of the torque of the whole log, by `flexros identify rigid` and by another program; that "
        "of joint 1 is zero within its deviation",
        fetched=True,
    ),
    Case(
        name="ar5",
        title="Seven axes of a Rokae AR5",
        about="[github.com/FrankJIE09/Dynamics_identification_Frank]"
        "(https://github.com/FrankJIE09/Dynamics_identification_Frank), no licence stated: fetched by "
        "`fetch_real_robots.py`. 50 Hz, 60 s. Nominal: its URDF by `flexros import-urdf`, tolerance 3 %, without "
        "rotors and friction. The arm is on its side, which its URDF does not say: with gravity along -z `flexros "
        "diagnose` refuses the log and tells `gravity: [9.81, 0, 0]`, which the robot file here has. That check was "
        "written with this robot in view; before, rotors of 133 kg m2 and a counterbalance of 43 Nm were found, and "
        "least squares left 92 % of the torque. A single log: its last third is not fitted.",
        folder="Dynamics_identification_Frank",
        robot="ar5_robot.yaml",
        mapping="ar5.yaml",
        fitted=("src/config/dynamics_identification_data_real.csv",),
        known=tuple(_coulomb(joint, low, high) for joint, (low, high) in enumerate(_AR5_COULOMB, start=1)),
        source="published with the data, and least squares of the torque of the whole log, with viscous friction "
        "beside it, which is zero within its deviation at most joints and comes out negative at joints 4 and 6",
        fetched=True,
    ),
    Case(
        name="kr300",
        title="Six axes of a KUKA KR 300 R2500",
        about="Weigand, Ulmen, Janot and Ruskowski (2021), [github.com/JonasWeigand/Robot_Identification]"
        "(https://github.com/JonasWeigand/Robot_Identification), MIT: fetched by `fetch_real_robots.py`. 250 Hz, three "
        "logs of 10 s; a hydraulic cylinder at joint 2 carries weight, and the arm of 0.9 t carries up to 200 kg. "
        "Nominal: the masses and inertias of its CAD model, tolerance 3 %, without friction, rotors, cylinder and "
        "load. Of all samples of the first log, not only those above 1 deg/s, least squares finds 134 instead of 77 Nm "
        "of Coulomb friction at joint 4; its Coulomb and viscous friction of joint 3 are hardly told apart. "
        "The first log is fitted; with one of the other two fitted instead the load is not found, and the "
        "verdict is `unknown_effect`. The counterbalance of the library was written with this robot in view.",
        folder="Robot_Identification",
        robot="kr300_robot.yaml",
        mapping="kr300.yaml",
        fitted=(_KR300_LOG.format("A"),),
        further={name: (_KR300_LOG.format(name),) for name in "BC"},
        known=_frictions(_KR300_COULOMB, _KR300_VISCOUS),
        source="published with the data (Coulomb friction by the sum of its two steps), and least squares of the "
        "torque of each of the three logs above 1 deg/s, with a load of 180 kg, rotors, and a torque over sine and "
        "cosine of the position of each joint",
        fetched=True,
    ),
    Case(
        name="six_axis_arm",
        title="Six axes of an arm of unnamed make",
        about="JiyGuo, [github.com/JiyGuo/dynamical_identification](https://github.com/JiyGuo/"
        "dynamical_identification), no licence stated: fetched by `fetch_real_robots.py`. 1 kHz, four logs of 49 to "
        "69 s with a motion of 20 s each; before and after it the drives are off, all torques are zero and brakes hold "
        "the arm, which does not count, and the last third of the motion is held out, not of the log: both were "
        "written with this robot in view. In its first run, without them, the same twelve frictions were named with "
        "the right size, in 546 s, and a rest was held out. Nominal: the published lengths with masses, inertias and "
        "rotors by least squares of a fifth log of this robot, 20210329_5, feasible and without "
        "the friction found beside them, tolerance 3 %.",
        folder="dynamical_identification",
        robot="six_axis_arm_robot.yaml",
        mapping="six_axis_arm.yaml",
        fitted=_six_axis("20210325_1"),
        further={name: _six_axis(name) for name in ("20210329_2", "20210329_3", "20210329_4")},
        known=_frictions(_SIX_AXIS_COULOMB, _SIX_AXIS_VISCOUS),
        source="least squares of the torque of each of five logs with all 36 base parameters and rotors, low-passed at "
        "8 Hz; it leaves 7 to 15 % of the torque of another log",
        fetched=True,
    ),
    Case(
        name="ur10",
        title="Six axes of a UR10",
        about="Automatic Control Group of the University of Salerno, [github.com/unisa-acg/inverse-dynamics-solver]"
        "(https://github.com/unisa-acg/inverse-dynamics-solver), BSD-3-Clause: fetched by `fetch_real_robots.py`. A "
        "ROS 2 bag of 28 s at 125 Hz with measured torques; its positions were smoothed, so that the encoders seem to "
        "have a noise of 1e-9 rad. Nominal: masses, inertias and lengths of the public URDF of a UR10, without "
        "friction and rotors, tolerance 3 %. A single log: its last third is not fitted. The program as it was before "
        "this robot named one friction per joint, closed 96 % and took 470 s of processor time: the friction of the "
        "light wrist made its prediction diverge, and the search began with nothing.",
        folder="inverse-dynamics-solver",
        robot="ur10_robot.yaml",
        mapping="ur10.yaml",
        fitted=("ur10_inverse_dynamics_solver/bagfiles/ur10_exciting_trajectory.db3",),
        known=_frictions([(dry,) for dry, _ in _UR10_FRICTION], [(wet, wet) for _, wet in _UR10_FRICTION]),
        source="least squares of the torque of this log, with all numbers of the rigid model beside it",
        fetched=True,
    ),
    Case(
        name="tiago_arm",
        title="Four axes of the arm of a PAL TIAGo",
        about="The example of FIGAROH, [github.com/thanhndv212/figaroh-examples](https://github.com/thanhndv212/"
        "figaroh-examples), no licence stated: fetched by `fetch_real_robots.py`. 100 Hz, 59 s, currents in steps of "
        "1 mA; gears and torque constants as in its `identification.py`. The currents of the wrist are a "
        "twentieth of what its weight takes; so column and wrist are fixed in the model here; in the next case the "
        "wrist moves as it was measured to. Nominal: its URDF, with the damping of 1 Nm s/rad that it has at every "
        "joint, without its dry friction of 1 Nm, rotors and hand, tolerance 3 %. The first half is fitted, the second "
        "is not.",
        folder="figaroh-examples",
        robot="tiago_arm_robot.yaml",
        mapping="tiago_arm.yaml",
        fitted=("tiago_position_1.csv", "tiago_effort_1.csv"),
        further={"second half": ("tiago_position_2.csv", "tiago_effort_2.csv")},
        known=_frictions([(dry,) for dry, _ in _TIAGO_FRICTION], [(wet, wet) for _, wet in _TIAGO_FRICTION], 1.0),
        source="least squares of the torque of the fitted half, with all numbers of the rigid model beside it",
        fetched=True,
    ),
    Case(
        name="tiago_arm_and_wrist",
        title="Seven axes of the arm of a PAL TIAGo",
        about="The same logs with the wrist, whose motion is prescribed in both, as its currents are no torques of it; "
        "in the fitted one the diagnosis notices all three joints by itself, in the other one two of them. Nominal as "
        "above, with the wrist. Least squares takes the torques of all seven axes.",
        folder="figaroh-examples",
        robot="tiago_arm_and_wrist_robot.yaml",
        mapping="tiago_arm_and_wrist.yaml",
        fitted=("tiago_position_1.csv", "tiago_effort_1.csv"),
        further={"second half": ("tiago_position_2.csv", "tiago_effort_2.csv")},
        known=_frictions([(dry,) for dry, _ in _TIAGO_FRICTION], [(wet, wet) for _, wet in _TIAGO_FRICTION], 1.0),
        source="least squares of the torque of the fitted half with column and wrist fixed, as above",
        by_mujoco="our wrapper of it needs the torques of all joints",
        fetched=True,
        prescribed=("motor_5", "motor_6", "motor_7"),
    ),
    Case(
        name="gen3",
        title="Seven axes of a Kinova Gen3",
        about="[github.com/wissem01chiha/dynamic-identification]"
        "(https://github.com/wissem01chiha/dynamic-identification), MIT, later CC0: fetched by `fetch_real_robots.py`. "
        "1 kHz, three logs of 2 to 5 s in which most joints turn in one direction only; torques by the currents of the "
        "motors. Nominal: its URDF, without friction and rotors, tolerance 3 %. That a constant torque of a motor that "
        "turns in one direction only is its friction was found on this robot: in its first run offsets of 5 Nm stood "
        "for it, and the patch closed 99 % of the first and -28,155 % of the second of the logs that were not fitted. "
        "The URDF lacks the gripper of 0.55 kg; rotors stood for its weight, and the patch closed 31 % of the second "
        "log, until a load counted that explains more than errors of all bodies: written with this robot in view. "
        "The patch has the rotors that the fitted log shows; for least squares they are estimated from the log in "
        "question.",
        folder="dynamic-identification",
        robot="robots/kinovaGen3.urdf",
        mapping="gen3.yaml",
        fitted=(f"{_GEN3}/validation_data/opti_traj_testing1.csv",),
        further={
            "opti_traj_testing2": (f"{_GEN3}/validation_data/opti_traj_testing2.csv",),
            "RecordTrajectory_quadratic": (f"{_GEN3}/identification_data/RecordTrajectory_quadratic.csv",),
        },
        known=_frictions(_GEN3_COULOMB, _GEN3_VISCOUS),
        source="least squares of the torque of each of the three logs, with all numbers of the rigid model beside it, "
        "which come out infeasible: these short moves hardly determine them",
        fetched=True,
    ),
    Case(
        name="wam",
        title="Two axes of a Barrett WAM",
        about="[github.com/amir-noohian/dynamics-estimation](https://github.com/amir-noohian/dynamics-estimation), no "
        "licence stated: fetched by `fetch_real_robots.py`. 250 Hz, 10 s, a JSON file; joints 2 and 4 move, the others "
        "rest at zero. Nominal: masses of the CAD model in github.com/cdsousa/wam7_dyn_ident as a planar arm, without "
        "the hand that it carries, friction and rotors, tolerance 5 %. A single log: its last third is not fitted. "
        "The program as it was before this robot gave the same answer.",
        folder="dynamics-estimation",
        robot="wam_robot.yaml",
        mapping="wam.yaml",
        fitted=("pest_2dof_nogravity/wam_data/state_4.json",),
        known=_frictions(((2.12, 2.42), (0.269, 0.357)), ((1.23, 1.71), (0.645, 0.687))),
        source="published with the data, and least squares of the torque of this log with all numbers of the rigid "
        "model beside it, which has a load of about 1.3 kg at 0.4 m from the elbow",
        fetched=True,
    ),
    Case(
        name="hobby_servo",
        title="Hobby servo under position commands",
        about="A servo of 25 kg cm with an arm of 0.35 kg, [github.com/mauicv/servo-sysid]"
        "(https://github.com/mauicv/servo-sysid), no licence stated: fetched by `fetch_real_robots.py`. Position "
        "commands alone, at 50 Hz: pseudo-random steps, squares, triangles, ramps and a chirp of 2 to 3 s each, with "
        "pauses between them. Nominal: the MJCF of its authors, whose filter of the command (0.1 s) has no place in a "
        "robot file, tolerance 3 %. Every other experiment is fitted; not fitted are the others, and their first "
        "recordings. The fit of servos at their torque limits was written with this log in view.",
        folder="servo-sysid",
        robot="hobby_servo_robot.yaml",
        mapping="hobby_servo.yaml",
        fitted=("log_1.csv",),
        further={name: (f"{name}.csv",) for name in ("log_2", "first_recordings")},
        known=(Known("viscous friction", "motor_1", 0.60, 0.74, "Nm s/rad"), _coulomb(1, 0.63, 1.03)),
        source="least squares of free runs from rest in all experiments by `python "
        "docs/results/programs/measured/servo_free_runs.py fetched`, with the damping of the loop within or "
        "beyond the torque limit (then it counts as viscous friction) and the weight of the arm free or not, "
        "beside torque limits of 3.7 to 4.6 Nm (2.7 in the MJCF) and delays of 18 to 44 ms; these models leave "
        "0.09 to 0.12 rad rms",
        by_mujoco=_NO_TORQUE,
        fetched=True,
    ),
    _go2("FL", "front left"),
    _go2("FR", "front right"),
    _go2("RL", "rear left"),
    _go2("RR", "rear right"),
    Case(
        name="xl330",
        title="Dynamixel XL330 under position commands",
        about="Rhoban, [github.com/Rhoban/bam](https://github.com/Rhoban/bam), branch xl330, Apache-2.0: fetched by "
        "`fetch_real_robots.py`. A pendulum of 0.49 kg at 0.1 m, 6 s at 188 Hz each, position commands alone that "
        "count. Nominal: data sheet and manual of the servo, tolerance 10 %, of the pendulum 2 %. The gain of the "
        "manual is twice that of the drive, as its authors found too. Of its logs this one was chosen as fitted with "
        "the answers in view: with that of `sin_time_square` fitted, whose fast end is its last third, the friction is "
        "named (0.400 +- 0.020) and the stiffness is not.",
        folder="bam",
        robot="xl330_robot.yaml",
        mapping="xl330.yaml",
        fitted=("bam/data.bak/raw/2026-01-15_10h29m14.json",),
        further={
            "sin_time_square": ("bam/data.bak/raw/2026-01-15_10h29m37.json",),
            "up_and_down": ("bam/data.bak/raw/2026-01-15_10h29m29.json",),
        },
        known=(
            Known("servo stiffness", "motor_1", 0.756, 0.784, "Nm/rad", 1.77),
            Known("load dependent friction", "motor_1", 0.388, 0.546, "1"),
        ),
        source="least squares of free runs through the first two logs and through all three by `python "
        "docs/results/programs/measured/xl330_free_runs.py fetched`, smallest and largest; they leave 18 to 36 mrad "
        "rms. The third log alone moves too slowly: its rotor is at the limit of the search",
        by_mujoco=_NO_TORQUE,
        fetched=True,
        in_hindsight=True,
    ),
    Case(
        name="so101",
        title="Five axes of an SO-101 under position commands",
        about="NVIDIA SAGE, [github.com/isaac-sim2real/sage](https://github.com/isaac-sim2real/sage), Apache-2.0: "
        "fetched by `fetch_real_robots.py`. Hobby servos, position commands alone that count, 50 Hz, 120 s each; the "
        "currents have no sign and the gripper no angle. Nominal: the MJCF of the arm, "
        "[github.com/TheRobotStudio/SO-ARM100](https://github.com/TheRobotStudio/SO-ARM100), Apache-2.0, by `flexros "
        "import-mjcf --end gripper`, whose gain of 998 Nm/rad makes a simulator stiff, without its dry friction of "
        "0.052 Nm, tolerance 3 %. The gains by the weight of the arm were written with this log in view.",
        folder="sage",
        robot="so101_robot.yaml",
        mapping="so101.yaml",
        fitted=_so101("multisine"),
        further={name: _so101(name) for name in ("friction_gravity", "large_amplitude")},
        known=tuple(
            one
            for joint, (stiffness, coulomb) in _SO101_FREE_RUNS.items()
            for one in (
                Known("servo stiffness", f"motor_{joint}", *stiffness, "Nm/rad", 998.22),
                _coulomb(joint, *coulomb),
            )
        ),
        source="least squares of free runs of MuJoCo through 60 s of two of its logs by `python "
        "docs/results/programs/measured/so101_free_runs.py fetched`, smallest and largest; they leave 3 to 4 mrad "
        "rms. Of joints 1 and 5, which carry no weight, positions show the ratio of friction and stiffness alone",
        by_mujoco=_NO_TORQUE,
        fetched=True,
    ),
    Case(
        name="flexible_link",
        title="Rotary flexible link",
        about="Leylaz, Ma and Sun, [github.com/gleylaz/Optimal_SysID](https://github.com/gleylaz/Optimal_SysID), no "
        "licence stated: fetched by `fetch_real_robots.py`. 500 Hz, 5 s. Nominal: numbers of the maker, tolerance "
        "10 %. A single log: its last third is not fitted.",
        folder="Optimal_SysID",
        robot="flexible_link_robot.yaml",
        mapping="flexible_link.yaml",
        fitted=("Data/data_theta.mat", "Data/data_alpha.mat", "Data/data_vm.mat"),
        known=(_coulomb(1, 0.013, 0.052),),
        source="least squares of the torque with the strain gauge 13 mNm; with this model 26 mNm alone, 52 mNm with "
        "its other numbers fitted too",
        by_mujoco=_SECOND_STATE,
        fetched=True,
    ),
)
"""All cases, in the order of the page."""
