"""The ports that tests are given."""

from __future__ import annotations

import contextlib
import socket
import sys

import pytest

from .free_ports import Range, free_port


def test_ports_that_are_in_use_are_skipped() -> None:
    with socket.create_server(("127.0.0.1", free_port())) as server:
        assert server.getsockname()[1] not in {free_port() for _ in range(100)}


@pytest.mark.skipif(sys.platform != "linux", reason="there are no abstract socket names")
def test_two_processes_have_no_port_in_common() -> None:
    with contextlib.closing(Range()) as one, contextlib.closing(Range()) as other:
        assert not {next(one.ports) for _ in range(100)} & {next(other.ports) for _ in range(100)}
