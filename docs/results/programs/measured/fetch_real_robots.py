"""Fetch public logs of robots: python docs/results/programs/measured/fetch_real_robots.py FOLDER [--from PATH]...

The logs of nineteen public repositories, most of them without a licence for copies, are brought into FOLDER, at the
commits below and with their checksums; they are not part of this repository. `--from` names a clone, a bare clone or a
plain folder of one of them that is there already. What cannot be reached is skipped with its reason, and the exit code
is then 1.
"""

from __future__ import annotations

import argparse
import hashlib
import itertools
import json
import math
import subprocess
import sys
import urllib.error
import urllib.parse
import urllib.request
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from quadruped_legs import LOG, MODEL, assemble_go2

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

TIMEOUT = 30.0
"""Longest wait for an answer of the server [s]."""


PANDA_LOG = "matlab/data/Exciting_Traj/Trajectory_1/rbt_log/exciting_traj"
"""Begin of the names of the files of the Panda: one value per line, seven of each sample."""


LWR_LOG = "data/KUKA/HW/measurements"
"""Begin of the names of the logs of the LWR4+."""


TX40 = "examples/staubli_TX40"
"""Folder of the files of the TX40: positions and torques of the motors, in a table each."""


KR300_LOG = "data/recorded_trajectories/2020-10-21 10s FF {} 08ms/data.mat"
"""Files of the KR 300: three motions."""


SERVO = "src/sysid/dataset"
"""Folder of the files of the hobby servo: experiments with commanded and measured positions, each from rest."""


SERVO_PAUSE = 2.0
"""Time between two of its experiments in the assembled logs [s]: the servo returns to its middle, unrecorded."""


TIAGO = "examples/tiago/data/identification/dynamic"
"""Folder of the files of the arm of TIAGo: positions and currents of the motors, in a table each."""


TIAGO_PARTS = (921, 3921, 6791)
"""Rows between which the arm moves, as in the example, divided in two [1]."""


GEN3 = "pyDynaMapp/data/kinova"
"""Folder of the logs of the Gen3, a table each."""


SO101 = "output/real/so101/custom"
"""Folder of the motions of the SO-101, a folder each: positions, and commanded positions."""


WAM = "pest_2dof_nogravity/wam_data"
"""Folder of the log of the WAM."""


XL330_LOG = "bam/data.bak/raw/2026-01-15_10h29m{}.json"
"""Files of the XL330: its pendulum under several commands."""

PENDULUM_LOG = "results/control_method_{}/data_measured.csv"
"""Files of the pendulum: swing-ups under several controllers."""


@dataclass(frozen=True)
class Repository:
    """A public repository at a commit.

    Attributes:
        owner: Its owner.
        name: Its name, which is also that of the folder of its files.
        commit: The commit.
        files: SHA-256 of each file by its path.
    """

    owner: str
    name: str
    commit: str
    files: Mapping[str, str]

    def url(self, path: str) -> str:
        """Return the address of a file."""
        return f"https://raw.githubusercontent.com/{self.owner}/{self.name}/{self.commit}/{urllib.parse.quote(path)}"


