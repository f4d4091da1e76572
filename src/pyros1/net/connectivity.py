"""Hints for users if a node cannot be reached at its advertised address (https://wiki.ros.org/ROS/NetworkSetup).

This module only chooses the wording: it neither looks up hosts nor calls nodes.
"""

from __future__ import annotations

from pyros1.ground.errors import DeadlineError, UnknownHostError


def is_loopback(host: str) -> bool:
    """Return whether a host name or address is a loopback one, which on every machine means that machine itself."""
    return host in ("localhost", "::1") or host.startswith("127.")


def connectivity_hint(host: str, error: BaseException | None, own_host: str = "") -> str:
    """Return a hint of one or two sentences, to append to an error message.

    Args:
        host: the name or address that the unreachable node advertises.
        error: the reason why it cannot be reached, including its chain of causes; None if there is no error.
        own_host: the name or address that the calling node advertises; empty if unknown. If both are
            loopback addresses, the unreachable node is unlikely to be on another machine.
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
        return _loopback_hint(host, causes, own_host)
    if any(isinstance(cause, ConnectionResetError) for cause in causes):
        return f"Does PYROS1_ALLOW (or --allow) on [{host}] include this machine?"
    if any(isinstance(cause, ConnectionRefusedError) for cause in causes):
        return (
            f"Has it exited? Then run: pyros1 node cleanup. Otherwise its machine is not [{host}] (export "
            "ROS_IP=<its address> there and restart it), or a firewall rejects the port (PYROS1_PORTS)"
        )
    return (
        f"Is [{host}] switched on, and does the node run on it? If not: on the node's machine export "
        "ROS_IP=<its address> and restart it. A firewall must allow the node's ports (PYROS1_PORTS)"
    )


def _loopback_hint(host: str, causes: list[BaseException], own_host: str) -> str:
    if any(isinstance(cause, DeadlineError) for cause in causes):  # an exit would be noticed immediately
        return "It hangs or is stopped: kill -CONT PID resumes a stopped process (state T in ps)"
    exited_hint = "Has it exited? Then run: pyros1 node cleanup"
    if is_loopback(own_host):
        return exited_hint
    return (
        f"{exited_hint}. Or is it on another machine? It advertises {host}, which means this machine here: "
        "on its machine unset ROS_HOSTNAME, export ROS_IP=<its address> and restart it"
    )
