"""Finds a master's bridges and queries their statuses, which say what `pyros1 bridge` exchanges with other sites."""

from __future__ import annotations

import json
import socket
import struct
from collections.abc import Mapping
from functools import partial
from time import monotonic
from typing import Any

from pyros1.doctor.concurrent import run_concurrently
from pyros1.graph import Graph, SystemState
from pyros1.ground.errors import ProtocolError, ServiceError, ServiceUnavailableError
from pyros1.ground.terminal_text import one_line
from pyros1.net.hosts import parse_uri
from pyros1.wire.header import HeaderReader, encode_header

STATUS_SERVICE = "bridge_status"
"""Name, below the node's name, of the service (std_srvs/Trigger) that identifies bridges, and returns their status as
JSON."""
_TRIGGER_MD5 = "937c9679a518e3a18d831e57125ea522"
_MAX_STATUS = 8 << 20
TIMEOUT = 2.5
"""Seconds to wait for a bridge's answer."""


def find_providers(state: SystemState, service: str) -> list[str]:
    """Return the names, sorted, of the nodes that provide a service called ``service`` below their own name."""
    return sorted({node for name, nodes in state.services.items() for node in nodes if name == f"{node}/{service}"})


def fetch_statuses(graph: Graph, state: SystemState) -> dict[str, Mapping[str, Any] | Exception]:
    """Return the status of each bridge, or the reason why there is none, by the name of its node.

    Args:
        graph: asks the master.
        state: the master's state.
    """
    jobs = {name: partial(fetch_status, graph, name) for name in find_providers(state, STATUS_SERVICE)}
    return run_concurrently(jobs, TIMEOUT + 0.5)


def fetch_status(graph: Graph, name: str, timeout: float = TIMEOUT) -> Mapping[str, Any]:
    """Return the status of a bridge.

    Args:
        graph: asks the master.
        name: the bridge's node.
        timeout: seconds for the bridge's answer.

    Raises:
        ServiceError: the bridge does not answer, or its answer is not a status.
        MasterUnreachableError: the master does not respond.
    """
    service = f"{name}/{STATUS_SERVICE}"
    uri = graph.service_uri(service)
    if uri is None:
        raise ServiceUnavailableError(f"{service} is gone")
    return parse_status(call_trigger(service, uri, graph.master.caller_id, timeout))


def call_trigger(service: str, uri: str, caller_id: str, timeout: float = TIMEOUT) -> str:
    """Call a service of type std_srvs/Trigger and return its message, without a node.

    Args:
        service: the service's name.
        uri: its provider's URI, ``rosrpc://host:port``.
        caller_id: the caller's name.
        timeout: seconds for the whole call.

    Raises:
        ServiceError: the service cannot be reached, does not answer in time, refuses the call, or fails.
    """
    deadline = monotonic() + timeout
    request = {"callerid": caller_id, "service": service, "md5sum": _TRIGGER_MD5, "type": "std_srvs/Trigger"}
    try:
        with socket.create_connection(parse_uri(uri, "rosrpc"), timeout) as sock:
            sock.sendall(encode_header(request))
            reader, header = HeaderReader(), None
            while header is None:
                header = reader.feed(_receive(sock, 1, deadline))  # byte by byte, since the response may follow
            if "error" in header:
                raise ServiceError(f"{service}: {one_line(header['error'])}")
            sock.sendall(bytes(4))
            ok, size = struct.unpack("<BI", _receive(sock, 5, deadline))
            if size > _MAX_STATUS:
                raise ServiceError(f"{service} has sent a response that is too long")
            body = _receive(sock, size, deadline)
    except (OSError, ProtocolError) as error:
        raise ServiceUnavailableError(f"{service} does not answer: {error}") from error
    if not ok:
        raise ServiceError(f"{service}: {one_line(body.decode(errors='replace'), 200)}")
    if len(body) < 5 or len(body) != 5 + struct.unpack_from("<I", body, 1)[0]:
        raise ServiceError(f"{service} has sent a response of another type")
    return body[5:].decode(errors="replace")


def _receive(sock: socket.socket, size: int, deadline: float) -> bytes:
    received = bytearray()
    while len(received) < size:
        sock.settimeout(max(0.001, deadline - monotonic()))
        piece = sock.recv(min(size - len(received), 1 << 16))
        if not piece:
            raise ConnectionError("the connection was closed before the response")
        received += piece
    return bytes(received)


def parse_status(text: str) -> Mapping[str, Any]:
    """Parse a status.

    Raises:
        ServiceError: ``text`` is not a status.
    """
    try:
        status = json.loads(text) if len(text) <= _MAX_STATUS else None
    except (ValueError, RecursionError):
        status = None
    if not isinstance(status, dict) or not isinstance(status.get("site"), str):
        raise ServiceError("its response is not a status")
    return status