REPOSITORIES = (
    Repository(
        "shamilmamedov",
        "dynamic_calibration",
        "11af40e7deb758ec080a175fed8fcdd6c99aca29",
        {
            "UR10E_parameters.txt": ("2c6be2d67d9b0512bd96936673caaedfba3fbc279fd7edde0b111df4b37bd677"),
            "URe/urdf/ur10e.urdf": ("0d2abc6ebc70725c691a35aa6c2d03fd6e8158017a1b7da7a10a3ef52de7b821"),
            "dataset_ur10e/identification_data/ur-20_02_12-40sec_12harm.csv": (
                "1355f739afecc5a9330f906e0c403be0080407f5ce2c26652556fac5748c6236"
            ),
            "dataset_ur10e/identification_data/ur-20_02_10-30sec_12harm.csv": (
                "341fff80f177be564c8720ea898165addfd46d7cbe6f3ffd8923eeaae0eef000"
            ),
            "dataset_ur10e/identification_data/ur-20_02_12-50sec_12harm.csv": (
                "bb48cca42716a88f8b255d2d1b3eb3fa4a6eac4a9a52b694d4c1066ce8b4ca51"
            ),
            "dataset_ur10e/identification_data/ur-20_02_06-20sec_10harm.csv": (
                "8959c47c991221e88a467a584c756a2f0f17c8268a291437709513cc112739c8"
            ),
            "dataset_ur10e/jointwise_motion/ur-20_01_22-joint_1.csv": (
                "29cbb22afa01aae4a7e2fedaf63d6df90ef98decb1ec74a9b4863d2bc4d5eda0"
            ),
        },
    ),
    Repository(
        "gleylaz",
        "Optimal_SysID",
        "6eacf84a3d639e0f976bd1451b0ef6771ab7a46d",
        {
            "RotaryFlexibleLinkIdentification.m": ("ffbffc7d06ee3d1151a33afdf97d2189c75416d258eb9096c93ae1ce59b96914"),
            "Data/data_alpha.mat": ("43c1d7d835cdb09df640d0d8645628e64093ada71bf65fda897aa2eb47e3b347"),
            "Data/data_theta.mat": ("e45d369d68dbd1271ff44adb39a31f78757829c65dc0a03401deaa8e897c986a"),
            "Data/data_vm.mat": ("b0657ef64eefa83955009884994049786cc8294b6b5fb6b3628d45928ecd21b9"),
        },
    ),
    Repository(
        "marcocognetti",
        "FrankaEmikaPandaDynModel",
        "24d85ce4e648e2e894c832bfeee9b16711eb1a1a",
        {
            f"{PANDA_LOG}_positions.txt": ("50bf82a082c439aff8220e8142985c8dd783f7ddc1415987cd75c9efb88bcf69"),
            f"{PANDA_LOG}_torques.txt": ("11fda32785bb29ce444e14e0f45f4893aab7142dc6ee29576d828ab154852f9c"),
            f"{PANDA_LOG}_time.txt": ("031063612f297011dc005ab29830903e36f4bfeba77bce59c0fbde13620fb20d"),
        },
    ),
    Repository(
        "kjyv",
        "FloBaRoID",
        "4e2e5a2992f2175aa4e494c0d827590435a969a8",  # later ones have no more than pointers to the logs
        {
            f"{LWR_LOG}_1.npz": "55b94c07e86a75311a584cc945c4436e7a5dbeafd5f7378a53225a0dd820c1fd",
            f"{LWR_LOG}_2.npz": "e15b6df10dd26ecdd3f870bf9a908184207db26f13ae34b9e96931ab9fa14de8",
            f"{LWR_LOG}_3.npz": "4ca527bbac6d6f299e9478451c6b1f059672bf38859e218b0b37fc20bd783acd",
        },
    ),
    Repository(
        "kjyv",
        "FloBaRoID",
        "9c0680445e874947bac4056cd86ff9e26bdd7fcb",
        {"model/kuka_lwr4.urdf": "8fd76631f12b38404812bc343e998cc9ca3af18d850856c5b050b39ab6fc62ad"},
    ),
    Repository(
        "thanhndv212",
        "figaroh-examples",
        "c0b5c7f0fda10078be55104f9ee76ac106b7a5ee",
        {
            f"{TX40}/data/curr_data.csv": ("f4592f4ba4db42f5d7625688986be25b575ca34d0504b27979ca6b0276bd3af9"),
            f"{TX40}/data/pos_read_data.csv": ("5cc1cecc1024ef0e331d0caba06f689456ab789ec3f1e904599c0a8be5c27bc8"),
            f"{TX40}/urdf/tx40_mdh_modified.urdf": ("3d00cbd46279c915d594b1bb4610dbac78d1e99ed27f95de70984bde13486074"),
            f"{TIAGO}/tiago_position.csv": "4297a60d434ee89f1f424ad0da8ec65bc00072ac57eb06b94966c0819fc2786d",
            f"{TIAGO}/tiago_effort.csv": "12c635987705efade603426a600f5b315add7f580c720a4b84609dadb9d0a2e9",
        },
    ),
    Repository(
        "NKU-ZiXuan",
        "xMate7p_dyn_ident",
        "7d8c9246adfc2a14d161df41a21a70671471ac1c",
        {
            "data/robotparams/XM7p/urdf/XM7p.urdf": (
                "525104b34c64a42504ebca5741ad0d0b0963ae8d62de17b6159b2bf56194dfe4"
            ),
            "data/recdata/xMate7p_traj1_results.csv": (
                "84bcef00b1410b98f962d6edf354e3aa5f11c43c9645b8b7bdfb8b4dad87d67f"
            ),
            "data/recdata/xMate7p_traj2_results.csv": (
                "9fe697240cc64a06306c12aaa36c21f51619facccc92d0b0de51d07519806dfc"
            ),
            "data/recdata/xMate7p_traj3_results.csv": (
                "b8cf0a91bf58d4afafa7a65c9e69c7916ad63759248ef60e477c59db1d0af5e6"
            ),
        },
    ),
    Repository(
        "JonasWeigand",
        "Robot_Identification",
        "9e403c07d9dadbb391a9f3921e8d219f714636a8",
        {
            KR300_LOG.format("A"): ("4c152c5b7f2c899731fdeebcf0d011cc103df72be19fac160caf47aa9b73ab75"),
            KR300_LOG.format("B"): ("edeb35f65c4ec4bb697e757fc1e4e9668551b6fe7b2c3dbbb526d040dd8d5ce7"),
            KR300_LOG.format("C"): ("c5d5688521ece941e6c4afd39643a01cd36ae8c7790342640277f8b15b5515b4"),
        },
    ),
    Repository(
        "FrankJIE09",
        "Dynamics_identification_Frank",
        "758dc8d6f78e63ecba0aac16d28255ae045f1d3c",
        {
            "src/config/dynamics_identification_data_real.csv": (
                "1c58c840362a20bc00162f20e6c154dd40bae10e27f9b21bf2abd8b8cc50d578"
            ),
        },
    ),
    Repository(
        "mauicv",
        "servo-sysid",
        "e4a48407899108cae084ff25e8b5d12e3da070cc",
        {
            f"{SERVO}/dataset.json": "4561efd1d0f416e81c25ed5a6a085c81d05ac20378945177d398270f54c60511",
            f"{SERVO}/real-action-state-dataset.json": (
                "f676b2acc8672603161031aeca2bc16e847970cd59ac19c20bf7f558191a9d8d"
            ),
        },
    ),
    Repository(
        "iit-DLSLab",
        "sim2real-robot-identification",
        "06739ea0424fa8b2e141df0942ecdaf27a5c8600",
        {
            LOG: "f22b1625f331b724e84ebdae5b0679168307364ad93a1d9c3d9cf1620f38efb0",
            MODEL: "e66b59d1096b5b2004b6bc36bfcfc35480cd1e0c92ec68fc896ef8c0661e5b71",
        },
    ),
    Repository(
        "wissem01chiha",
        "dynamic-identification",
        "00dc27c7357b84b6c6ff7d56e9ce299428dec637",  # later ones have no logs
        {
            f"{GEN3}/validation_data/opti_traj_testing1.csv": (
                "0c9229ae8882a43fb1aac59c1b527a0942a99dcb0fe2aed77e948091fe8bf274"
            ),
            f"{GEN3}/validation_data/opti_traj_testing2.csv": (
                "e8e27ef2f4943a3a5b3632c319731473747507e58a512b29adde48a9d4769440"
            ),
            f"{GEN3}/identification_data/RecordTrajectory_quadratic.csv": (
                "82b68faf7b12f73f83e82acb6b6660b5cae28c702058f58269c87718f7ee9ed7"
            ),
        },
    ),
    Repository(
        "wissem01chiha",
        "dynamic-identification",
        "44f47d5640d89c7b97e584bb10163c4a2b3ced00",
        {"robots/kinovaGen3.urdf": ("09748ecfb4a0cf543066346a64a24b9edb46207103a68047fd26241c1320fbc3")},
    ),
    Repository(
        "amir-noohian",
        "dynamics-estimation",
        "855e9e5c0811f3a3716612741bc33c02574aabea",
        {
            f"{WAM}/state_4.json": ("eccb05e00cb6178170369f0ef14ccf66c8fbbb5f7aff859295da0c0ff62951c5"),
        },
    ),
    Repository(
        "unisa-acg",
        "inverse-dynamics-solver",
        "41e196de5ca340f2b48e443484a7c74a77533da4",
        {
            "ur10_inverse_dynamics_solver/bagfiles/ur10_exciting_trajectory.db3": (
                "14244fc39e9b42047039824f3c20ab984f9d1b28d5a67e9415cc1b3cc0ac3369"
            ),
        },
    ),
    Repository(
        "isaac-sim2real",
        "sage",
        "4ffd2627df9d23e279b35712a67e629ce0c0dfa7",
        {
            f"{SO101}/multisine/state_motor.csv": ("97d4112d4e83567b62e39e67c1eed515540bbba271a226df5ac796163e35d27b"),
            f"{SO101}/multisine/control.csv": ("99562591fb0e8cecae236670e14a13458d49a146bb6448c26cdec25935cd5a80"),
            f"{SO101}/friction_gravity/state_motor.csv": (
                "2f4ad531531dd6ee112ee874ec08f186b7f5b364a7176c4d14227a8e650a35e2"
            ),
            f"{SO101}/friction_gravity/control.csv": (
                "f2e53e26d4050ea8631542f10a6c6baa71274114641d9b688fbd4bca165dde0b"
            ),
            f"{SO101}/chirp_sweep/state_motor.csv": (
                "85e9bd89fbc1cb97d21eba269242aca4437a8faa2116859e96b458b7001579d8"
            ),
            f"{SO101}/chirp_sweep/control.csv": ("9b87d99cdbddfe72cf2f7ceddbde9290b5a47de996fe35f8f2c9a83a84917670"),
            f"{SO101}/large_amplitude/state_motor.csv": (
                "5df5a72a2473e9fbcfd939c41f733cc68a814d857e0e4edda9748c371e7deb94"
            ),
            f"{SO101}/large_amplitude/control.csv": (
                "8d9190103ee6d3e15cd01f20e9b404d9ce4f2c31cf8e5db574820af03294fae7"
            ),
        },
    ),
    Repository(
        "TheRobotStudio",
        "SO-ARM100",
        "fda892cba81032c46c40976a48c9ceadbf40a9ca",
        {
            "Simulation/SO101/so101_new_calib.xml": (
                "d75253eb568e8a7214db9c631ab7bed4217f608a26f7276ebe9a7636cac82580"
            ),
        },
    ),
    Repository(
        "dfki-ric-underactuated-lab",
        "torque_limited_simple_pendulum",
        "ed17ea2d32a35ad944944ca03ef57693e2986732",
        {
            "data/urdf/dfki_simple_pendulum.urdf": ("8f22afa7fe50ddc339a6895f7bc13e0bfe7d8178afce9a1fe5cc8ab2a0fef3a9"),
            f"{PENDULUM_LOG.format('ddp')}": ("14748fd189abae7b6392a016f2f0494b54bb2a8c014bc435a84b58dbecb2da35"),
            f"{PENDULUM_LOG.format('direct_collocation')}": (
                "c3f990980169815b93ab37078780e13803327dcb6fc9e019f2d261b988cdaf8f"
            ),
            f"{PENDULUM_LOG.format('pd/system_identification')}": (
                "3a5728e9c5530dd9066c0d7fda4c6a9bf50d86f94538629ace6d2508a7053469"
            ),
        },
    ),
    Repository(
        "lbr-stack",
        "dynamic_parameter_identification",
        "58b4d88014db54cdecac66fcc059b2c9fa131e46",
        {
            "urdf/med/med7dock.urdf": ("29b19bce6d82a5a991ad3a7d24da87ee19194ad165eaeb63911de824276f43de"),
            "src/test/measurements.csv": ("a1c7d3fb1c0e0224e938b5d3d0d72042534573072905f661a07f31dfa2addd4d"),
        },
    ),
    Repository(
        "Rhoban",
        "bam",
        "af2260462471ff45ac18af159b1327ea51d8db15",  # of its branch xl330; later ones have no logs
        {
            f"{XL330_LOG.format(14)}": "016d15d21c464457aa30eaeab3977228b08cd5acf7542f24067440126c0bf480",
            f"{XL330_LOG.format(37)}": "838d390b7190c4ce1608157cf629989648773b7336728a0931a61c6018c6700b",
            f"{XL330_LOG.format(29)}": "b9ce9fc0f396e6b03bd514e9254cb83b8a64e1a5df1728b9a10e3b4a5a9513ca",
        },
    ),
    Repository(
        "JiyGuo",
        "dynamical_identification",
        "951c48c29fed833875207f05b5c6ccd782737a6f",
        {
            "data/20210325_1/joint.mat": ("67cdc0d6e2b2bafa4c0929febae9a4bbdd19cd43bf4948a1f40700ef47998226"),
            "data/20210325_1/torque.mat": ("b2b050e393f43dcde4c23504db1c18c20844f6d272a225a38770b4d67d422404"),
            "data/20210329_2/joint.mat": ("775f10e208bd83a606fddbcc5cec8238234d27ac59bfff0baac86e395ebf9201"),
            "data/20210329_2/torque.mat": ("c393b6e6a34d21946ad07cae5606077e77389bc3fd814aad02febf875a92114b"),
            "data/20210329_3/joint.mat": ("c2a8031f74a212144f570c091548b62b79e804fce31e30ec9719d09ee36222cf"),
            "data/20210329_3/torque.mat": ("5418045564a965034644f2555b3af14937ab240d68b7074bcc8a918c0bdb9c8d"),
            "data/20210329_4/joint.mat": ("13fe5d901f62a1dfa250d1455ff33a14b1903142933082d4a17815ba9e0130c6"),
            "data/20210329_4/torque.mat": ("923f0ab638229f69f6be9dcf717ed9ddf96fe4821e4ed048852b1e25979c34f6"),
        },
    ),
)
"""The files that docs/results/programs/real_robots.py reads."""


