"""Requests to nodes: why a node does not respond."""

from __future__ import annotations

import socket

import pytest

from pyros1.doctor.facts import HANGS, REFUSED, TIMEOUT
from pyros1.doctor.probe import CONNECT_TIMEOUT, probe_node, query_node
from pyros1.graph import NodeApi
from pyros1.ground.errors import DeadlineError


def _time_out(api: NodeApi) -> None:
    raise DeadlineError("no response within 2.5 s")


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let all requests time out."""
    monkeypatch.setattr(NodeApi, "pid", _time_out)
    monkeypatch.setattr(NodeApi, "connections", _time_out)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("query", [probe_node, lambda caller_id, uri: query_node(caller_id, uri).failure])
def test_a_new_connection_tells_a_node_that_hangs_from_one_that_is_gone(query: object, closed_port: int) -> None:
    assert callable(query)
    with socket.create_server(("127.0.0.1", 0)) as silent:
        assert query("/test", f"http://127.0.0.1:{silent.getsockname()[1]}/").kind == HANGS
    failure = query("/test", f"http://127.0.0.1:{closed_port}/")
    assert failure.kind == REFUSED
    assert failure.text == "no response within 2.5 s"


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(
    ("addresses", "kind"),
    [
        (["refuses"], REFUSED),
        (["refuses", "silent"], TIMEOUT),
        (["silent", "refuses"], TIMEOUT),
        (["silent", "accepts"], HANGS),
        (["refuses", "accepts"], HANGS),
        ([], TIMEOUT),
    ],
)
def test_a_node_is_gone_only_if_all_addresses_of_its_host_refuse(
    addresses: list[str], kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    def connect(address: tuple[str, int], timeout: float) -> socket.socket:
        assert 0.0 < timeout <= CONNECT_TIMEOUT
        if address[0] != "accepts":
            raise ConnectionRefusedError if address[0] == "refuses" else TimeoutError
        return socket.socket()

    monkeypatch.setattr("pyros1.doctor.probe.socket.create_connection", connect)
    monkeypatch.setattr("pyros1.doctor.probe.HostLookup.wait", lambda lookup, timeout: addresses)
    failure = probe_node("/test", "http://robot:1234/")
    assert failure is not None
    assert failure.kind == kind
