"""Calls from elsewhere that are refused, and how errors are passed on."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.bridge.plugin_ros1 import services
from pyros1.bridge.plugin_ros1.keys import Kind, Resource
from pyros1.bridge.plugin_ros1.services import PluginServices
from pyros1.node import Node

MD5 = "09fb03525b03e7ea1fd3992bafd87e16"
SET = Resource(Kind.SERVICE, "std_srvs/SetBool", MD5, "*", "/set")


class Query:
    """A query of zenoh."""

    def __init__(self, payload: bytes | None = b"\x01") -> None:
        self.payload: Any = None if payload is None else Payload(payload)
        self.key_expr = "key"
        self.answer: bytes | None = None
        self.error: bytes | None = None
        self.dropped = threading.Event()

    def reply(self, key: str, answer: bytes) -> None:
        self.answer = answer

    def reply_err(self, error: bytes) -> None:
        self.error = error

    def drop(self) -> None:
        self.dropped.set()


class Payload(bytes):
    """The payload of a query."""

    def to_bytes(self) -> bytes:
        return bytes(self)


@pytest.fixture
def plugin_services(make_node: Callable[..., Node]) -> Iterator[PluginServices]:
    found = PluginServices(make_node("bridge"), None, lambda resource: resource.name)  # type: ignore[arg-type]
    yield found
    found.close()


def test_a_call_gets_one_answer(plugin_services: PluginServices, make_node: Callable[..., Node]) -> None:
    make_node("user").advertise_service("/set", "std_srvs/SetBool", lambda request: (request.data, "ok"))
    plugin_services.adjust({SET: "/set"}, {})
    query = Query()
    plugin_services.on_call("/set", query)
    assert query.dropped.wait(20) and query.answer == b"\x01\x02\x00\x00\x00ok" and query.error is None
    assert plugin_services.count("serves", "/set").calls == 1


def test_errors(plugin_services: PluginServices) -> None:
    plugin_services.adjust({SET: "/set"}, {})
    query = Query()
    plugin_services.on_call("/set", query)
    assert query.dropped.wait(20) and query.error == b"service [/set] unavailable: no node provides it"
    count = plugin_services.count("serves", "/set")
    assert (count.calls, count.errors, count.last_error) == (1, 1, query.error.decode())
    plugin_services.adjust({}, {})
    assert plugin_services.count("serves", "/set").calls == 0


def test_what_is_refused_at_once(plugin_services: PluginServices, monkeypatch: pytest.MonkeyPatch) -> None:
    plugin_services.adjust({SET: "/set"}, {})
    monkeypatch.setattr(services, "MAX_REQUEST", 3)
    for key, query in (("/other", Query()), ("/set", Query(None)), ("/set", Query(b"long"))):
        plugin_services.on_call(key, query)
        assert query.error == b"the bridge does not take this call"


def test_too_many_calls(
    make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
) -> None:
    monkeypatch.setattr(services, "MAX_CALLS", 1)
    bridge = PluginServices(make_node("bridge"), None, lambda resource: resource.name)  # type: ignore[arg-type]
    request.addfinalizer(bridge.close)
    entered, end = threading.Event(), threading.Event()

    def handle(_: object) -> tuple[bool, str]:
        entered.set()
        return end.wait(20), ""

    make_node("user").advertise_service("/set", "std_srvs/SetBool", handle)
    bridge.adjust({SET: "/set"}, {})
    first, second = Query(), Query()
    bridge.on_call("/set", first)
    assert entered.wait(20)
    bridge.on_call("/set", second)
    end.set()
    assert second.error == b"the bridge has too many calls at once"
    assert first.dropped.wait(20) and first.error is None