def fetch(
    folder: Path, sources: Sequence[Path] = (), repositories: Sequence[Repository] = REPOSITORIES
) -> tuple[str, ...]:
    """Bring the files into a folder, whole or not at all; those that are there already are kept.

    Args:
        folder: The folder; the files of a repository are in a subfolder of its name.
        sources: Clones, bare clones or plain folders to take files from; default: they are downloaded.
        repositories: What is fetched.

    Returns:
        Why a file or the rest of a repository was skipped, a sentence each.
    """
    skipped = []
    for repository in repositories:
        for path, checksum in repository.files.items():
            target = folder / repository.name / path
            if target.is_file() and _checksum(target.read_bytes()) == checksum:
                continue
            try:
                content = _content(repository, path, sources)
            except OSError as error:
                reason = getattr(error, "reason", None) or error
                skipped.append(f"github.com/{repository.owner}/{repository.name}: {path}: {reason}")
                if isinstance(error, urllib.error.URLError) and not isinstance(error, urllib.error.HTTPError):
                    break  # the server cannot be reached: the other files could not be had either
                continue
            if _checksum(content) != checksum:
                skipped.append(f"{repository.name}: {path}: has another checksum than at {repository.commit[:7]}")
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            write_whole(target, content)
    return tuple(skipped)


