"""Sites with keys on real connections: who may connect, and what each may send and read."""

from __future__ import annotations

import queue
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.key_expressions import Key, again_key, to_key, topic_key
from pyros1.bridge.transport.access_control import security_settings
from pyros1.bridge.transport.certificates import SiteKeys, load_keys, make_keys
from pyros1.bridge.transport.zenoh_link import ZenohLink

from ..conftest import PATIENCE, wait_until

pytest.importorskip("zenoh")
pytest.importorskip("cryptography")
ODOM = SharedName("red", "/odom")


class Site:
    """A link with keys, and what comes over it."""

    def __init__(self, keys: Path | SiteKeys, name: str, sites: list[str], **endpoints: list[str]) -> None:
        """`name` is the one that it uses; its keys may be those of another site."""
        self.packets: queue.Queue[tuple[Key, bytes]] = queue.Queue()
        settings = security_settings(load_keys(keys) if isinstance(keys, Path) else keys, sites)
        self.link = ZenohLink(name, self._receive, settings=settings, **endpoints)

    def _receive(self, key: Key, head: bytes, body: bytes) -> None:
        self.packets.put((key, body))

    def send(self, key: str, body: bytes) -> None:
        self.link.send(Send(key, b"head", body))

    def received_until(self, body: bytes, ask: Callable[[], object]) -> list[bytes]:
        """Repeat a question until this body comes, and return what came before it."""
        bodies: list[bytes] = []
        for _ in range(round(PATIENCE / 0.2)):
            ask()
            try:
                while True:
                    bodies.append(self.packets.get(timeout=0.2)[1])
                    if bodies[-1] == body:
                        return bodies[:-1]
            except queue.Empty:
                pass
        raise AssertionError(f"{body!r} did not come, but {bodies}")


@pytest.fixture
def port() -> int:
    with socket.socket() as unused:
        unused.bind(("127.0.0.1", 0))
        return int(unused.getsockname()[1])


@pytest.fixture
def keys(tmp_path: Path) -> Path:
    folder = tmp_path / "keys"
    make_keys(folder, {"red": [], "green": [], "stranger": [], "base": ["127.0.0.1"]})
    return folder


@pytest.fixture
def make_site() -> Iterator[Callable[..., Site]]:
    """Return a function that makes sites; those that were made last are closed first."""
    sites: list[Site] = []

    def make(*args: Any, **options: Any) -> Site:
        sites.append(Site(*args, **options))
        return sites[-1]

    yield make
    for site in reversed(sites):
        site.link.close()


def test_sites_with_keys_exchange_packets_through_a_base(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    """Feature: sites of a bridge prove their names: `pyros1 bridge keys` makes keys for mutual TLS -- each site writes
    only under its own name
    """
    base = make_site(keys / "base", "base", ["red", "green"], listen=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    green = make_site(keys / "green", "green", [], connect=[f"tls/127.0.0.1:{port}"])
    green.received_until(b"hello", lambda: red.send("hello", b"hello"))
    base.received_until(b"hello", lambda: red.send("hello", b"hello"))
    red.received_until(b"hi red", lambda: base.send(to_key("red"), b"hi red"))
    green.link.listen("red", topic_key(ODOM), True)
    green.received_until(b"odometry", lambda: red.send(topic_key(ODOM), b"odometry"))
    green.received_until(b"missed", lambda: red.send(again_key("green", ODOM), b"missed"))


def test_a_site_cannot_write_under_the_name_of_another_one(
    keys: Path, port: int, make_site: Callable[..., Site]
) -> None:
    base = make_site(keys / "base", "base", ["red", "green"], listen=[f"tls/127.0.0.1:{port}"])
    green = make_site(keys / "green", "green", [], connect=[f"tls/127.0.0.1:{port}"])
    liar = make_site(keys / "green", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    honest = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    liar.received_until(b"to all", lambda: base.send("hello", b"to all"))  # it is connected
    for site in (base, green):

        def ask() -> None:
            liar.send("hello", b"forged")
            liar.send(to_key("base"), b"forged")
            honest.send("hello", b"honest")

        ask()
        assert b"forged" not in site.received_until(b"honest", ask)


def test_packets_for_one_site_are_not_read_by_others(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    base = make_site(keys / "base", "base", ["red", "green"], listen=[f"tls/127.0.0.1:{port}"])
    spy = make_site(keys / "green", "red", [], connect=[f"tls/127.0.0.1:{port}"])  # subscribes to what is for red
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    red.received_until(b"secret", lambda: base.send(to_key("red"), b"secret"))

    def ask() -> None:
        base.send(to_key("red"), b"secret")
        base.send("hello", b"to all")

    assert b"secret" not in spy.received_until(b"to all", ask)


def test_a_site_that_is_not_named_gets_nothing(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    base = make_site(keys / "base", "base", ["red"], listen=[f"tls/127.0.0.1:{port}"])
    stranger = make_site(keys / "stranger", "stranger", [], connect=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])

    def ask() -> None:
        stranger.send("hello", b"here I am")
        base.send("hello", b"to all")
        red.send("hello", b"from red")

    base.received_until(b"from red", ask)
    red.received_until(b"to all", ask)
    assert b"here I am" not in base.received_until(b"from red", ask)
    assert stranger.packets.empty()


def test_keys_of_another_authority_do_not_connect(
    keys: Path, tmp_path: Path, port: int, make_site: Callable[..., Site]
) -> None:
    make_keys(tmp_path / "others", {"red": []})
    base = make_site(keys / "base", "base", [], listen=[f"tls/127.0.0.1:{port}"])
    other_keys = load_keys(tmp_path / "others" / "red")
    careful = make_site(other_keys, "red", [], connect=[f"tls/127.0.0.1:{port}"])
    trusting = other_keys._replace(ca_certificate=keys / "red" / "ca.crt")  # so only the base can refuse
    refused = make_site(trusting, "red", [], connect=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    red.received_until(b"hello", lambda: base.send("hello", b"hello"))
    for other in (careful, refused):
        wait_until(lambda other=other: other.link.problem, "it does not connect")
        assert other.packets.empty()


def test_a_base_at_another_address_is_not_trusted(keys: Path, port: int, make_site: Callable[..., Site]) -> None:
    """Otherwise any site could pass itself off as the base."""
    make_site(keys / "green", "base", [], listen=[f"tls/127.0.0.1:{port}"])
    red = make_site(keys / "red", "red", [], connect=[f"tls/127.0.0.1:{port}"])
    wait_until(lambda: red.link.problem, "it refuses the base")
