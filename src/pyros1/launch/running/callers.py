"""Decides which callers may control a launch: only those that could also send signals to its processes.

These are programs of the same user or of root on the same machine. Linux provides the user at the other end of a local
connection; on other systems, only the machine is checked.
"""

from __future__ import annotations

import ipaddress
import os
import socket
import sys
from pathlib import Path

from pyros1.net.hosts import is_local

Address = tuple[str, int]
_TABLE_FILES = ("net/tcp", "net/tcp6")
_ROOT = 0


def refusal_reason(connection: socket.socket) -> str:
    """Return the reason why a caller may not control the processes, or an empty string if the caller may.

    Args:
        connection: an accepted TCP connection from the caller.
    """
    try:
        remote, local = connection.getpeername()[:2], connection.getsockname()[:2]
    except OSError:
        return "the caller is gone"
    return address_refusal_reason(remote, local)


def address_refusal_reason(remote: Address, local: Address, proc: Path = Path("/proc")) -> str:
    """Return the reason why a caller may not control the processes, or an empty string if the caller may.

    Args:
        remote: address and port of the caller's end of the connection.
        local: address and port of this process's end.
        proc: path of the proc file system.
    """
    if not is_local(str(_normalize(remote[0]))):
        return "a launch can only be controlled from its own machine, for example through: pyros1 web"
    tables = [text for name in _TABLE_FILES if (text := _read_text(proc / name))]
    if not tables or not hasattr(os, "getuid"):
        return ""
    user = _socket_user(tables, remote, local)
    if user in (os.getuid(), _ROOT):
        return ""
    return "a launch can only be controlled by its own user"


def _socket_user(tables: list[str], remote: Address, local: Address) -> int | None:
    """Return the id of the user at the other end of a local connection, from the kernel's tables; None if unknown."""
    endpoints = (_normalize(remote[0]), _normalize(local[0]))
    ports = (f":{remote[1]:04X}", f":{local[1]:04X}")
    for table in tables:
        for line in table.splitlines()[1:]:
            words = line.split()
            if len(words) < 8 or not words[1].endswith(ports[0]) or not words[2].endswith(ports[1]):
                continue  # a fast check, since there may be thousands of connections
            if (_parse_endpoint(words[1]), _parse_endpoint(words[2])) == endpoints:
                return int(words[7])
    return None


def _parse_endpoint(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Parse an endpoint in the kernel's tables: an address as hexadecimal 32-bit words in native byte order, and a
    port."""
    address = text.partition(":")[0]
    words = [int(address[start : start + 8], 16).to_bytes(4, sys.byteorder) for start in range(0, len(address), 8)]
    return _normalize(ipaddress.ip_address(b"".join(words)))


def _normalize(
    address: str | ipaddress.IPv4Address | ipaddress.IPv6Address,
) -> ipaddress.IPv4Address | ipaddress.IPv6Address:
    """Return an address without its zone, and an IPv4-mapped IPv6 address as an IPv4 address."""
    parsed = ipaddress.ip_address(address.partition("%")[0]) if isinstance(address, str) else address
    return getattr(parsed, "ipv4_mapped", None) or parsed


def _read_text(file: Path) -> str:
    try:
        return file.read_text(encoding="ascii")
    except OSError:
        return ""
