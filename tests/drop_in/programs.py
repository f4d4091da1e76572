"""Programs that import rospy and its siblings, run on our modules in processes of their own."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pyros1

SOURCE = Path(pyros1.__file__).resolve().parents[1]
START = SOURCE / "pyros1" / "drop_in" / "start"


def environment(environ: Mapping[str, str]) -> dict[str, str]:
    """Return the environment of a program: this process's, with the modules, and what a test adds."""
    ours = {"PYTHONPATH": f"{START}{os.pathsep}{SOURCE}", "PYTHONFAULTHANDLER": "1"}
    return {**{key: value for key, value in os.environ.items() if not key.startswith("ROS")}, **ours, **environ}


def start(text: str, environ: Mapping[str, str], *arguments: str) -> subprocess.Popen[str]:
    """Start a program; its output can be read, stderr included."""
    return subprocess.Popen(
        [sys.executable, "-c", text, *arguments],
        env=environment(environ),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )


def run(text: str, environ: Mapping[str, str], *arguments: str, timeout: float = 30, code: int = 0) -> str:
    """Run a program to its end, require its exit code, and return its output, stderr included."""
    with start(text, environ, *arguments) as child:
        try:
            out, _ = child.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            child.send_signal(signal.SIGABRT)  # it shows what its threads are at, and dies
            out, _ = child.communicate(timeout=timeout)
            raise AssertionError(f"it did not end within {timeout} s\n{out}") from None
    assert child.returncode == code, f"exit code {child.returncode}\n{out}"
    return out
