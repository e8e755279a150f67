"""Packaging of FlexROS for pip and colcon alike; docs/decisions/0001-packaging.md says why it has this form."""

import os
from pathlib import Path

from setuptools import find_packages, setup

SHARE = Path("share") / "flexros"
NODES = ("plant", "controller", "feedforward", "identification", "recorder", "replay", "gap_monitor")
NODE_PACKAGES = ("plant", "controller")  # nodes whose executable is the __main__ of a package
ROS_WHEELS = [
    "ros-jazzy-rclpy==7.1.6",
    "ros-jazzy-common-interfaces==5.3.6",
    "ros-jazzy-rmw-fastrtps-cpp==8.4.3",
]
VIEW = ["viser>=1.1,<2", "trimesh>=4", "pycollada>=0.8"]  # pycollada: meshes of URDFs in .dae
DESIGN = ["cma>=4", "slycot>=0.6; python_version >= '3.11'"]  # no wheels of slycot before
NOTEBOOKS = ["nbclient>=0.10", "ipykernel>=6.29"]
TEST = [
    *DESIGN,
    *NOTEBOOKS,
    *VIEW,
    "pytest>=8",
    "pytest-xdist>=3.5",
    "hypothesis>=6.100",
    "pin>=2.7",
    "mujoco>=3.1",
    "h5py>=3.10",
    "websockets>=13",  # with Pillow: pages in Chromium, where there is one
    "pillow>=10",
    "setuptools>=70.1",
]

console_scripts = ["flexros = flexros.cli:main"]
data_files = [
    ("share/ament_index/resource_index/packages", ["resource/flexros"]),
    (str(SHARE), ["package.xml"]),
    (str(SHARE / "msgs_config"), sorted(str(path) for path in Path("msgs_config").glob("*.yaml"))),
    (str(SHARE / "launch"), sorted(str(path) for path in Path("nodes/launch").glob("*.launch.py"))),
]
if "COLCON" in os.environ:  # `ros2 run` looks in lib/flexros, where colcon puts scripts; pip would put them on the PATH
    modules = [f"{name}.__main__" if name in NODE_PACKAGES else name for name in NODES]
    console_scripts += [f"{name} = flexros_nodes.{module}:main" for name, module in zip(NODES, modules)]
    data_files += [("bin", ["resource/bin/flexros"])]

setup(
    name="flexros",
    version="0.1.0",
    description="Modelling, control, identification and gap diagnosis of flexible robot manipulators on ROS 2",
    author="FlexROS developers",
    python_requires=">=3.10,<3.14",
    packages=find_packages(include=["flexros", "flexros.*", "flexros_nodes", "flexros_nodes.*"]),
    package_data={
        "flexros": ["py.typed", "**/*.yaml", "**/*.json", "**/*.html", "**/*.css", "**/*.js", "scenario/measured/**/*"],
        "flexros_nodes": ["shell/local_host.xml"],
    },
    data_files=data_files,
    zip_safe=False,
    install_requires=[
        "numpy>=1.26",
        "scipy>=1.11",
        "casadi>=3.6.7,<3.7",  # later ones release the interpreter lock while threads count references to shared nodes
        "llvmlite>=0.45",
        "packaging>=22",
        "pydantic>=2.10",
        "ruamel.yaml>=0.18",
        "typer>=0.12",
        "rich>=13.8",
        "plotly>=5.20",
        "control>=0.10.1",
        "mcap>=1.1",
        "mcap-ros2-support>=0.5",
        "rosbags>=0.10",
        "zstandard>=0.22",
        "lz4>=4.3",
        "xarray>=2024.1",
        "pandas>=2.1",
        "cvxpy>=1.5",
        "distributed>=2024.5",
        "threadpoolctl>=3.1",
    ],
    extras_require={
        "ros": ROS_WHEELS,
        "mujoco": ["mujoco>=3.3"],
        "design": DESIGN,
        "view": VIEW,
        "test": TEST,
        "docs": [*NOTEBOOKS, "mkdocs>=1.6,<2", "mkdocs-material>=9.6", "mkdocstrings[python]>=0.29"],
        "dev": [*TEST, "ruff>=0.12", "mypy>=1.15", "import-linter>=2.5", "colcon-common-extensions>=0.3"],
    },
    entry_points={
        "console_scripts": console_scripts,
        "flexros.commands": [f"{name} = flexros.validation.commands.{name}" for name in ("bench", "blind", "campaign")],
        "flexros.transports": ["ros = flexros_nodes.bringup.run:run_scenario"],
        "flexros.view": ["ros = flexros_nodes.bringup.live_view:view_topics"],
        "flexros.replay": ["ros = flexros_nodes.bringup.replay_run:replay_log"],
    },
)
