"""The ports that a process listens on: any that is free, or one of a range that a firewall lets through."""

from __future__ import annotations

import errno
import os
import re
import socket
from collections.abc import Callable, Iterator
from typing import NamedTuple

from pyros1.ground.errors import SettingError

BACKLOG = 1024
"""Connections that may wait to be accepted. If more come at once, the system lets each further one wait for a
second."""


class PortRange(NamedTuple):
    """Ports from ``first`` to ``last``, both included."""

    first: int
    last: int

    def __str__(self) -> str:
        return f"{self.first}-{self.last}"

    def shuffled(self) -> Iterator[int]:
        """Return all of them, from a random one on: a new node seldom gets the port of one that has just ended, which
        others still call.
        """
        import random  # noqa: PLC0415 - slow to import, and most processes have no range

        count = self.last - self.first + 1
        begin = random.randrange(count)
        return (self.first + (begin + step) % count for step in range(count))


def parse_ports(text: str) -> PortRange:
    """Return the range of a text such as ``40000-40099``, or ``40000`` for one port.

    Raises:
        SettingError: it is no such text.
    """
    match = re.fullmatch(r"\s*(\d{1,5})\s*(?:-\s*(\d{1,5})\s*)?", text, re.ASCII)
    if match:
        ports = PortRange(int(match[1]), int(match[2] or match[1]))
        if 0 < ports.first <= ports.last < 65536:
            return ports
    raise SettingError(
        f"PYROS1_PORTS is {text[:60]!r}, not a range of ports such as 40000-40099 (a node needs two, "
        "and one more for each topic over UDP)"
    )


def listening_socket(bind: str, port: int = 0, ports: PortRange | None = None) -> socket.socket:
    """Return a socket that listens for connections, without blocking.

    Args:
        bind: address to listen on.
        port: 0 for any.
        ports: the range to choose from, if any port will do.

    Raises:
        OSError: the address cannot be listened on; with ``errno.EADDRINUSE`` if the port, or all ports, are in use.
    """

    def attempt(number: int) -> socket.socket:
        sock = socket.socket(_family(bind), socket.SOCK_STREAM)
        try:
            if os.name == "posix":  # elsewhere it would let two programs have the same port
                sock.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            if bind == "::":  # also IPv4, like stock
                sock.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
            sock.bind((bind, number))
            sock.listen(BACKLOG)
            sock.setblocking(False)
        except OSError:
            sock.close()
            raise
        return sock

    return _bind_first_free(attempt, bind, port, ports)


def datagram_socket(bind: str, ports: PortRange | None = None) -> socket.socket:
    """Return a socket that receives datagrams, without blocking. Arguments and errors: see `listening_socket`."""

    def attempt(number: int) -> socket.socket:
        sock = socket.socket(_family(bind), socket.SOCK_DGRAM)
        try:
            sock.bind((bind, number))
            sock.setblocking(False)
        except OSError:
            sock.close()
            raise
        return sock

    return _bind_first_free(attempt, bind, 0, ports)


def _family(bind: str) -> int:
    return socket.AF_INET6 if ":" in bind else socket.AF_INET


def _bind_first_free(
    attempt: Callable[[int], socket.socket], bind: str, port: int, ports: PortRange | None
) -> socket.socket:
    """Return the socket of the first port that is free."""
    if port or ports is None:
        return _bind_or_explain(attempt, bind, port)
    for number in ports.shuffled():
        try:
            return _bind_or_explain(attempt, bind, number)
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
    raise OSError(
        errno.EADDRINUSE, f"all ports of PYROS1_PORTS={ports} are in use here: stop some nodes, or allow more ports"
    )


def _bind_or_explain(attempt: Callable[[int], socket.socket], bind: str, port: int) -> socket.socket:
    try:
        return attempt(port)
    except OSError as error:
        if error.errno == errno.EADDRNOTAVAIL:
            raise OSError(error.errno, f"{bind} is not an address of this machine") from error
        raise