def write_whole(path: Path, content: bytes | str) -> None:
    """Write a file under another name, and rename it: it is whole or not there.

    Args:
        path: The file.
        content: What it holds.
    """
    part = path.with_name(f".{path.name}.part")
    part.write_bytes(content.encode() if isinstance(content, str) else content)
    part.replace(path)


def assemble_panda(folder: Path) -> None:
    """Put positions and torques of the Panda into a CSV file with a row per sample, where they are there.

    Args:
        folder: The folder of the files of all repositories.
    """
    here = folder / "FrankaEmikaPandaDynModel"
    files = [here / f"{PANDA_LOG}_{name}.txt" for name in ("time", "positions", "torques")]
    if not all(file.is_file() for file in files):
        return
    time, position, torque = (file.read_text().split() for file in files)
    names = [f"{quantity}_{joint}" for quantity in ("position", "torque") for joint in range(1, 8)]
    rows = [
        ",".join((instant, *position[7 * row : 7 * row + 7], *torque[7 * row : 7 * row + 7]))
        for row, instant in enumerate(time)
    ]
    write_whole(here / "panda.csv", "\n".join((",".join(("time", *names)), *rows)) + "\n")


def assemble_tx40(folder: Path) -> None:
    """Put positions and torques of the motors of the TX40 into a CSV file, where they are there.

    Args:
        folder: The folder of the files of all repositories.
    """
    here = folder / "figaroh-examples"
    files = [here / TX40 / "data" / f"{name}.csv" for name in ("pos_read_data", "curr_data")]
    if not all(file.is_file() for file in files):
        return
    names = ",".join(f"{quantity}_{joint}" for quantity in ("position", "torque") for joint in range(1, 7))
    tables = [file.read_text().splitlines()[1:] for file in files]
    write_whole(here / "tx40.csv", "\n".join((names, *(",".join(rows) for rows in zip(*tables)))) + "\n")


