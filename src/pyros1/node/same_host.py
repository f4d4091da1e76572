"""Unix sockets between programs of the same user on the same machine, in Linux's abstract namespace: they need no
files, so a killed program leaves nothing behind. Other systems lack this namespace; nodes use TCP there.
"""

from __future__ import annotations

import os
import socket
import struct
from collections.abc import Mapping
from functools import cache
from typing import Final

from pyros1.ground.md5 import md5_hex
from pyros1.wire.local import is_local_enabled

_PREFIX: Final = "pyros1-"
_CREDENTIALS: Final = struct.Struct("3i")  # struct ucred: process, user, group


@cache
def host_key() -> str:
    """Return the key of all programs that can share memory: programs of one user in one network namespace, since the
    last boot of the machine. It is an empty string if the system does not support this.
    """
    required = ((os, "memfd_create"), (os, "geteuid"), (socket, "SO_PEERCRED"), (socket, "send_fds"))
    if not all(hasattr(module, name) for module, name in required):
        return ""
    try:
        with open("/proc/sys/kernel/random/boot_id", encoding="utf-8") as file:
            boot_id = file.read()
        network_namespace = os.readlink("/proc/self/ns/net")
    except (OSError, ValueError):
        return ""
    return md5_hex(f"{boot_id} {network_namespace} {os.geteuid()}".encode())


def local_key(environ: Mapping[str, str]) -> str:
    """Return `host_key`, or an empty string if PYROS1_TRANSPORTS excludes the local transport.

    Raises:
        SettingError: the value of PYROS1_TRANSPORTS is invalid.
    """
    return host_key() if is_local_enabled(environ.get("PYROS1_TRANSPORTS", "")) else ""


def socket_name_for(uri: str, key: str) -> str:
    """Return the name of the Unix socket that local programs can use instead of the TCP port for services.

    Args:
        uri: URI of the port, as registered with the master: ``rosrpc://host:port``.
        key: the common key of the programs, see `host_key`.
    """
    return f"{_PREFIX}{key}-{uri}"


def listen(preferred_name: str = "") -> tuple[socket.socket, str]:
    """Return a listening socket and its name.

    Args:
        preferred_name: the name to use unless it is in use or not valid.

    Raises:
        OSError: the socket cannot be created.
    """
    sock = socket.socket(socket.AF_UNIX)
    try:
        if _is_socket_name(preferred_name) and _try_bind(sock, preferred_name):
            name = preferred_name
        else:
            name = _PREFIX + os.urandom(16).hex()
            sock.bind("\0" + name)
        sock.listen(128)
    except BaseException:
        sock.close()
        raise
    return sock, name


def connect(name: str) -> socket.socket:
    """Return a non-blocking socket that is connected to the listening socket with the given name.

    Raises:
        OSError: the listening socket does not exist, is too busy, or belongs to another user.
    """
    if not _is_socket_name(name):
        raise ConnectionRefusedError(f"{name[:100]!r} is not the name of a pyros1 socket")
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


def _try_bind(sock: socket.socket, name: str) -> bool:
    try:
        sock.bind("\0" + name)
    except OSError:
        return False
    return True


def is_same_user(sock: socket.socket) -> bool:
    """Return whether the peer of a Unix socket runs as the same user."""
    credentials = sock.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    return bool(_CREDENTIALS.unpack(credentials)[1] == os.geteuid())
