"""Provides `Resources` that give `load_plan` access to the real files, packages, environment and commands."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.resources import Resources, read_bounded

if TYPE_CHECKING:
    import subprocess

COMMAND_TIMEOUT_S = 600.0


def make_resources() -> Resources:
    """Return resources that access the real system."""
    return Resources(
        packages=PackageIndex(os.environ),
        environ=os.environ,
        run_command=run_command,
        make_unique_suffix=_make_unique_suffix,
        read_stdin=sys.stdin.read,
    )


def _make_unique_suffix() -> str:
    # Rarely needed, so imported here.
    import random  # noqa: PLC0415
    import socket  # noqa: PLC0415

    return f"{socket.gethostname()}_{os.getpid()}_{random.randrange(10**18)}"


def run_command(words: list[str]) -> str:
    """Run a command from a launch file, and return its output.

    Args:
        words: the command; xacro and tools such as ``rosrun`` can be run even if they are not installed as commands.

    Raises:
        LaunchError: the command cannot be run, or fails.
    """
    # Rarely needed, so imported here.
    import subprocess  # noqa: PLC0415

    from pyros1.launch.reading.own_commands import own_environment, own_words  # noqa: PLC0415

    command = own_words(words)
    env = own_environment(command, os.environ)
    try:
        process = subprocess.Popen(command, env=env, stdout=subprocess.PIPE)
    except FileNotFoundError as error:
        raise LaunchError(f"no such command [{words}].") from error
    except OSError as error:
        raise LaunchError(f"command [{words}] failed: {error}") from error
    output, exited_in_time = _read_output(process, f"the output of command [{words}]")
    if not exited_in_time:
        raise LaunchError(f"command [{words}] failed: it did not exit within {COMMAND_TIMEOUT_S:g} seconds")
    if process.returncode:
        raise LaunchError(f"command [{words}] returned with code [{process.returncode}].")
    try:
        return output.decode("utf-8")
    except UnicodeDecodeError as error:
        raise LaunchError(f"command [{words}]: its output is not UTF-8 text: {error}") from error


def _read_output(process: subprocess.Popen[bytes], name: str) -> tuple[bytes, bool]:
    """Return the output of a command until it exits or times out, and whether it exited in time."""
    import threading  # noqa: PLC0415

    timed_out = threading.Event()

    def on_timeout() -> None:
        timed_out.set()
        process.kill()

    timer = threading.Timer(COMMAND_TIMEOUT_S, on_timeout)
    timer.start()
    assert process.stdout is not None
    try:
        output = read_bounded(process.stdout, name)
        process.wait()
        return output, not timed_out.is_set()
    finally:
        timer.cancel()
        process.kill()
        process.stdout.close()
        process.wait()
