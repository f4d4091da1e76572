from __future__ import annotations

import io
import socket

import pytest

from pyros1.web.web_video_server.request_reader import RequestReader


def test_bytes_that_trickle_do_not_extend_the_deadline() -> None:
    now = [100.0]
    client, server = socket.socketpair()
    with client, server, io.BufferedReader(RequestReader(server, 10.0, lambda: now[0])) as reader:
        for byte in b"GET /":
            client.sendall(bytes([byte]))
            assert reader.read1(10) == bytes([byte])
            assert server.gettimeout() == 110.0 - now[0]
            now[0] += 2.5
            if now[0] >= 110.0:
                break
        client.sendall(b"x")
        with pytest.raises(TimeoutError, match="not complete in time"):
            reader.read1(10)


def test_nothing_comes() -> None:
    client, server = socket.socketpair()
    with client, server, io.BufferedReader(RequestReader(server, 0.01)) as reader, pytest.raises(TimeoutError):
        reader.read1(10)


def test_the_end() -> None:
    client, server = socket.socketpair()
    with server, io.BufferedReader(RequestReader(server, 5.0)) as reader:
        client.sendall(b"a\nb")
        client.close()
        assert [reader.readline(), reader.readline(), reader.readline()] == [b"a\n", b"b", b""]
