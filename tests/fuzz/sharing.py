"""Fuzzer of what a publisher of the same machine says about shared memory: references, blocks, what is given back."""

from __future__ import annotations

import contextlib
import os
import socket
import struct
from typing import Any

from pyros1.ground.errors import ProtocolError
from pyros1.node.publishing.block_pool import Block
from pyros1.node.subscribing.shared_source import SharedSource
from pyros1.wire import local

from .fuzzer import Fuzzer, words
from .wire import pieces

_TOKEN = bytes(range(16))
_HEADER = {"callerid": "/talker", "topic": "/t", "token": _TOKEN.hex()}
_REST = local.REFERENCE_SIZE - len(_TOKEN)
_SIZE = 4096


def records(data: bytes) -> None:
    """Read what comes over the desk, and references by themselves."""
    for piece in (data, *pieces(data)):
        with contextlib.suppress(ProtocolError):
            assert local.encode_block(*local.decode_block(piece)) == piece
        done = [local.encode_release(number) for number in local.decode_releases(piece)]
        assert piece.startswith(b"".join(done)) and len(piece) < 8 * (len(done) + 1)
        for body in (piece, _TOKEN + piece):
            with contextlib.suppress(ProtocolError):
                reference = local.decode_reference(_TOKEN, body)
                assert reference is None or local.encode_reference(_TOKEN, reference)[4:] == body


def source(data: bytes) -> None:
    """Follow references into a block: what comes out of them lies inside of it.

    Pieces of the size of a reference become one; others are messages. The last one comes over the desk, too.
    """
    records(data)
    near, far = socket.socketpair()
    desk, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    block = Block(1, _SIZE)
    with near, far, desk, theirs:
        link = SharedSource(far, "http://talker/", _HEADER, b"", desk)
        socket.send_fds(theirs, [local.encode_block(1, _SIZE)], [block.fd])
        bodies = [_TOKEN + piece if len(piece) == _REST else piece for piece in pieces(data)]
        if bodies and 0 < len(bodies[-1]) <= local.MAX_RECORD_SIZE:
            theirs.send(bodies[-1])
        near.sendall(b"".join(struct.pack("<I", len(body)) + body for body in bodies))
        near.shutdown(socket.SHUT_WR)
        try:
            while (batch := link.receive()) is not None:
                for item in batch.newest(len(batch)):
                    body: Any = item
                    whole = body if isinstance(body, bytes) else body.join()
                    assert len(whole) <= max(_SIZE, len(data))
        finally:
            block.close()


def _reference(offset: int, size: int, begin: int = 0, array: int = 0, block: int = 1) -> bytes:
    return local.encode_reference(_TOKEN, local.Reference(1, block, offset, size, begin, array))[4 + len(_TOKEN) :]


def _seeds() -> list[bytes]:
    step = bytes([_REST])
    many = [
        (0, 100),
        (4000, 96),
        (4000, 97),
        (0, 100, 4, 0),
        (0, 100, 4, 96),
        (0, 100, 4, 97),
        (0, 8, 8, 0),
        (0, 9, 4, 5),
    ]
    return [
        *(step + _reference(*each) for each in many),
        step + _reference(0, 10, block=2) + local.encode_block(2, _SIZE),
        step + _reference(0, 10) + local.encode_block(1, 0) + _reference(0, 1 << 40),
        b"\x05hello" + local.encode_release(7),
        b"\x08" + local.encode_release(1) + local.encode_release(1 << 63),
    ]


if hasattr(os, "memfd_create"):
    FUZZERS = {
        "local_transport": Fuzzer(
            source, (ProtocolError,), words(r"\0\0\0\0  \x01\0\0\0  \0\x10\0\0  \xff\xff\xff\xff"), _seeds
        )
    }
else:
    FUZZERS = {"local_transport": Fuzzer(records, (), (), _seeds)}
