"""The protocol of the local transport between pyros1 nodes of the same user on the same machine.

Small messages and services use Unix sockets, large messages use shared memory.

* ``requestTopic``: in addition to ``["TCPROS"]``, the subscriber offers ``["PYROS1-LOCAL", KEY]``. Programs that can
  share memory have the same key. A publisher with that key responds with ``["PYROS1-LOCAL", NAME]``, the name of a Unix
  socket in the abstract namespace. All other publishers ignore the offer and respond with TCPROS.
* On that socket, headers and frames follow as over TCP. The publisher's header has an additional field, ``token``, and
  is sent together with a descriptor of another socket, the *control socket*.
* Services need no negotiation: in addition to the port of ``rosrpc://host:port``, a provider listens on a Unix socket
  whose name is derived from the key and that URI. A client that finds no such socket uses TCP. The first request can be
  sent together with the client's header.
* The body of a large message is in a *block* of shared memory. The frame sent for the message is a reference, which
  begins with the token. The publisher sends each block over the control socket before the first reference to it. The
  subscriber sends back the numbers of references that it no longer needs; until then, the publisher does not change
  the block.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

from pyros1.ground.errors import ProtocolError, SettingError

LOCAL_PROTOCOL = "PYROS1-LOCAL"
TOKEN_SIZE = 16
MAX_RECORD_SIZE = 4096
"""Maximum size in bytes of a record on the control socket."""

_REFERENCE = struct.Struct(f"<{TOKEN_SIZE}sQIIQQQ")
_BLOCK = struct.Struct("<IQ")
_RELEASE = struct.Struct("<Q")
REFERENCE_SIZE = _REFERENCE.size
_TRANSPORTS = ("local", "tcp")


class Reference(NamedTuple):
    """A message in shared memory.

    Attributes:
        number: number of this reference; each link numbers its own.
        block: number of the block.
        offset: offset of the message's body in the block.
        size: size of the body in bytes.
        array_begin: offset of the large byte array in the body; 0 if there is none.
        array_size: size of that array in bytes.
    """

    number: int
    block: int
    offset: int
    size: int
    array_begin: int
    array_size: int


def encode_reference(token: bytes, reference: Reference) -> bytes:
    """Return the frame that contains a reference."""
    return _REFERENCE.size.to_bytes(4, "little") + _REFERENCE.pack(token, *reference)


def decode_reference(token: bytes, body: bytes) -> Reference | None:
    """Return the reference in a frame's body, or None if the body is a message.

    Raises:
        ProtocolError: the reference is invalid.
    """
    if len(body) != _REFERENCE.size or not body.startswith(token):
        return None
    reference = Reference(*_REFERENCE.unpack(body)[1:])
    if (
        reference.array_begin
        and not 4 <= reference.array_begin <= reference.array_begin + reference.array_size <= reference.size
    ):
        raise ProtocolError("the array of a message in shared memory is not inside the message")
    return reference


def encode_block(block_number: int, size: int) -> bytes:
    """Return the record sent with a block's descriptor or, with size 0, when the block is no longer used."""
    return _BLOCK.pack(block_number, size)


def decode_block(record: bytes) -> tuple[int, int]:
    """Return the number and size of the block that a record is about.

    Raises:
        ProtocolError: the record is not about a block.
    """
    if len(record) != _BLOCK.size:
        raise ProtocolError(f"an invalid record of {len(record)} bytes about shared memory")
    block_number, size = _BLOCK.unpack(record)
    return block_number, size


def encode_release(reference_number: int) -> bytes:
    """Return the record that releases a reference."""
    return _RELEASE.pack(reference_number)


def decode_releases(record: bytes) -> Iterable[int]:
    """Return the numbers of the references that a record releases; an incomplete number at its end is ignored."""
    return (
        reference_number
        for (reference_number,) in _RELEASE.iter_unpack(record[: len(record) // _RELEASE.size * _RELEASE.size])
    )


def make_offer(key: str) -> list[Any]:
    """Return a subscriber's offer of the local transport."""
    return [LOCAL_PROTOCOL, key]


def is_offered(protocols: list[Any], key: str) -> bool:
    """Return whether a subscriber offers the local transport with that key."""
    return bool(key) and [LOCAL_PROTOCOL, key] in protocols


def is_local_enabled(setting: str) -> bool:
    """Return whether PYROS1_TRANSPORTS enables the local transport.

    Args:
        setting: the value, for example ``local,tcp``; empty for the default.

    Raises:
        SettingError: a transport is unknown, or tcp is missing, which all nodes need.
    """
    transports = setting.replace(",", " ").split()
    unknown = [word for word in transports if word not in _TRANSPORTS]
    if unknown:
        raise SettingError(f"PYROS1_TRANSPORTS: {unknown[0][:40]!r} is not one of {', '.join(_TRANSPORTS)}")
    if transports and "tcp" not in transports:
        raise SettingError(
            "PYROS1_TRANSPORTS needs tcp: nodes on other machines and nodes of stock ROS connect with it"
        )
    return not transports or "local" in transports
