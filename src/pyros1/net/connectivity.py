"""What to do when a node cannot be reached at the address under which it is known
(https://wiki.ros.org/ROS/NetworkSetup).

Pure.
"""

from __future__ import annotations

from pyros1.ground.errors import DeadlineError, UnknownHostError


def is_loopback(host: str) -> bool:
    """Return whether a host name or address means whatever machine asks."""
    return host in ("localhost", "::1") or host.startswith("127.")


def connectivity_hint(host: str, error: BaseException | None, own: str = "") -> str:
    """Return what to do, as a sentence or two for the end of an error's text.

    Args:
        host: the name or address that the node gave as its own.
        error: why it cannot be reached; causes count as well.
        own: the name or address that the asking node gives as its own; empty if that is not known. Where nodes of one
            machine use a loopback address, another machine is hardly the reason.
    """
    causes = []
    while error is not None:
        causes.append(error)
        error = error.__cause__
    if any(isinstance(cause, UnknownHostError) for cause in causes):
        return (
            "On its machine export ROS_IP=<its address> and restart it, "
            f"or add a line 'ADDRESS {host}' to /etc/hosts here"
        )
    if is_loopback(host):
        return _loopback_hint(host, causes, own)
    if any(isinstance(cause, ConnectionResetError) for cause in causes):
        return f"Does PYROS1_ALLOW (or --allow) on [{host}] include this machine?"
    if any(isinstance(cause, ConnectionRefusedError) for cause in causes):
        return (
            f"Has it exited? Then: pyros1 node cleanup. Otherwise its machine is not [{host}] (export "
            "ROS_IP=<its address> there and restart it), or a firewall rejects the port (PYROS1_PORTS)"
        )
    return (
        f"Is [{host}] switched on, and is it the machine of this node? If not: export ROS_IP=<its address> there and "
        "restart it. A firewall must allow the node's ports (PYROS1_PORTS)"
    )


def _loopback_hint(host: str, causes: list[BaseException], own: str) -> str:
    if any(isinstance(cause, DeadlineError) for cause in causes):  # a process that has ended is reported at once
        return "It is hanging or stopped: kill -CONT PID continues a stopped process (state T in ps)"
    ended = "Has it exited? Then: pyros1 node cleanup"
    if is_loopback(own):
        return ended
    return (
        f"{ended}. Or is it on another machine? Its address there, {host}, means this machine here: on its machine "
        "unset ROS_HOSTNAME, export ROS_IP=<its address> and restart it"
    )
