"""resolve: look-ups that nobody need wait for."""

from __future__ import annotations

import threading

import pytest

from pyros1.net.resolve import HostLookup


def test_addresses_and_localhost_need_no_thread() -> None:
    before = threading.active_count()
    assert HostLookup("10.1.2.3").wait(0) == ["10.1.2.3"]
    assert HostLookup("::1").wait(0) == ["::1"]
    assert HostLookup("localhost").wait(0) == ["127.0.0.1", "::1"]
    assert threading.active_count() == before


def test_a_wait_ends_and_the_look_up_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = threading.Event()

    def resolve_host(host: str) -> list[str]:
        answer.wait(10)
        return ["10.0.0.1"]

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", resolve_host)
    pending = HostLookup("slow")
    with pytest.raises(TimeoutError, match="no answer from the name server"):
        pending.wait(0.01)
    answer.set()
    assert pending.wait(10) == pending.wait(0) == ["10.0.0.1"]


def test_a_name_that_does_not_exist(monkeypatch: pytest.MonkeyPatch) -> None:
    def resolve_host(host: str) -> list[str]:
        raise OSError(f"no {host}")

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", resolve_host)
    with pytest.raises(OSError, match="no nowhere"):
        HostLookup("nowhere").wait(10)


def test_giving_up_ends_a_wait(monkeypatch: pytest.MonkeyPatch) -> None:
    asked, answer = threading.Event(), threading.Event()

    def resolve_host(host: str) -> list[str]:
        asked.set()
        answer.wait(10)
        return ["10.0.0.1"]

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", resolve_host)
    pending = HostLookup("slow")
    closer = threading.Thread(target=lambda: asked.wait(10) and pending.cancel())
    closer.start()
    with pytest.raises(OSError, match="cancelled"):
        pending.wait(10)
    closer.join()
    answer.set()
