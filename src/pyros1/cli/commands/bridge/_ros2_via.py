"""The two ways in which ``bridge ros2`` connects to ROS 2: chooses one and starts it."""

from __future__ import annotations

import errno
import socket
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.cli.failures import CommandError, UsageError
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.ros2.bridge.side import MakeSide

WAYS = ("rclpy", "zenoh")
_ZENOH_OPTIONS = {"connect": "--to", "listen": "--listen", "keys": "--keys", "insecure": "--insecure"}


class Way(NamedTuple):
    """One of the two ways in which the bridge connects to ROS 2.

    Attributes:
        name: ``rclpy`` or ``zenoh``.
        note: the reason for choosing zenoh, if the command line did not select it; otherwise empty.
    """

    name: str
    note: str = ""


def choose_way(options: Any) -> Way:
    """Return the way that the command line selects; by default, rclpy if it can be imported.

    Raises:
        UsageError: the command line selects rclpy, but has options that are only for zenoh.
        CommandError: the command line selects rclpy, which cannot be imported.
    """
    given = [option for name, option in _ZENOH_OPTIONS.items() if getattr(options, name)]
    if options.via == "rclpy" and given:
        raise UsageError(f"{given[0]} has no meaning with --via rclpy: ROS 2's own middleware finds the other nodes")
    if options.via == "zenoh" or (options.via is None and given):
        return Way("zenoh")
    problem = _rclpy_problem()
    if not problem:
        return Way("rclpy")
    if options.via == "rclpy":
        raise CommandError(
            f"{problem}; run `source /opt/ros/.../setup.bash`, and start pyros1 with the Python version that this "
            "ROS 2 was built for"
        )
    return Way("zenoh", f"zenoh, since {problem}")


def _rclpy_problem() -> str:
    """Return the reason why rclpy cannot be used; empty if it can."""
    if find_spec("rclpy") is None:
        return "rclpy is not installed here"
    try:
        import_module("rclpy.node")
    except Exception as error:  # noqa: BLE001 - libraries for another ROS 2 or Python may raise anything
        return f"rclpy cannot be imported: {one_line(error, 200)}"
    return ""


def describe_way(way: Way, connect: Sequence[str], listen: Sequence[str]) -> str:
    """Return a description of how the bridge connects.

    Args:
        way: how it gets to ROS 2.
        connect, listen: the endpoints of zenoh.
    """
    if way.name == "rclpy":
        from pyros1.ros2.rclpy_side.rclpy_modules import rmw_name  # noqa: PLC0415

        try:
            return f"rclpy with {one_line(rmw_name())}"
        except Exception as error:  # noqa: BLE001 - rclpy's own, of any kind
            raise CommandError(f"rclpy has no middleware: {one_line(error, 300)}") from None
    note = f" ({way.note})" if way.note else ""
    return " and ".join([*connect, *(f"{each} (as a router)" for each in listen)]) + note


def packages_line() -> str:
    """Return a line with the ROS 2 packages that a bridge through rclpy knows."""
    from pyros1.ros2_types.rclpy_packages import RclpyPackages  # noqa: PLC0415

    return f"types of these packages, which this ROS 2 installation has: {', '.join(RclpyPackages().packages())}"


def check_way(way: Way, listen: Sequence[str]) -> None:
    """Raise an error if something that the way needs is missing.

    Called before the node starts: starting it shuts down another bridge of the same name, which may be the program that
    listens.

    Args:
        way: how the bridge gets to ROS 2.
        listen: the endpoints on which the bridge will listen.

    Raises:
        CommandError: zenoh is not installed, or another program listens on one of the ports.
    """
    from pyros1.bridge.transport.zenoh_link import check_installed  # noqa: PLC0415

    if way.name == "zenoh":
        check_installed()
        for endpoint in listen:
            if _is_in_use(endpoint):
                raise CommandError(
                    f"cannot listen on {one_line(endpoint)}: another program does, perhaps a bridge or ROS 2's router"
                )


def _is_in_use(endpoint: str) -> bool:
    """Return whether another program listens on a TCP port."""
    protocol, _, address = endpoint.partition("/")
    host, _, port = address.rpartition(":")
    if protocol not in ("tcp", "tls") or not port.isdigit() or port == "0":
        return False
    try:
        addresses = socket.getaddrinfo(host.strip("[]"), int(port), type=socket.SOCK_STREAM)
    except OSError:
        return False  # zenoh reports the problem
    for family, kind, _, _, where in addresses:
        with socket.socket(family, kind) as sock:
            sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                sock.bind(where)
                sock.listen()
            except OSError as error:
                if error.errno == errno.EADDRINUSE:
                    return True
    return False


def make_side(
    way: Way,
    name: str,
    domain: int,
    connect: Sequence[str],
    listen: Sequence[str],
    settings: Mapping[str, str],
) -> MakeSide:
    """Return the function that makes the bridge's ROS 2 side.

    Args:
        way: how it gets to ROS 2.
        name: the name of the bridge's node in ROS 2.
        domain: the ROS domain.
        connect, listen, settings: zenoh's endpoints and settings.
    """
    if way.name == "rclpy":
        from pyros1.ros2.rclpy_side.session import RclpySession  # noqa: PLC0415
        from pyros1.ros2.rclpy_side.type_classes import TypeClasses  # noqa: PLC0415
        from pyros1.ros2_types.rclpy_packages import RclpyPackages  # noqa: PLC0415

        # The session uses types in its own threads, so it needs its own collection.
        return lambda _, on_token, on_message, on_call: RclpySession(
            name, domain, TypeClasses(RclpyPackages()), on_token, on_message, on_call
        )
    from pyros1.ros2.zenoh.session import Ros2Session  # noqa: PLC0415

    return lambda zid, on_token, on_message, on_call: Ros2Session(
        zid, name, domain, on_token, on_message, on_call, connect, listen, settings
    )
