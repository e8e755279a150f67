"""What a real-time run needs of the machine: shared memory, priority, locked memory, a steady processor."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from flexros.installation.finding import Finding

SHARED_MEMORY = Path("/dev/shm")  # noqa: S108 - where Linux keeps shared memory
LEAST_SHARED = 64_000_000
"""Free shared memory below which Fast DDS runs out of segments with a few nodes [bytes] (chosen)."""
CPUS = Path("/sys/devices/system/cpu")
_PRIORITY = "import os; os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(10))"


def check_shared_memory(folder: Path = SHARED_MEMORY) -> Finding:
    """Check size and free space of the shared memory, through which nodes on one machine exchange messages.

    Args:
        folder: Where it is mounted.
    """
    if not folder.is_dir():
        text = f"{folder} does not exist: messages between processes take the network"
        return Finding("shared memory", "limited", text, "start the container with ipc=host or shm-size=512m")
    use = shutil.disk_usage(folder)
    facts = {"folder": str(folder), "size_bytes": use.total, "free_bytes": use.free}
    text = f"{folder}: {_megabytes(use.free)} of {_megabytes(use.total)} free"
    if not os.access(folder, os.W_OK):
        return Finding("shared memory", "limited", f"{text}, not writable", "give this user the right to write", facts)
    if use.free < LEAST_SHARED:
        remedy = "start the container with shm-size=512m, or end processes that hold it"
        return Finding("shared memory", "limited", text, remedy, facts)
    return Finding("shared memory", "ok", text, facts=facts)


def check_real_time() -> Finding:
    """Check whether this user may take real-time priority, by trying it in a process of its own."""
    if not hasattr(os, "sched_setscheduler"):
        text = "this system has no real-time priorities of Linux"
        return Finding("real-time rights", "limited", text, "run real-time loops on Linux")
    import resource

    priority = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    locked = resource.getrlimit(resource.RLIMIT_MEMLOCK)[0]
    done = subprocess.run([sys.executable, "-c", _PRIORITY], capture_output=True, check=False)  # noqa: S603 - our words
    permitted = done.returncode == 0
    unlimited = locked == resource.RLIM_INFINITY
    facts = {
        "permitted": permitted,
        "rtprio_limit": priority,
        "memlock_limit_bytes": None if unlimited else locked,
        "preempt_rt": _text(Path("/sys/kernel/realtime")) == "1",
    }
    memory = "unlimited" if unlimited else _megabytes(locked)
    text = f"priority {'permitted' if permitted else 'refused'} (limit {priority}), locked memory {memory}"
    if not permitted:
        remedy = (
            "to pace runs by the wall clock: '@realtime - rtprio 98' in /etc/security/limits.conf for a group of this "
            "user, then log in again; start a container with ulimit rtprio=98"
        )
        return Finding("real-time rights", "limited", text, remedy, facts)
    return Finding("real-time rights", "ok", text, facts=facts)


def check_processor(folder: Path = CPUS) -> Finding:
    """Check number and frequency governor of the cores.

    Args:
        folder: Folder of the cores in the sys file system.
    """
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    governors = sorted({_text(path) for path in folder.glob("cpu[0-9]*/cpufreq/scaling_governor")} - {""})
    facts = {"cores": cores, "governors": governors, "load_1_min": _load()}
    text = f"{cores} core{'s' * (cores != 1)}, "
    text += f"governor {', '.join(governors)}" if governors else "no governor stated (virtual machine or container)"
    if governors and governors != ["performance"]:
        remedy = "for steady real-time loops: sudo cpupower frequency-set -g performance"
        return Finding("processor", "limited", text, remedy, facts)
    return Finding("processor", "ok", text, facts=facts)


def _load() -> float | None:
    return os.getloadavg()[0] if hasattr(os, "getloadavg") else None


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8").strip()
    except OSError:
        return ""


def _megabytes(size: float) -> str:
    return f"{size / 1e6:.0f} MB" if size < 1e9 else f"{size / 1e9:.3g} GB"
