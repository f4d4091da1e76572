"""Unix sockets between programs of one machine and one user, in Linux's abstract namespace: no file is needed, and a
killed program leaves none behind. On other systems there are none, and nodes use TCP.
"""

from __future__ import annotations

import os
import socket
import struct
from collections.abc import Mapping
from functools import cache
from typing import Final

from pyros1.wire.local import is_local_enabled

_PREFIX: Final = "pyros1-"
_CREDENTIALS: Final = struct.Struct("3i")  # struct ucred: process, user, group


@cache
def host_key() -> str:
    """Return the common key of programs that can share memory: those of one user in one network namespace of one boot
    of a machine. Empty if the system does not support this.
    """
    import hashlib  # noqa: PLC0415 - slow to import, and most nodes do not need it

    needed = ((os, "memfd_create"), (os, "geteuid"), (socket, "SO_PEERCRED"), (socket, "send_fds"))
    if not all(hasattr(module, name) for module, name in needed):
        return ""
    try:
        with open("/proc/sys/kernel/random/boot_id", encoding="ascii") as file:
            boot = file.read()
        network = os.readlink("/proc/self/ns/net")
    except (OSError, ValueError):
        return ""
    text = f"{boot} {network} {os.geteuid()}"
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def local_key(environ: Mapping[str, str]) -> str:
    """Return `host_key` unless PYROS1_TRANSPORTS leaves out the local transport, else an empty text.

    Raises:
        SettingError: its value is wrong.
    """
    return host_key() if is_local_enabled(environ.get("PYROS1_TRANSPORTS", "")) else ""


def socket_name_for(uri: str, key: str) -> str:
    """Return the name of the socket beside a port for services: the name follows from the port's URI.

    Args:
        uri: as registered with the master, ``rosrpc://host:port``.
        key: the programs' common key, `host_key`.
    """
    return f"{_PREFIX}{key}-{uri}"


def listen(wish: str = "") -> tuple[socket.socket, str]:
    """Return a listening socket and its name.

    Args:
        wish: the preferred name; the socket gets another one if it is in use, or impossible.

    Raises:
        OSError: it cannot be created.
    """
    sock = socket.socket(socket.AF_UNIX)
    try:
        name = wish if _is_socket_name(wish) and _bind(sock, wish) else _PREFIX + os.urandom(16).hex()
        if name != wish:
            sock.bind("\0" + name)
        sock.listen(128)
    except BaseException:
        sock.close()
        raise
    return sock, name


def connect(name: str) -> socket.socket:
    """Return a socket that is connected to the one of that name, and does not block.

    Raises:
        OSError: it does not exist, is too busy, or belongs to another user.
    """
    if not _is_socket_name(name):
        raise ConnectionRefusedError(f"{name[:100]!r} is no name of such a socket")
    sock = socket.socket(socket.AF_UNIX)
    try:
        sock.setblocking(False)
        sock.connect("\0" + name)
        if not is_same_user(sock):
            raise PermissionError("the socket belongs to another user")
    except BaseException:
        sock.close()
        raise
    return sock


def _is_socket_name(name: str) -> bool:
    return name.startswith(_PREFIX) and len(name) <= 100 and name.isascii()


def _bind(sock: socket.socket, name: str) -> bool:
    try:
        sock.bind("\0" + name)
    except OSError:
        return False
    return True


def is_same_user(sock: socket.socket) -> bool:
    """Return whether a program of the same user is at the other end of a Unix socket."""
    found = sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    return bool(_CREDENTIALS.unpack(found)[1] == os.geteuid())