def assemble_tiago(folder: Path) -> None:
    """Write the two halves of the log of TIAGo's arm, where it is there.

    Args:
        folder: The folder of the files of all repositories.
    """
    here = folder / "figaroh-examples"
    tables = [here / TIAGO / f"tiago_{name}.csv" for name in ("position", "effort")]
    if not all(file.is_file() for file in tables):
        return
    written = {}
    for table in tables:
        names, *rows = table.read_text().splitlines()
        for number, rows_of_part in enumerate(itertools.pairwise(TIAGO_PARTS), start=1):
            written[f"{table.stem}_{number}.csv"] = "\n".join((names, *rows[slice(*rows_of_part)])) + "\n"
    for name, content in written.items():
        write_whole(here / name, content)


def assemble_servo(folder: Path) -> None:
    """Put the experiments of the hobby servo into CSV files, every other one into each, where they are there.

    The first recordings, with other experiments, go into a file of their own. Of the others, single steps of 0.24 and
    1 s and falls without a command are left out.

    Args:
        folder: The folder of the files of all repositories.
    """
    here = folder / "servo-sysid"
    files = [here / SERVO / f"{name}.json" for name in ("dataset", "real-action-state-dataset")]
    if not all(file.is_file() for file in files):
        return
    experiments, first = (json.loads(file.read_text())["data"] for file in files)
    kinds = ("chirp", "prbs", "triangle", "ramp", "square")
    numbered = [(number, one) for number, one in enumerate(experiments) if one["type"] in kinds]
    logs = {f"log_{part + 1}": [one for number, one in numbered if number % 2 == part] for part in range(2)}
    for name, parts in (*logs.items(), ("first_recordings", first)):
        rows, begin = ["time,command,position"], 0.0
        for one in parts:  # both in half turns, 50 a second
            pairs = list(zip(one["actions"], one["sensor_data"], strict=True))
            rows += [
                f"{begin + k / 50:.2f},{math.pi * command:.8f},{math.pi * position:.8f}"
                for k, (command, position) in enumerate(pairs)
            ]
            begin += len(pairs) / 50 + SERVO_PAUSE
        write_whole(here / f"{name}.csv", "\n".join(rows) + "\n")


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _content(repository: Repository, path: str, sources: Sequence[Path]) -> bytes:
    """Read a file from the first source that has it, or download it where no source was given."""
    ways: tuple[Callable[[], bytes | None], ...] = tuple(
        way for source in sources for way in (_from_folder(source, path), _from_git(source, repository, path))
    )
    for way in ways:
        content = way()
        if content is not None:
            return content
    if sources:
        raise FileNotFoundError(f"is in none of {', '.join(map(str, sources))}")
    with urllib.request.urlopen(repository.url(path), timeout=TIMEOUT) as answer:  # noqa: S310 - https, written above
        content = answer.read()
    return bytes(content)


