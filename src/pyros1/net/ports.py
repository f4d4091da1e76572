"""Opens the ports that a process listens on: any free port, or one from a range that a firewall allows."""

from __future__ import annotations

import errno
import os
import re
import socket
from collections.abc import Callable, Iterator
from typing import NamedTuple

from pyros1.ground.errors import SettingError

BACKLOG = 1024
"""Maximum number of connections that wait to be accepted. The system delays each further connection by a second."""


class PortRange(NamedTuple):
    """The ports from ``first`` to ``last`` inclusive."""

    first: int
    last: int

    def __str__(self) -> str:
        return f"{self.first}-{self.last}"

    def iterate_from_random_start(self) -> Iterator[int]:
        """Yield all ports in order, starting at a random one and wrapping around.

        So a new node rarely gets the port of a node that has just exited, and that other nodes may still call.
        """
        import random  # noqa: PLC0415 - slow to import, and rarely needed

        count = self.last - self.first + 1
        start = random.randrange(count)
        return (self.first + (start + step) % count for step in range(count))


def parse_ports(text: str) -> PortRange:
    """Parse a range such as ``40000-40099``, or a single port such as ``40000``.

    Raises:
        SettingError: the text is malformed.
    """
    match = re.fullmatch(r"\s*(\d{1,5})\s*(?:-\s*(\d{1,5})\s*)?", text, re.ASCII)
    if match:
        ports = PortRange(int(match[1]), int(match[2] or match[1]))
        if 0 < ports.first <= ports.last < 65536:
            return ports
    raise SettingError(
        f"PYROS1_PORTS is {text[:60]!r}, not a range of ports such as 40000-40099 (a node needs two, "
        "and one more for each topic received over UDP)"
    )


def listening_socket(bind: str, port: int = 0, ports: PortRange | None = None) -> socket.socket:
    """Return a non-blocking socket that listens for connections.

    Args:
        bind: the address to listen on.
        port: the port; 0 for any.
        ports: the range to choose from if ``port`` is 0; None for no restriction.

    Raises:
        OSError: this machine cannot listen on that address; ``errno.EADDRINUSE`` if the port, or every port of the
            range, is in use.
    """

    def open_socket(candidate: int) -> socket.socket:
        sock = socket.socket(_family(bind), socket.SOCK_STREAM)
        try:
            if os.name == "posix":  # elsewhere, the option would allow two programs to use the same port
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if bind == "::":  # accept IPv4, too, as in stock ROS
                sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
            sock.bind((bind, candidate))
            sock.listen(BACKLOG)
            sock.setblocking(False)
        except OSError:
            sock.close()
            raise
        return sock

    return _bind_first_free(open_socket, bind, port, ports)


def datagram_socket(bind: str, ports: PortRange | None = None) -> socket.socket:
    """Return a non-blocking socket that receives datagrams. For arguments and errors, see `listening_socket`."""

    def open_socket(candidate: int) -> socket.socket:
        sock = socket.socket(_family(bind), socket.SOCK_DGRAM)
        try:
            sock.bind((bind, candidate))
            sock.setblocking(False)
        except OSError:
            sock.close()
            raise
        return sock

    return _bind_first_free(open_socket, bind, 0, ports)


def _family(bind: str) -> int:
    return socket.AF_INET6 if ":" in bind else socket.AF_INET


def _bind_first_free(
    open_socket: Callable[[int], socket.socket], bind: str, port: int, ports: PortRange | None
) -> socket.socket:
    """Return a socket bound to ``port``, or to the first free port in ``ports``."""
    if port or ports is None:
        return _bind_or_explain(open_socket, bind, port)
    for candidate in ports.iterate_from_random_start():
        try:
            return _bind_or_explain(open_socket, bind, candidate)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
    raise OSError(
        errno.EADDRINUSE, f"all ports of PYROS1_PORTS={ports} are in use here: stop some nodes, or allow more ports"
    )


def _bind_or_explain(open_socket: Callable[[int], socket.socket], bind: str, port: int) -> socket.socket:
    try:
        return open_socket(port)
    except OSError as error:
        if error.errno == errno.EADDRNOTAVAIL:
            raise OSError(error.errno, f"{bind} is not an address of this machine") from error
        raise
