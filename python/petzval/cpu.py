"""Check of the CPU, before the engine is loaded: on an older one it would end the process."""

import platform
import sys

#: Instructions of the engine on x86-64, by their names in /proc/cpuinfo.
_NEEDED = ("avx2", "fma", "bmi2", "f16c")


def check(cpuinfo="/proc/cpuinfo"):
    """Raise ImportError if this CPU lacks instructions that the engine uses.

    Only Linux tells without the help of a library; elsewhere nothing is checked.
    """
    if not sys.platform.startswith("linux") or platform.machine() not in ("x86_64", "AMD64"):
        return
    try:
        with open(cpuinfo, encoding="ascii", errors="replace") as file:
            lines = [line for line in file if line.startswith("flags")]
    except OSError:
        return
    if not lines:
        return
    flags = set(lines[0].split())
    missing = [name for name in _NEEDED if name not in flags]
    if missing:
        raise ImportError(
            f"petzval needs a CPU with {', '.join(_NEEDED)}; this one has no {', '.join(missing)}. "
            "Build it for this machine: "
            "RUSTFLAGS='-C target-cpu=native' pip install --no-binary :all: ./python"
        )
