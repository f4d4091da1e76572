"""Finds addresses of this machine, and encodes connection headers (https://wiki.ros.org/ROS/Connection%20Header)."""

from __future__ import annotations

import os
import socket
import struct
import sys
from collections.abc import Mapping
from typing import Any
from urllib.parse import urlsplit

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.ground import names
from pyros1.ground.errors import ProtocolError
from pyros1.net.hosts import LocalAddress, addresses_from_environment, interface_addresses, is_local
from pyros1.wire.header import MAX_HEADER_SIZE, decode_header, encode_header
from rosgraph.rosenv import ROS_HOSTNAME, ROS_IP, ROS_IPV6

SIOCGIFCONF, SIOCGIFADDR = 0x8912, 0x8915
"""Linux's ioctl numbers for the addresses of interfaces; programs import them from here."""
python3 = 1
__getattr__ = module_getattr(__name__)


class ROSHandshakeException(Exception):
    """A connection header is invalid or missing."""


def parse_http_host_and_port(url: str) -> tuple[str, int]:
    """Return host and port of an address; the default port is 80.

    Raises:
        ValueError: ``url`` is not an address.
    """
    if not url:
        raise ValueError("not a valid URL")
    parts = urlsplit(url)
    if not parts.hostname:
        raise ValueError("not a valid URL")
    return parts.hostname, parts.port or 80


def _special_arguments() -> dict[str, str]:
    return names.parse_arguments(sys.argv).special


def _local_host() -> LocalAddress:
    return addresses_from_environment(os.environ, _special_arguments())


def get_address_override() -> str | None:
    """Return the host or address of this machine that the command line or the environment sets, or None."""
    special = _special_arguments()
    for name in ("__hostname", "__ip"):
        if name in special:
            return special[name]
    return os.environ.get(ROS_HOSTNAME) or os.environ.get(ROS_IP) or None


def use_ipv6() -> bool:
    """Return whether IPv6 is enabled (``ROS_IPV6=on``)."""
    return os.environ.get(ROS_IPV6) == "on"


def is_local_address(hostname: str) -> bool:
    """Return whether a host name or address is this machine's."""
    return is_local(hostname)


def get_local_address() -> str:
    """Return the address at which others reach this machine."""
    override = get_address_override()
    if override:
        return override
    addresses = get_local_addresses()
    return next((address for address in addresses if not address.startswith("127.") and address != "::1"), addresses[0])


def get_local_addresses() -> list[str]:
    """Return the addresses of this machine."""
    loopback = "::1" if use_ipv6() else "127.0.0.1"
    return list(dict.fromkeys([*interface_addresses(use_ipv6()), loopback]))


def get_bind_address(address: str | None = None) -> str:
    """Return the address to listen on.

    Args:
        address: the address at which others reach this machine; None for the address in the environment.
    """
    if address is None:
        return _local_host().bind
    special = {"__hostname": address}
    return addresses_from_environment(os.environ, special).bind


def get_host_name() -> str:
    """Return the host name, or the address, at which others reach this machine."""
    return get_address_override() or _local_host().advertised


def create_local_xmlrpc_uri(port: int) -> str:
    """Return the address of an XML-RPC server of this machine."""
    host = get_host_name()
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def encode_ros_handshake_header(header: Mapping[str, Any]) -> bytes:
    """Encode a connection header as bytes, with a length prefix.

    Args:
        header: field -> value, text or bytes.

    Raises:
        TypeError: a value is neither text nor bytes.
    """
    fields = {}
    for key, value in header.items():
        if not isinstance(value, (str, bytes)):
            raise TypeError(f"the field {key} of a connection header must be text, not {type(value).__name__}")
        fields[key] = value.decode("utf-8", "surrogateescape") if isinstance(value, bytes) else value
    return encode_header(fields)


def decode_ros_handshake_header(header_str: bytes) -> dict[str, str]:
    """Return the fields of a connection header.

    Args:
        header_str: the header's bytes, with their length prefix; anything after them is ignored.

    Raises:
        ROSHandshakeException: the header is invalid or incomplete.
    """
    (size,) = struct.unpack("<I", header_str[:4])
    if size > len(header_str) - 4:
        have = len(header_str)
        raise ROSHandshakeException(f"Incomplete header. Expected {size + 8} bytes but only have {have}")
    try:
        return decode_header(header_str[4 : 4 + size])
    except ProtocolError as error:
        raise ROSHandshakeException(f"Invalid handshake header: {error}") from error


def read_ros_handshake_header(sock: Any, b: Any, buff_size: int) -> dict[str, str]:
    """Read a connection header from a socket.

    Args:
        sock: the socket.
        b: an `io.BytesIO` buffer for the bytes; bytes after the header are left in it.
        buff_size: number of bytes to read at once.

    Returns:
        The fields.

    Raises:
        ROSHandshakeException: the header is invalid, or the connection ended before it was complete.
    """
    header = None
    data = b.getvalue()
    while header is None:
        chunk = sock.recv(buff_size)
        if not chunk:
            raise ROSHandshakeException(
                "connection from sender terminated before handshake header received. "
                f"{len(data)} bytes were received. Please check sender for additional details."
            )
        data += chunk
        if len(data) >= 4:
            (size,) = struct.unpack("<I", data[:4])
            if size > MAX_HEADER_SIZE:
                raise ROSHandshakeException(f"Invalid handshake header: it claims {size} bytes")
            if len(data) >= 4 + size:
                header = decode_ros_handshake_header(data)
                data = data[4 + size :]
    b.seek(0)
    b.truncate(0)
    b.write(data)
    return header


def write_ros_handshake_header(sock: socket.socket, header: Mapping[str, Any]) -> int:
    """Send a connection header; return the number of bytes sent."""
    data = encode_ros_handshake_header(header)
    sock.sendall(data)
    return len(data)
