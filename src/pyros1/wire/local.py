"""Protocol of the local transport between pyros1 nodes of the same user on the same machine. Pure.

Small messages and services use Unix sockets, large messages use shared memory.

* ``requestTopic``: in addition to ``["TCPROS"]``, the subscriber offers ``["PYROS1-LOCAL", KEY]``. Programs that can
  share memory have the same key. A publisher with that key responds with ``["PYROS1-LOCAL", NAME]``, the name of a Unix
  socket in the abstract namespace. All other publishers ignore the offer and respond with TCPROS.
* On that socket, headers and frames follow as over TCP. The publisher's header has an additional field, ``token``, and
  is sent together with a descriptor of another socket, the *control socket*.
* Services need no negotiation: in addition to the port of ``rosrpc://host:port``, a provider listens on a Unix socket
  whose name is derived from the key and that URI. A client that finds no such socket uses TCP. The first request can be
  sent together with the client's header.
* The body of a large message is in a *block* of shared memory; its frame is a reference, which begins with the token.
  The publisher sends each block over the control socket before the first reference to it. The subscriber sends back the
  numbers of references that it no longer needs; until then, the publisher does not change the block.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

from pyros1.ground.errors import ProtocolError, SettingError

PROTOCOL = "PYROS1-LOCAL"
TOKEN_SIZE = 16
MAX_RECORD = 4096
"""Maximum number of bytes of a record on the control socket."""

_REFERENCE = struct.Struct(f"<{TOKEN_SIZE}sQIIQQQ")
_BLOCK = struct.Struct("<IQ")
_NUMBER = struct.Struct("<Q")
REFERENCE_SIZE = _REFERENCE.size
_TRANSPORTS = ("local", "tcp")


class Reference(NamedTuple):
    """A message in shared memory.

    Attributes:
        number: of this reference; each link counts its own.
        block: number of the block.
        offset: first byte of the message's body in the block.
        size: bytes of the body.
        begin: first byte, in the body, of its large byte array; 0 if it has none.
        array: bytes of that array.
    """

    number: int
    block: int
    offset: int
    size: int
    begin: int
    array: int


def encode_reference(token: bytes, reference: Reference) -> bytes:
    """Return the frame of a reference."""
    return _REFERENCE.size.to_bytes(4, "little") + _REFERENCE.pack(token, *reference)


def decode_reference(token: bytes, body: bytes) -> Reference | None:
    """Return what a frame's body refers to, None if it is a message.

    Raises:
        ProtocolError: it is a reference, and impossible.
    """
    if len(body) != _REFERENCE.size or not body.startswith(token):
        return None
    reference = Reference(*_REFERENCE.unpack(body)[1:])
    if reference.begin and not 4 <= reference.begin <= reference.begin + reference.array <= reference.size:
        raise ProtocolError("the array of a message in shared memory is not inside of it")
    return reference


def encode_block(number: int, size: int) -> bytes:
    """Return the record that comes with a block's descriptor; or, of size 0, says that the block is no longer used."""
    return _BLOCK.pack(number, size)


def decode_block(record: bytes) -> tuple[int, int]:
    """Return number and size of a block.

    Raises:
        ProtocolError: the record is of another kind.
    """
    if len(record) != _BLOCK.size:
        raise ProtocolError(f"a record of {len(record)} bytes about shared memory")
    number, size = _BLOCK.unpack(record)
    return number, size


def encode_release(number: int) -> bytes:
    """Return the record that gives a reference back."""
    return _NUMBER.pack(number)


def decode_releases(record: bytes) -> Iterable[int]:
    """Return the numbers of the references that are given back; an incomplete one is left out."""
    return (number for (number,) in _NUMBER.iter_unpack(record[: len(record) // _NUMBER.size * _NUMBER.size]))


def offer(key: str) -> list[Any]:
    """Return the offer of a subscriber."""
    return [PROTOCOL, key]


def is_offered(protocols: list[Any], key: str) -> bool:
    """Return whether a subscriber that can share memory with programs of that key has offered to do so."""
    return bool(key) and [PROTOCOL, key] in protocols


def is_local_enabled(setting: str) -> bool:
    """Return whether PYROS1_TRANSPORTS has the local transport.

    Args:
        setting: such as ``local,tcp``; empty: the usual ones.

    Raises:
        SettingError: an unknown transport, or one that all nodes need is missing.
    """
    words = setting.replace(",", " ").split()
    unknown = [word for word in words if word not in _TRANSPORTS]
    if unknown:
        raise SettingError(f"PYROS1_TRANSPORTS: {unknown[0][:40]!r} is none of {', '.join(_TRANSPORTS)}")
    if words and "tcp" not in words:
        raise SettingError("PYROS1_TRANSPORTS needs tcp: it is how nodes of other machines and of stock ROS connect")
    return not words or "local" in words
