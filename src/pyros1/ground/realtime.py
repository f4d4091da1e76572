"""Real-time priorities of processes: SCHED_FIFO of Linux, see https://man7.org/linux/man-pages/man7/sched.7.html."""

from __future__ import annotations

import operator
import os
from contextlib import suppress

from pyros1.ground.errors import NodeError

MAX_PRIORITY = 99
_MAX_PASSES = 100


def check_priority(priority: object, name: str) -> int:
    """Return a real-time priority as an int.

    Args:
        priority: a whole number from 0 (none) to 99, or its text.
        name: the priority's name in the error message.

    Raises:
        ValueError: the priority is not such a number.
    """
    with suppress(TypeError, ValueError):
        number = int(priority) if isinstance(priority, str) else operator.index(priority)  # type: ignore[arg-type]
        if 0 <= number <= MAX_PRIORITY:
            return number
    raise ValueError(f"{name} must be a whole number from 0 (none) to {MAX_PRIORITY}, not {priority!r}")


def set_priority(priority: int, pid: int) -> None:
    """Set the real-time priority of all threads of a process, and so of the threads and processes that they create.

    Args:
        priority: 1 to 99, or 0 for none. A process that has work to do runs before all processes with a lower priority
            or none.
        pid: the process id.

    Raises:
        NodeError: the system does not support real-time priorities, or the user may not set them. The message says
            what to do.
    """
    if not hasattr(os, "SCHED_FIFO"):
        raise NodeError(f"cannot get real-time priority {priority}: only Linux has these priorities")
    policy = os.SCHED_FIFO if priority else os.SCHED_OTHER
    done: set[str] = set()
    try:
        for _ in range(_MAX_PASSES):  # until there are no new threads: unchanged ones may create more
            threads = set(os.listdir(f"/proc/{pid}/task")) - done
            if not threads:
                break
            for thread in threads:
                with suppress(ProcessLookupError):  # the thread has ended
                    os.sched_setscheduler(int(thread), policy, os.sched_param(priority))
            done |= threads
    except (FileNotFoundError, ProcessLookupError):
        return  # the process has ended
    except OSError as error:
        raise NodeError(f"cannot get real-time priority {priority}: {_explain(error)}") from error


def _explain(error: OSError) -> str:
    if not isinstance(error, PermissionError):
        return str(error.strerror)
    import resource  # noqa: PLC0415 - only Unix has it

    soft_limit = resource.getrlimit(resource.RLIMIT_RTPRIO)[0]
    return (
        f"the system does not permit it (this user's limit is {soft_limit}). "
        "Add `USER - rtprio 99` to /etc/security/limits.conf and log in again, or run it as root; "
        "in Docker use --cap-add=sys_nice"
    )
