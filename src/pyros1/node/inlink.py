"""The receiving end of a link from a publisher, over TCP."""

from __future__ import annotations

import socket
import struct

from pyros1.wire.framing import FrameBuffer

PATIENCE = 0.02
"""Seconds that a patient `receive` waits."""
_AT_ONCE = getattr(socket, "MSG_DONTWAIT", 0)


class InLink:
    """A TCP link from a publisher, past its handshake.

    Attributes:
        header: the publisher's connection header.
        uri: the publisher's slave API.
        messages, bytes_received: so far.
        patient: `receive` can wait for PATIENCE seconds; else it never waits.
    """

    transport = "TCPROS"

    def __init__(self, sock: socket.socket, uri: str, header: dict[str, str], first: bytes) -> None:
        self.sock = sock
        self.fd = sock.fileno()
        self.uri = uri
        self.header = header
        self.buffer = FrameBuffer(first=first)
        self.messages = 0
        self.bytes_received = len(first)
        self.patient = _make_patient(sock)
        try:
            peer, port = sock.getpeername(), sock.getsockname()[1]
            self.address = f"TCPROS connection on port {port} to [{peer[0]}:{peer[1]} on socket {self.fd}]"
        except OSError:
            self.address = "TCPROS connection on port 0 to [unknown]"

    def receive(self, wait: bool = False) -> int:
        """Receive into the buffer; return the number of bytes, 0 at the end of the stream.

        Args:
            wait: wait up to PATIENCE seconds, if the link is patient.

        Raises:
            BlockingIOError: nothing has come.
            OSError: the connection is broken.
        """
        return self.sock.recv_into(self.buffer.writable(), 0, 0 if wait else _AT_ONCE)


def _make_patient(sock: socket.socket) -> bool:
    """Let a plain receive wait in the kernel, but not for long, if the system can do both that and not waiting."""
    if not _AT_ONCE:
        sock.setblocking(False)
        return False
    sock.settimeout(None)
    sock.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("@ll", 0, int(PATIENCE * 1e6)))
    return True
