"""Stops the nodes of a launcher that has been killed.

A small separate process, the watchdog, reads the list of process groups from a pipe. The system closes the pipe when
the launcher exits, for any reason. The watchdog then stops the remaining groups as the launcher would have done, and
runs the ``on-death`` commands of their nodes, since nobody asked for these nodes to be stopped.

This file is run as a script and does not import pyros1, so it starts quickly. It works on every POSIX system. A node
that the launcher has started but not yet reported is found by its ``__log`` argument, on Linux only.
"""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

HAS_PROCESS_GROUPS = hasattr(os, "killpg")
"""Whether the system has process groups; without them (Windows), a launch knows only the processes that it started."""
_POLL_PERIOD = 0.05
_SIGKILL_TIMEOUT = 2.0
RELEASE_TIMEOUT = 5.0
"""Timeout in seconds for the watchdog to exit after all processes have exited."""
ON_DEATH_TIMEOUT = 10.0
"""Maximum duration in seconds of an ``on-death`` command."""

OnDeathCommand = tuple[list[str], dict[str, str], str]
"""A command, its environment and its working directory."""


class Watchdog:
    """The watchdog process, and the launcher's end of the pipe to it.

    Args:
        sigint_timeout: seconds between SIGINT and SIGTERM.
        sigterm_timeout: seconds between SIGTERM and SIGKILL.
    """

    def __init__(self, sigint_timeout: float = 15.0, sigterm_timeout: float = 2.0) -> None:
        words = [sys.executable, "-I", "-S", __file__, str(sigint_timeout), str(sigterm_timeout)]
        self._lock = threading.Lock()  # a line that does not fit into the pipe is written in several parts
        # In a new session, so that it does not receive the Ctrl-C or hang-up signal that stops the launcher.
        self._process = subprocess.Popen(
            words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        )

    @property
    def pid(self) -> int:
        """The watchdog's process id."""
        return self._process.pid

    def expect(self, argument: str) -> None:
        """Announce that a process with a given command-line argument is about to be started."""
        self._send("expect", argument)

    def watch(self, pid: int, on_death_command: OnDeathCommand | None = None) -> None:
        """Report that the announced process is running, and is the leader of a new process group.

        Args:
            pid: the process id.
            on_death_command: a command to run after the process has been stopped because the launcher was killed.
        """
        if on_death_command is not None:
            import json  # noqa: PLC0415 - the watchdog starts faster without it

            self._send("on_death", json.dumps([pid, *on_death_command]))
        self._send("watch", str(pid))

    def report_exit(self, pid: int) -> None:
        """Report that a process has exited. Its group may still have members."""
        self._send("ended", str(pid))

    def _send(self, verb: str, argument: str) -> None:
        pipe = self._process.stdin
        if pipe is not None:
            line = f"{verb} {argument}\n".encode(errors="surrogateescape")
            # Errors mean that the watchdog was killed, or has exited because a node survived SIGKILL. Then the launcher
            # stops its nodes itself.
            with self._lock, contextlib.suppress(OSError, ValueError):
                while line:
                    line = line[os.write(pipe.fileno(), line) :]

    def close(self) -> None:
        """Stop the watchdog. Call this when all processes have exited."""
        self._send("release", "")
        if self._process.stdin is not None:
            self._process.stdin.close()
        try:
            self._process.wait(RELEASE_TIMEOUT)
        except subprocess.TimeoutExpired:  # the watchdog is suspended, or gets no CPU time; it has nothing left to do
            self._process.kill()
            self._process.wait()


def groups_alive(groups: set[int]) -> set[int]:
    """Return the process groups that still have members.

    Zombies, which wait to be reaped by process 1, are ignored if the system provides the necessary information.
    """
    existing_groups = set()
    for group in groups if HAS_PROCESS_GROUPS else ():
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(group, 0)
            existing_groups.add(group)
    if not existing_groups or not os.path.exists("/proc/self/stat"):
        return existing_groups
    living_groups = set()
    for path in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            state, _, group_text = path.read_text().rpartition(")")[2].split()[:3]
            if state not in "ZX":
                living_groups.add(int(group_text))
    return existing_groups & living_groups


def group_exists(group: int) -> bool:
    """Return whether a process group still has members."""
    return bool(groups_alive({group}))


def is_leaderless(group: int) -> bool:
    """Return whether a process group whose leader has exited still has members.

    If a process with the group's id exists, the id was reused for another group.
    """
    if not HAS_PROCESS_GROUPS:
        return False  # on Windows, os.kill(group, 0) would send Ctrl-C
    try:
        os.kill(group, 0)
    except ProcessLookupError:
        return group_exists(group)
    except PermissionError:
        pass
    return False


def stop_groups(groups: set[int], stages: list[tuple[int, float]]) -> None:
    """Send signals to process groups until none is left, or all signals have been sent.

    Args:
        groups: ids of the groups.
        stages: the signals to send, each with the number of seconds to wait after it.
    """
    for number, seconds in stages:
        for group in groups:
            with contextlib.suppress(OSError):
                os.killpg(group, number)
        deadline = time.monotonic() + seconds
        while groups and time.monotonic() < deadline:
            time.sleep(_POLL_PERIOD)
            groups = groups_alive(groups)


def find_group_leaders(argument: str) -> set[int]:
    """Return the ids of the process group leaders that have a given command-line argument."""
    leaders = set()
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        with contextlib.suppress(OSError):
            if os.fsencode(argument) in path.read_bytes().split(b"\0"):
                leaders.add(int(path.parent.name))
    return {pid for pid in leaders if group_exists(pid)}


def run_on_death_commands(on_death_commands: list[OnDeathCommand]) -> None:
    """Run on-death commands in parallel, and kill those still running after ON_DEATH_TIMEOUT seconds."""
    started_processes = []
    for words, env, cwd in on_death_commands:
        with contextlib.suppress(OSError):
            started_processes.append(
                subprocess.Popen(words, env=env, cwd=cwd, stdin=subprocess.DEVNULL, start_new_session=True)
            )
    deadline = time.monotonic() + ON_DEATH_TIMEOUT
    for process in started_processes:
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(max(0.0, deadline - time.monotonic()))
    stop_groups(
        {process.pid for process in started_processes if process.poll() is None}, [(signal.SIGKILL, _SIGKILL_TIMEOUT)]
    )


def main() -> None:
    """Read reports until the launcher has exited, then stop the remaining processes."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    running_groups: set[int] = set()
    ended_groups: set[int] = set()
    on_death_commands: dict[int, OnDeathCommand] = {}
    expected = ""
    for line in sys.stdin.buffer:
        verb, _, argument = os.fsdecode(line.rstrip(b"\n")).partition(" ")
        if verb == "expect":
            expected = argument
        elif verb == "on_death":
            import json  # noqa: PLC0415 - few nodes have such a command

            pid, *on_death = json.loads(argument)
            on_death_commands[pid] = on_death
        elif verb == "watch":
            running_groups.add(int(argument))
            expected = ""
        elif verb == "ended":
            running_groups.discard(int(argument))
            on_death_commands.pop(int(argument), None)
            if group_exists(int(argument)):
                ended_groups.add(int(argument))
        else:
            return
    groups = running_groups | {group for group in ended_groups if is_leaderless(group)}
    if expected:
        groups |= find_group_leaders(expected)
    sigint, sigterm = map(float, sys.argv[1:3])
    stop_groups(groups, [(signal.SIGINT, sigint), (signal.SIGTERM, sigterm), (signal.SIGKILL, _SIGKILL_TIMEOUT)])
    run_on_death_commands(list(on_death_commands.values()))


if __name__ == "__main__":
    main()