def _from_folder(source: Path, path: str) -> Callable[[], bytes | None]:
    return lambda: (source / path).read_bytes() if (source / path).is_file() else None


def _from_git(source: Path, repository: Repository, path: str) -> Callable[[], bytes | None]:
    def read() -> bytes | None:
        if not source.is_dir():
            return None
        command = ["git", "-C", str(source), "cat-file", "blob", f"{repository.commit}:{path}"]
        done = subprocess.run(command, capture_output=True, check=False)  # noqa: S603 - the commit and path above
        return done.stdout if done.returncode == 0 else None

    return read


def main() -> int:
    """Fetch the files, and report what was skipped."""
    assert __doc__ is not None
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path, help="folder for the files")
    parser.add_argument(
        "--from", dest="sources", action="append", type=Path, default=[], help="clone, bare clone or folder"
    )
    given = parser.parse_args()
    skipped = fetch(given.folder, given.sources)
    assemble_panda(given.folder)
    assemble_tx40(given.folder)
    assemble_tiago(given.folder)
    assemble_servo(given.folder)
    assemble_go2(given.folder)
    for reason in skipped:
        print(f"skipped: {reason}", file=sys.stderr)
    here = sum(
        (given.folder / repository.name / path).is_file() for repository in REPOSITORIES for path in repository.files
    )
    print(f"{here} of {sum(len(repository.files) for repository in REPOSITORIES)} files are in {given.folder}")
    return 1 if skipped else 0


if __name__ == "__main__":
    sys.exit(main())
