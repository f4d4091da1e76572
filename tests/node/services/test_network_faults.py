"""services: machines that are gone, silent name servers, slow links."""

from __future__ import annotations

import socket
import threading
from typing import Any

import pytest

from pyros1.ground.errors import ServiceError, WaitTimeoutError
from pyros1.msgs.std_srvs.srv import Empty, EmptyRequest, SetBool
from pyros1.net import timeouts
from pyros1.wire.header import encode_header

from ...parts import tcpros_port


def test_both_ends_notice_that_a_machine_is_gone_t37(
    make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    watched = collect()
    monkeypatch.setattr("pyros1.node.same_host.is_local_enabled", lambda setting: False)
    for place in ("provider_connection", "server"):
        monkeypatch.setattr(
            f"pyros1.node.services.{place}.set_nodelay_and_keepalive", lambda sock: watched(sock.getsockname())
        )
    make_node("server").advertise_service("s", SetBool, lambda request: (True, ""))
    assert make_node("caller").service("s", SetBool)(True).success
    one, other = watched.wait(2)
    assert one != other


@pytest.mark.parametrize("got_header", [False, True])
def test_a_call_ends_when_the_providers_machine_is_gone(
    make_node: Any, fake_node: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch, got_header: bool
) -> None:
    """A call without a time limit, whatever it waits for; see `is_gone`."""
    gone = threading.Event()
    monkeypatch.setattr("pyros1.node.services.provider_connection.is_peer_dead", lambda sock: gone.is_set())
    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    call = in_thread(make_node("caller").service("s", Empty))
    sock, _ = fake.accept()
    with sock:
        if got_header:
            sock.sendall(encode_header({"md5sum": Empty._md5sum}))
        gone.set()
        with pytest.raises(ServiceError, match="the provider's machine no longer answers"):
            call.join()


def test_a_silent_name_server(make_node: Any, fake_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A call, a wait and a shutdown end in time."""
    answer = threading.Event()
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda host: ["127.0.0.1"] * answer.wait(20))
    fake, caller = fake_node("/fake"), make_node("caller")
    fake.master.register_service("/s", "rosrpc://slow:1", fake.uri)
    with pytest.raises(WaitTimeoutError, match="/s"):
        caller.service("s", Empty).call(EmptyRequest(), timeout=0.05)
    with pytest.raises(WaitTimeoutError, match="/s"):
        caller.wait_for_service("s", timeout=0.05)
    answer.set()


def test_a_large_request_over_a_slow_link(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """It may take longer than a pause in it, while it moves."""
    now = [100.0]
    monkeypatch.setattr(timeouts, "monotonic", lambda: now[0])  # no time passes for the request ...
    monkeypatch.setattr("pyros1.node.services.client_connection.REQUEST_TIMEOUT", 0.05)
    server = make_node("server")
    server.advertise_service("s", SetBool, lambda request: (True, "whole"))
    with socket.create_connection(("localhost", tcpros_port(server)), timeout=10) as peer:
        peer.sendall(encode_header({"callerid": "/slow", "service": "/s", "md5sum": SetBool._md5sum}))
        peer.recv(65536)
        peer.sendall(b"\x01\0\0")
        threading.Event().wait(0.15)  # ... while more time than one pause may take passes for the loop
        peer.sendall(b"\0\x01")
        assert b"whole" in peer.recv(65536)
