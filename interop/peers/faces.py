"""One Python program on stock's modules and on ours: the same text, the same master, and what each printed."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from harness import SOURCE, STOCK_PYTHON, Master, Process

START = SOURCE / "pyros1" / "drop_in" / "start"
FACES = ("stock", "ours")


def command(face: str, program: Path) -> list[str]:
    """Return the command that runs a program on the modules of ``stock`` or on ``ours``."""
    return [STOCK_PYTHON if face == "stock" else sys.executable, "-W", "ignore::DeprecationWarning", str(program)]


def environ(face: str, master: Master, **extra: str | None) -> dict[str, str]:
    """Return the environment for a program on ``stock`` or ``ours``."""
    if face == "stock":
        return master.environ("stock", **extra)
    return master.environ("ours", **{"PYTHONPATH": f"{START}:{SOURCE}", **extra})


def start(face: str, master: Master, text: str, *arguments: str, **extra: str | None) -> Process:
    """Start a program in the background; it ends with the test (use the fixture ``launcher`` as the master)."""
    program = master.home / f"program_{face}_{len(master.processes)}.py"
    program.write_text(text)
    process = Process([*command(face, program), *arguments], environ(face, master, **extra), label=f"{face} program")
    master.processes.append(process)
    return process


def run(face: str, master: Master, text: str, *arguments: str, timeout: float = 60, **extra: str | None) -> str:
    """Run a program to its end, and return what it printed to stdout; a failure fails the test with its stderr."""
    program = master.home / f"program_{face}.py"
    program.write_text(text)
    done = subprocess.run(
        [*command(face, program), *arguments],
        env=environ(face, master, **extra),
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == 0, f"on {face}: exit code {done.returncode}\n{done.stdout[-3000:]}\n{done.stderr[-6000:]}"
    return done.stdout


def same(master: Master, text: str, *arguments: str, timeout: float = 60, **extra: str | None) -> str:
    """Run a program on both, require the same output, and return it."""
    stock, ours = (run(face, master, text, *arguments, timeout=timeout, **extra) for face in FACES)
    assert ours == stock
    return ours
